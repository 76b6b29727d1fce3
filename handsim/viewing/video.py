"""Frames into files: video, animated GIF, contact sheets.

Files are encoded by the ffmpeg that comes with imageio-ffmpeg, under a temporary name, and are
renamed when they are whole.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.files import replacing
from handsim.viewing.overlay import draw_text
from handsim.viewing.stage import Frame

VIDEO_SUFFIXES: tuple[str, ...] = (".mp4", ".gif")
MAX_GIF_FPS = 50.0
"""GIF times frames in steps of 10 ms, and browsers slow down those shorter than 20 ms."""
_GIF_FILTER = "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer"
_MP4_OPTIONS = ["-crf", "20", "-preset", "medium", "-movflags", "+faststart"]


def write_video(frames: Iterable[Frame], path: Path | str, fps: float) -> int:
    """Encode frames as ``.mp4`` (H.264, yuv420p, which browsers play) or ``.gif``.

    Parameters
    ----------
    frames : (height, width, 3) each
        All of one size, which for mp4 is even.
    path
        Its suffix chooses the format; replaced only when all is written.
    fps
        Frames a second.

    Returns
    -------
    int
        Number of frames written.

    Raises
    ------
    InputError
        If the suffix, the size or the rate is not one the format can have, or there is no frame.
    FileError
        If the file cannot be written or the encoder fails.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in VIDEO_SUFFIXES:
        raise InputError(
            f"{path}: '{kind}' is not a video format; use {' or '.join(VIDEO_SUFFIXES)}"
        )
    if kind == ".gif" and fps > MAX_GIF_FPS:
        raise InputError(f"{path}: {fps:g} frames a second in a GIF; give {MAX_GIF_FPS:g} at most")
    with replacing(path) as temporary:
        stream = iter(frames)
        first = next(stream, None)
        if first is None:
            raise InputError(
                f"{path}: no frames to write; give a movement with one posture or more"
            )
        height, width = first.shape[:2]
        if kind == ".mp4" and (width % 2 or height % 2):
            even = f"{width + width % 2}x{height + height % 2}"
            raise InputError(f"{path}: size {width}x{height}; H.264 takes even sizes, give {even}")
        try:
            return _encode(chain([first], stream), temporary, fps, (width, height))
        except OSError as error:  # what imageio-ffmpeg raises when the encoder has stopped
            raise FileError(
                f"{path}: the encoder stopped ({_last_line(error)}); check the free disk space"
            ) from error


def _encode(frames: Iterator[Frame], path: Path, fps: float, size: tuple[int, int]) -> int:
    import imageio_ffmpeg

    gif = path.suffix.lower() == ".gif"
    writer = imageio_ffmpeg.write_frames(
        str(path),
        size,
        fps=fps,  # pyright: ignore[reportArgumentType]  # ffmpeg takes fractions
        codec="gif" if gif else "libx264",
        pix_fmt_out="pal8" if gif else "yuv420p",
        quality=None,  # pyright: ignore[reportArgumentType]  # the options below set it
        macro_block_size=1,
        ffmpeg_log_level="error",
        output_params=["-filter_complex", _GIF_FILTER] if gif else _MP4_OPTIONS,
    )
    count = 0
    writer.send(None)
    try:
        for frame in frames:
            if frame.shape[:2] != size[::-1]:
                raise InputError(f"frame {count} of {frame.shape[:2]}, others of {size[::-1]}")
            writer.send(np.ascontiguousarray(frame))
            count += 1
    finally:
        writer.close()
    return count


def _last_line(error: OSError) -> str:
    lines = [line for line in str(error).splitlines() if line.strip()]
    return lines[-1].strip() if lines else type(error).__name__


def tile(frames: Sequence[Frame], columns: int, gap: int = 0, fill: int = 255) -> Frame:
    """Set frames of one size side by side, row after row.

    Parameters
    ----------
    frames : (height, width, 3) each
    columns
        Frames in a row.
    gap
        Width of the lines between them [pixels].
    fill
        Grey of the lines and of places left empty, 0 to 255.
    """
    height, width = frames[0].shape[:2]
    columns = min(columns, len(frames))
    rows = math.ceil(len(frames) / columns)
    size = (rows * (height + gap) - gap, columns * (width + gap) - gap, 3)
    sheet = np.full(size, fill, np.uint8)
    for i, frame in enumerate(frames):
        top, left = (i // columns) * (height + gap), (i % columns) * (width + gap)
        sheet[top : top + height, left : left + width] = frame
    return sheet


def contact_sheet(
    frames: Sequence[Frame], labels: Sequence[str] = (), columns: int | None = None
) -> Frame:
    """Lay out frames of a movement as one picture, as the paper's Fig. 9.

    Parameters
    ----------
    frames : (height, width, 3) each
    labels
        One a frame, written into its lower left corner; none where left out.
    columns
        Frames in a row; by default about twice as many as rows.

    Returns
    -------
    (rows * height, columns * width, 3), with gaps of 2 pixels
    """
    if not frames:
        raise InputError("no frames for a contact sheet; give one or more")
    if labels and len(labels) != len(frames):
        raise InputError(f"{len(labels)} labels for {len(frames)} frames; give one each")
    columns = columns or max(1, round(math.sqrt(2 * len(frames))))
    cells = [frame.copy() for frame in frames]
    for cell, label in zip(cells, labels, strict=False):
        size = max(11, cell.shape[0] // 16)
        draw_text(cell, [label], (0.5 * size, cell.shape[0] - 1.6 * size), size)
    return tile(cells, columns, gap=2)


def write_image(image: Frame, path: Path | str) -> None:
    """Write a picture as ``.png``, as a whole or not at all.

    Raises
    ------
    InputError
        If the suffix is another one.
    """
    from PIL import Image

    path = Path(path)
    if path.suffix.lower() != ".png":
        raise InputError(f"{path}: pictures are written as .png; change the name")
    with replacing(path) as temporary:
        Image.fromarray(image).save(temporary, optimize=True)

"""Frames into files: video, animated GIF, contact sheets.

Files are encoded by the ffmpeg that comes with imageio-ffmpeg, under a temporary name, and are
renamed when they are whole.
"""

import math
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

import numpy as np

from handsim.disk import space_remedy
from handsim.errors import FileError, InputError, MissingToolError
from handsim.files import replacing
from handsim.types import Frame
from handsim.viewing.film.overlay import draw_text

VIDEO_SUFFIXES: tuple[str, ...] = (".mp4", ".gif")
MAX_GIF_FPS = 50.0
"""GIF times frames in steps of 10 ms, and browsers slow down those shorter than 20 ms."""
ENCODER_INSTALL = "pip install --force-reinstall imageio-ffmpeg"
"""Its wheels for the usual platforms carry an ffmpeg."""
_PALETTE = (
    "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=5"
)
_GIF_OPTIONS = ("-filter_complex", _PALETTE, "-loop", "0")
_MP4_OPTIONS = (
    *("-c:v", "libx264", "-pix_fmt", "yuv420p"),
    *("-vf", "scale=out_color_matrix=bt709", "-colorspace", "bt709"),  # else colours shift
    *("-color_primaries", "bt709", "-color_trc", "bt709"),
    *("-crf", "20", "-preset", "medium", "-movflags", "+faststart"),
)


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
    MissingToolError
        If there is no encoder.
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
        count, failure = _encode(chain([first], stream), temporary, fps)
        if failure:
            size = temporary.stat().st_size if temporary.exists() else 0
            remedy = (
                space_remedy(path, size) if "No space" in failure else "check the encoder's options"
            )
            raise FileError(f"{path}: the encoder stopped ({failure}); {remedy}")
    return count


def _encode(frames: Iterator[Frame], path: Path, fps: float) -> tuple[int, str]:
    """Pipe frames into ffmpeg; their number, and the last thing it said if it failed."""
    first = next(frames)
    height, width = first.shape[:2]
    options = _GIF_OPTIONS if path.suffix.lower() == ".gif" else _MP4_OPTIONS
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:.6g}"]
    command = [_encoder(), "-y", "-v", "error", *raw, "-i", "-", "-an"]
    count = 0
    with tempfile.TemporaryFile() as said:
        encoder = subprocess.Popen(
            [*command, *options, str(path)], stdin=subprocess.PIPE, stdout=said, stderr=said
        )
        assert encoder.stdin is not None  # a pipe was asked for
        try:
            with suppress(BrokenPipeError), encoder.stdin as pipe:
                for frame in chain([first], frames):
                    if frame.shape != first.shape:
                        raise InputError(
                            f"frame {count} has shape {frame.shape}, the first has {first.shape}; "
                            "give frames of one size"
                        )
                    pipe.write(np.ascontiguousarray(frame))
                    count += 1
        except BaseException:
            encoder.kill()
            raise
        finally:
            code = encoder.wait()
        said.seek(0)
        lines = said.read().decode(errors="replace").strip().splitlines()
    return count, (lines or [f"exit code {code}"])[-1] if code else ""


def _encoder() -> str:
    import imageio_ffmpeg

    try:
        return imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise MissingToolError(f"no ffmpeg to encode with; run: {ENCODER_INSTALL}") from error


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

"""Frames into files: video, animated GIF, contact sheets.

imageio encodes videos with the ffmpeg of imageio-ffmpeg, and pictures with Pillow. Each file is
written under a temporary name and renamed when it is whole.
"""

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

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
_OPTIONS: dict[str, dict[str, Any]] = {
    ".gif": {
        "codec": "gif",
        "pixelformat": "pal8",
        "output_params": ("-filter_complex", _PALETTE, "-loop", "0"),
    },
    ".mp4": {
        "codec": "libx264",
        "pixelformat": "yuv420p",
        "output_params": (
            *("-vf", "scale=out_color_matrix=bt709", "-colorspace", "bt709"),  # else colours shift
            *("-color_primaries", "bt709", "-color_trc", "bt709"),
            # Half the time of "medium", and of these films no more bytes.
            *("-crf", "20", "-preset", "veryfast", "-movflags", "+faststart"),
        ),
    },
}


def write_video(
    frames: Iterable[Frame], path: Path | str, fps: float, *, key_frame_every: int | None = None
) -> int:
    """Encode frames as ``.mp4`` (H.264, yuv420p, which browsers play) or ``.gif``.

    Parameters
    ----------
    frames : (height, width, 3) each
        All of one size, which for mp4 is even.
    path
        Its suffix chooses the format; replaced only when all is written.
    fps
        Frames a second.
    key_frame_every
        Of an mp4, how many frames apart a reader can start to decode; by default up to 250. Where
        it is said, no frame needs a later one.

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
        sent = _OneSize(chain([first], stream))
        if not _encode(sent, temporary, fps, key_frame_every):
            _append_zeros(temporary)  # raises where the system was what stopped it
            raise FileError(
                f"{path}: the encoder {_encoder()} stopped before the file was whole, after "
                f"{sent.count} frames; see whether 'handsim doctor' finds it in order"
            )
    return sent.count


class _OneSize:
    """Counts frames as they are taken, and checks that all have the size of the first."""

    def __init__(self, frames: Iterator[Frame]) -> None:
        self._frames = frames
        self.count = 0

    def __iter__(self) -> Iterator[Frame]:
        shape = None
        for frame in self._frames:
            shape = shape or frame.shape
            if frame.shape != shape:
                raise InputError(
                    f"frame {self.count} has shape {frame.shape}, the first has {shape}; "
                    "give frames of one size"
                )
            yield frame
            self.count += 1


def _encode(frames: Iterable[Frame], path: Path, fps: float, key_frame_every: int | None) -> bool:
    """Write frames through imageio's ffmpeg, and return whether the file is whole.

    imageio passes on neither ffmpeg's exit code nor its messages. It raises an error if ffmpeg
    stops reading; whether all was written is seen from the file.
    """
    import imageio.v3 as iio

    _encoder()
    # Otherwise imageio-ffmpeg forks the whole process to keep Ctrl-C from ffmpeg: unsafe beside
    # other threads, and a GIF would be encoded to its end before the interrupt takes effect.
    os.environ.setdefault("IMAGEIO_FFMPEG_NO_PREVENT_SIGINT", "1")
    kind = path.suffix.lower()
    options = dict(_OPTIONS[kind])
    # Without frames that need later ones, which some readers of single frames do not take.
    apart = () if key_frame_every is None else ("-g", str(key_frame_every), "-bf", "0")
    options["output_params"] = [*options["output_params"], *apart]  # imageio appends to it
    # `extension`: imageio offers its ffmpeg for films alone; ffmpeg itself goes by the path.
    file = iio.imopen(path, "w", plugin="FFMPEG", extension=".mp4", legacy_mode=True)
    writer = file.legacy_get_writer(
        input_params=["-r", f"{fps:.6g}"],  # older versions round `fps` to hundredths
        quality=None,  # `-crf` says it
        macro_block_size=1,  # else sizes that 16 does not divide are scaled up
        ffmpeg_log_level="fatal",  # of a full disk it would say much more than one line
        **options,
    )
    try:
        for frame in frames:
            writer.append_data(frame)
    except OSError as error:
        if not isinstance(error.__context__, BrokenPipeError):
            raise
        return False
    finally:
        writer.close()
    return _is_whole(path)


def _is_whole(path: Path) -> bool:
    """Return whether a video file holds the part that its encoder writes last.

    A GIF ends with the terminator of its last picture and the trailer. Of an mp4 with
    ``+faststart``, the index of all frames (``moov``) is put before the data at the very end.
    """
    with path.open("rb") as stream:
        if path.suffix.lower() == ".mp4":
            return b"moov" in stream.read(64)
        stream.seek(-2, os.SEEK_END)
        return stream.read() == b"\x00;"


def _append_zeros(path: Path, n: int = 65536) -> None:
    """Append to a file that an encoder left unfinished, to get the system's error, if any."""
    with path.open("ab") as stream:
        stream.write(bytes(n))


def _encoder() -> str:
    """Return the path of ffmpeg.

    Raises
    ------
    MissingToolError
        If there is none.
    """
    try:
        from imageio.plugins.ffmpeg import get_exe

        return get_exe()
    except (ImportError, RuntimeError) as error:
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


def usual_columns(n: int) -> int:
    """Return how many of n frames stand in a row: about twice as many as there are rows."""
    return max(1, round(math.sqrt(2 * n)))


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
    columns = columns or usual_columns(len(frames))
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
    import imageio.v3 as iio

    path = Path(path)
    if path.suffix.lower() != ".png":
        raise InputError(f"{path}: pictures are written as .png; change the name")
    # Encoded before the file is opened: on a full disk imageio would leave it open.
    encoded = iio.imwrite("<bytes>", image, plugin="pillow", extension=".png", optimize=True)
    with replacing(path) as temporary:
        temporary.write_bytes(encoded)

"""The films of a LeRobot data set: what a camera of the scene sees of one episode after another."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handsim.errors import InputError
from handsim.exports.episode_clip import bare_clip
from handsim.exports.lerobot.data_set_layout import VIDEO_MB, VIDEO_PATH, file_of, made
from handsim.exports.lerobot.feature_statistics import PixelCounts
from handsim.exports.lerobot.features import Take
from handsim.types import Frame, Progress
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.video import write_video
from handsim.viewing.opengl.backend import choose_backend

BYTES_A_PIXEL = 0.1
"""Of an encoded frame, at most; 0.05 in films of 160x120, less than 0.03 in larger ones."""
KEY_FRAME_EVERY = 2
"""So many frames apart a reader can start to decode, as in the films that LeRobot writes itself."""


@dataclass(frozen=True)
class Place:
    """Where the film of an episode is.

    Attributes
    ----------
    file
        Number of its file, from 0.
    start, end
        In the file [s].
    """

    file: int
    start: float
    end: float


@dataclass(frozen=True)
class Films:
    """The films of a data set.

    Attributes
    ----------
    key
        The name of their feature.
    view
        Its rate is that of the data set.
    places, counts
        Of each episode: where its film is, and its pixels.
    """

    key: str
    view: View
    places: list[Place]
    counts: list[PixelCounts]


def check_even(view: View) -> None:
    """Check that films of this size can be encoded.

    Raises
    ------
    InputError
        If width or height is odd.
    """
    if view.width % 2 or view.height % 2:
        even = f"{view.width + view.width % 2}x{view.height + view.height % 2}"
        raise InputError(f"size {view.width}x{view.height}; H.264 takes even sizes, give {even}")


def files_of(
    takes: Sequence[Take], view: View, max_bytes: float = VIDEO_MB * 2**20
) -> list[list[int]]:
    """Return which episodes are filmed into one file, so that none becomes much too large."""
    most = max(1.0, max_bytes / (BYTES_A_PIXEL * view.width * view.height))
    files: list[list[int]] = [[]]
    frames = 0
    for i, take in enumerate(takes):
        if files[-1] and frames + len(take.time) > most:
            files.append([])
            frames = 0
        files[-1].append(i)
        frames += len(take.time)
    return files


def places_of(takes: Sequence[Take], files: Sequence[Sequence[int]], fps: int) -> list[Place]:
    """Return where the film of each episode is."""
    places: list[Place] = []
    for number, members in enumerate(files):
        frame = 0
        for i in members:
            n = len(takes[i].time)
            places.append(Place(number, frame / fps, (frame + n) / fps))
            frame += n
    return places


def write_films(
    takes: Sequence[Take], folder: Path, view: View, progress: Progress | None = None
) -> Films:
    """Film all episodes into as few files as their sizes allow.

    Parameters
    ----------
    takes
    folder
        Of the data set.
    view
        Its rate is that of the data set.
    progress
        Called with the fraction done.

    Raises
    ------
    MissingToolError
        If nothing renders on this machine.
    UnknownNameError
        If there is no camera of that name.
    """
    choose_backend()
    key = f"observation.images.{view.camera}"
    counts = [PixelCounts() for _ in takes]
    files = files_of(takes, view)
    total, done = sum(len(take.time) for take in takes), 0
    for number, members in enumerate(files):

        def told(n_frames: int, before: int = done) -> None:
            if progress is not None:
                progress((before + n_frames) / total)

        path = made(folder / VIDEO_PATH.format(video_key=key, **file_of(number)))
        film([takes[i] for i in members], path, view, [counts[i] for i in members], told)
        done += sum(len(takes[i].time) for i in members)
    return Films(key, view, places_of(takes, files, int(view.fps)), counts)


def film(
    takes: Sequence[Take],
    path: Path,
    view: View,
    counts: Sequence[PixelCounts],
    told: Callable[[int], None],
) -> None:
    """Film episodes into one file.

    Parameters
    ----------
    takes
    path
        Its folder is there.
    view
        Its rate is that of the data set.
    counts
        One an episode, to which its frames are added.
    told
        Called after each frame, with how many there are so far.
    """

    def frames() -> Iterator[Frame]:
        done = 0
        for take, count in zip(takes, counts, strict=True):
            for frame in count.counting(render_clips([bare_clip(take.episode)], view)):
                done += 1
                told(done)
                yield frame

    write_video(frames(), path, view.fps, key_frame_every=KEY_FRAME_EVERY)


def video_feature(view: View) -> dict[str, Any]:
    """Return what ``info.json`` says about films."""
    return {
        "dtype": "video",
        "shape": [view.height, view.width, 3],
        "names": ["height", "width", "channels"],
        "info": {
            "video.height": view.height,
            "video.width": view.width,
            "video.codec": "h264",
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False,
            "video.fps": int(view.fps),
            "video.channels": 3,
            "has_audio": False,
        },
    }

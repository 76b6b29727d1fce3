"""Movements into frames: rollouts and posture sequences, alone or several in a grid."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from handsim.errors import InputError
from handsim.types import Array, Frame, Progress
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.clip_player import COMPANION, USUAL, Player
from handsim.viewing.film.grid import Grid
from handsim.viewing.film.offscreen import Offscreen, View, open_offscreen
from handsim.viewing.film.overlay import has_room
from handsim.viewing.film.video import (
    contact_sheet,
    usual_columns,
    write_image,
    write_video,
)
from handsim.viewing.stage.framing import Room

MAX_SHEET_PIXELS = 100_000_000
"""Largest contact sheet [pixels]; it needs six bytes a pixel while it is made."""


def frame_times(duration: float, fps: float) -> Array:
    """Return the times of the frames of a movement, from its start to its last full frame [s]."""
    return np.arange(math.floor(duration * fps + 1e-6) + 1) / fps


def _player(clip: Clip, offscreen: Offscreen, camera: str, size: tuple[int, int]) -> Player:
    """Return the player of a film: the usual camera has an inset where there is room."""
    roomy = has_room(*size)
    insets = clip.beside[:1] if clip.companion is None else (COMPANION,)
    beside = insets if camera == USUAL and roomy else ()
    return Player(clip, offscreen, camera, *beside, size=size, room=clip.room if roomy else Room())


def render_clips(clips: Sequence[Clip], view: View, columns: int | None = None) -> Iterator[Frame]:
    """Frames of one movement, or of several side by side in a grid, in true time.

    The shorter ones hold their last state until the longest is over.

    Parameters
    ----------
    clips
        What moves.
    view
        Its size is that of each movement's cell; cells of shorter rows are wider.
    columns
        Clips in a row; by default such that no place is empty.

    Yields
    ------
    (height, width, 3)
    """
    grid = Grid.of(len(clips), view.width, view.height, columns)
    with open_offscreen(max(grid.widths), view.height, view.shadows, view.quick) as offscreen:
        players = [
            _player(clip, offscreen, view.camera, (width, view.height))
            for clip, width in zip(clips, grid.widths, strict=True)
        ]
        cells: dict[int, Frame] = {}
        for time in frame_times(max(clip.shown for clip in clips), view.fps):
            for i, player in enumerate(players):
                if time <= player.clip.duration + 1 / view.fps:
                    cells[i] = player.draw(float(time))
            yield grid.assemble(list(cells.values())) if len(cells) > 1 else cells[0]


def render_sheet(clip: Clip, view: View, n: int = 8, columns: int | None = None) -> Frame:
    """Contact sheet of ``n`` states along a movement, each of the size of the view.

    The states are spread evenly over the length of the path of qpos, so that no two pictures are
    the same. Below each row of the usual view stand those of the cameras `Clip.beside`.

    Raises
    ------
    InputError
        If they are more than `MAX_SHEET_PIXELS` together.
    """
    rows = clip.beside if clip.companion is None else (*clip.beside, COMPANION)
    cameras = (view.camera, *(rows if view.camera == USUAL else ()))
    n_pictures = n * len(cameras)
    if n_pictures * view.width * view.height > MAX_SHEET_PIXELS:
        raise InputError(
            f"{n_pictures} pictures of {view.width}x{view.height} are more than "
            f"{MAX_SHEET_PIXELS} pixels; draw fewer or smaller ones"
        )
    times = _spread_times(clip, n)
    with open_offscreen(view.width, view.height, view.shadows, view.quick) as offscreen:
        room = clip.room_in_sheets if has_room(view.width, view.height) else Room()
        player = Player(clip, offscreen, *cameras, room=room)
        views = [player.draw_all(time) for time in times]
    columns = columns or usual_columns(len(times))
    frames: list[Frame] = []
    labels: list[str] = []
    for start in range(0, len(times), columns):
        row = range(start, min(start + columns, len(times)))
        for i, camera in enumerate(cameras):
            frames += [views[j][i] for j in row]
            labels += [_label(clip, times[j], camera, i) for j in row]
            empty = (columns - len(row)) * (len(cameras) > 1)
            frames += [np.full_like(views[0][0], 255)] * empty
            labels += [""] * empty
    return contact_sheet(frames, labels, columns)


def _label(clip: Clip, time: float, camera: str, row: int) -> str:
    """Return what is written into a picture: its time, where no overlay has it, or its camera."""
    if row:
        return "" if camera == COMPANION else camera
    return "" if clip.in_sheets else f"{time:.2f} s"


def _spread_times(clip: Clip, n: int) -> list[float]:
    """Return n times since the start at equal shares of the path's length, one where it stays."""
    steps = np.linalg.norm(np.diff(clip.qpos, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if length[-1] <= 0 or n < 2:
        return [0.0]
    # Time over length: standing still takes time but no length, so the last time of each
    # length is kept to make it a function.
    keep = np.append(np.diff(length) > 0, True)
    times = np.interp(np.linspace(0, float(length[-1]), n), length[keep], clip.time[keep])
    return (times - clip.time[0]).tolist()


def save_clips(
    clips: Sequence[Clip],
    path: Path | str,
    view: View,
    columns: int | None = None,
    n_postures: int = 8,
    progress: Progress | None = None,
) -> int:
    """Draw movements into a file whose suffix says what: ``.mp4``, ``.gif`` or ``.png``.

    Parameters
    ----------
    clips
        One, or several for a grid. A ``.png`` of one clip is its contact sheet; of several, one
        picture of each at its end.
    path
        Replaced only when all is drawn.
    view
        Its size is that of each movement, and of each picture of a contact sheet.
    columns
        Clips, or pictures of a contact sheet, in a row.
    n_postures
        Pictures in the contact sheet of one clip.
    progress
        Called with the fraction of a video's frames that are drawn.

    Returns
    -------
    int
        Number of frames or pictures.
    """
    if Path(path).suffix.lower() != ".png":
        frames = render_clips(clips, view, columns)
        if progress:
            n = len(frame_times(max((clip.shown for clip in clips), default=0.0), view.fps))
            frames = _counted(frames, n, progress)
        return write_video(frames, path, view.fps)
    if len(clips) == 1:
        write_image(render_sheet(clips[0], view, n_postures, columns), path)
        return n_postures
    grid = Grid.of(len(clips), view.width, view.height, columns)
    with open_offscreen(max(grid.widths), view.height, view.shadows, view.quick) as offscreen:
        frames = [
            _player(clip, offscreen, view.camera, (width, view.height)).draw(clip.duration)
            for clip, width in zip(clips, grid.widths, strict=True)
        ]
    write_image(grid.assemble(frames), path)
    return len(frames)


def _counted(frames: Iterator[Frame], n: int, progress: Progress) -> Iterator[Frame]:
    for i, frame in enumerate(frames, 1):
        yield frame
        progress(i / n)

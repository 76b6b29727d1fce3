"""Movements into frames: rollouts and posture sequences, alone or several in a grid."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.types import Array, Frame, Progress
from handsim.viewing.film.offscreen import (
    SIZE_LIMITS,
    Camera,
    LoadedModel,
    Offscreen,
    View,
    open_offscreen,
)
from handsim.viewing.film.video import contact_sheet, tile, write_image, write_video

MAX_SHEET_PIXELS = 100_000_000
"""Largest contact sheet [pixels]; it needs six bytes a pixel while it is made."""


class Overlay(Protocol):
    """Something drawn onto the frames of a clip."""

    def draw(self, frame: Frame, time: float) -> None:
        """Draw onto a frame, in place, as of ``time`` [s] since the clip's start."""
        ...


@dataclass(frozen=True, eq=False)
class Clip:
    """A movement of a model. Clips compare by identity, as MuJoCo's models do.

    Attributes
    ----------
    model
        The model that moves.
    time : (n,) [s]
        Increasing.
    qpos : (n, nq)
        MuJoCo's positions in the order of the model.
    overlays
        Drawn onto each frame, in order.
    """

    model: mujoco.MjModel
    time: Array
    qpos: Array
    overlays: tuple[Overlay, ...] = ()

    def __post_init__(self) -> None:
        """Check that the arrays belong together and to the model.

        Raises
        ------
        InputError
            If they do not.
        """
        n, nq = len(self.time), self.model.nq
        if n == 0 or self.qpos.shape != (n, nq):
            raise InputError(f"qpos of shape {self.qpos.shape} for {n} times; give ({n}, {nq})")
        if not np.all(np.diff(self.time) > 0):
            raise InputError("time of a movement does not increase; sort it")

    @property
    def duration(self) -> float:
        """Time from the first to the last state [s]."""
        return float(self.time[-1] - self.time[0])


def frame_times(duration: float, fps: float) -> Array:
    """Return the times of the frames of a movement, from its start to its last full frame [s]."""
    return np.arange(math.floor(duration * fps + 1e-6) + 1) / fps


class _Player:
    """Draws a clip at any time."""

    def __init__(self, clip: Clip, offscreen: Offscreen, camera: str) -> None:
        self.clip = clip
        self.scene: LoadedModel = offscreen.add(clip.model)
        self.data = mujoco.MjData(clip.model)
        self._pose(0.0)
        self.camera = Camera(clip.model, self.data, camera)

    def _pose(self, time: float) -> None:
        """Set the state at ``time`` [s] since the start; interpolate between samples."""
        model, clip = self.clip.model, self.clip
        at = clip.time[0] + min(time, clip.duration)
        i = min(int(np.searchsorted(clip.time, at, side="right")) - 1, len(clip.time) - 1)
        qpos = self.data.qpos
        qpos[:] = clip.qpos[i]
        if i + 1 < len(clip.time) and at > clip.time[i]:
            velocity = np.zeros(model.nv)
            step = float(clip.time[i + 1] - clip.time[i])
            mujoco.mj_differentiatePos(model, velocity, step, clip.qpos[i], clip.qpos[i + 1])
            mujoco.mj_integratePos(model, qpos, velocity, at - clip.time[i])
        mujoco.mj_kinematics(model, self.data)
        mujoco.mj_comPos(model, self.data)
        mujoco.mj_camlight(model, self.data)
        mujoco.mj_tendon(model, self.data)

    def draw(self, time: float) -> Frame:
        self._pose(time)
        self.camera.aim(self.clip.model, self.data, time)
        frame = self.scene.draw(self.data, self.camera.view)
        for overlay in self.clip.overlays:
            overlay.draw(frame, time)
        return frame


def render_clips(clips: Sequence[Clip], view: View, columns: int | None = None) -> Iterator[Frame]:
    """Frames of one movement, or of several side by side in a grid, in true time.

    The shorter ones hold their last state until the longest is over.

    Parameters
    ----------
    clips
        What moves.
    view
        Its size is that of the whole picture.
    columns
        Clips in a row; by default as many as rows, or one more.

    Yields
    ------
    (height, width, 3)
    """
    if not clips:
        raise InputError("no movements to draw; give one or more")
    columns = columns or math.ceil(math.sqrt(len(clips)))
    rows = math.ceil(len(clips) / columns)
    width, height = view.width // columns, view.height // rows
    if min(width, height) < SIZE_LIMITS[0]:
        raise InputError(
            f"{columns} x {rows} movements in {view.width}x{view.height} pixels leave "
            f"{width}x{height} each; give a size that leaves {SIZE_LIMITS[0]} or more"
        )
    with open_offscreen(width, height, view.shadows) as offscreen:
        players = [_Player(clip, offscreen, view.camera) for clip in clips]
        cells: dict[int, Frame] = {}
        for time in frame_times(max(clip.duration for clip in clips), view.fps):
            for i, player in enumerate(players):
                if time <= player.clip.duration + 1 / view.fps:
                    cells[i] = player.draw(float(time))
            yield _fit(tile(list(cells.values()), columns), view) if len(cells) > 1 else cells[0]


def _fit(sheet: Frame, view: View) -> Frame:
    """Pad the picture with white where it does not divide into whole cells."""
    height, width = sheet.shape[:2]
    if (width, height) == (view.width, view.height):
        return sheet
    full = np.full((view.height, view.width, 3), 255, np.uint8)
    full[:height, :width] = sheet
    return full


def render_sheet(clip: Clip, view: View, n: int = 8, columns: int | None = None) -> Frame:
    """Contact sheet of ``n`` states along a movement, each of the size of the view.

    The states are spread evenly over the length of the path of qpos, so that no two pictures are
    the same. Their times are written on them in place of the clip's overlays.

    Raises
    ------
    InputError
        If they are more than `MAX_SHEET_PIXELS` together.
    """
    if n * view.width * view.height > MAX_SHEET_PIXELS:
        raise InputError(
            f"{n} pictures of {view.width}x{view.height} are more than {MAX_SHEET_PIXELS} pixels;"
            " draw fewer or smaller ones"
        )
    steps = np.linalg.norm(np.diff(clip.qpos, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    times: Array = np.zeros(1)
    if length[-1] > 0 and n >= 2:
        # Time over length: standing still takes time but no length, so the last time of each
        # length is kept to make it a function.
        keep = np.append(np.diff(length) > 0, True)
        times = np.interp(np.linspace(0, float(length[-1]), n), length[keep], clip.time[keep])
        times = times - clip.time[0]
    with open_offscreen(view.width, view.height, view.shadows) as offscreen:
        player = _Player(replace(clip, overlays=()), offscreen, view.camera)
        frames = [player.draw(float(time)) for time in times]
    return contact_sheet(frames, [f"{time:.2f} s" for time in times], columns)


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
        Size of the whole video, of each picture of a contact sheet.
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
            n = len(frame_times(max((clip.duration for clip in clips), default=0.0), view.fps))
            frames = _counted(frames, n, progress)
        return write_video(frames, path, view.fps)
    if len(clips) == 1:
        write_image(render_sheet(clips[0], view, n_postures, columns), path)
        return n_postures
    with open_offscreen(view.width, view.height, view.shadows) as offscreen:
        players = (_Player(clip, offscreen, view.camera) for clip in clips)
        frames = [player.draw(player.clip.duration) for player in players]
    write_image(contact_sheet(frames, (), columns), path)
    return len(frames)


def _counted(frames: Iterator[Frame], n: int, progress: Progress) -> Iterator[Frame]:
    for i, frame in enumerate(frames, 1):
        yield frame
        progress(i / n)

"""Movements into frames: rollouts and posture sequences, alone or several in a grid."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.types import Array, Frame, Progress
from handsim.viewing.film.camera import FRAMED, Camera, standing_axes
from handsim.viewing.film.framing import Framing, Room, frame_movement
from handsim.viewing.film.grid import Grid
from handsim.viewing.film.offscreen import LoadedModel, Offscreen, View, open_offscreen
from handsim.viewing.film.overlay import has_room, inset_view
from handsim.viewing.film.video import (
    contact_sheet,
    usual_columns,
    write_image,
    write_video,
)

USUAL = "view"
"""The camera beside which others may be shown."""
COMPANION = "companion"
"""Stands among the cameras for the usual view of `Clip.companion`."""
INSET_SHARE = 0.34
"""Width and height of a second view in a film, over the film's own."""
UNMOVED = 4e-4
"""Change of joints, places and the camera below which a picture is not drawn again [rad], [m]."""
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
    in_sheets
        Drawn onto each picture of a contact sheet instead; by default it has its time alone.
    beside
        Cameras whose views stand beside the usual one, ``view``: of the first as an inset in
        films, of all as further rows in contact sheets. Another camera is shown alone.
    companion
        Another movement, shown beside the usual view: as the inset of films, in place of a camera,
        and as the last row of contact sheets.
    inset_below_caption
        Whether the inset is at the upper left instead of the lower right: an arm comes from there.
    pause
        How long a film shows the last state [s].
    room, room_in_sheets
        What the overlays leave free of films and of contact sheets; hand and object are there.
    """

    model: mujoco.MjModel
    time: Array
    qpos: Array
    overlays: tuple[Overlay, ...] = ()
    in_sheets: tuple[Overlay, ...] = ()
    beside: tuple[str, ...] = ()
    companion: "Clip | None" = None
    inset_below_caption: bool = False
    pause: float = 0.0
    room: Room = Room()  # noqa: RUF009
    room_in_sheets: Room = Room()  # noqa: RUF009

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

    @property
    def shown(self) -> float:
        """Time that a film of it lasts [s]."""
        return self.duration + self.pause


def frame_times(duration: float, fps: float) -> Array:
    """Return the times of the frames of a movement, from its start to its last full frame [s]."""
    return np.arange(math.floor(duration * fps + 1e-6) + 1) / fps


class _Player:
    """Draws a clip at any time from one camera or several, in pictures of one size."""

    def __init__(
        self,
        clip: Clip,
        offscreen: Offscreen,
        *cameras: str,
        size: tuple[int, int] | None = None,
        room: Room | None = None,
    ) -> None:
        self.clip = clip
        self.size = size or (offscreen.width, offscreen.height)
        self.scene: LoadedModel = offscreen.add(clip.model)
        self.data = mujoco.MjData(clip.model)
        self._pose(0.0)
        self.cameras: list[Camera | _Player] = [
            _Player(clip.companion, offscreen, USUAL, size=self.size)
            if clip.companion is not None and name == COMPANION
            else Camera(clip.model, self.data, name, self._framing(name, Room() if i else room))
            for i, name in enumerate(cameras)
        ]
        self._drawn: dict[int, tuple[Array, Frame]] = {}

    def _framing(self, camera: str, room: Room | None) -> Framing | None:
        """Return the way of a standing camera of the model, None for other cameras."""
        model = self.clip.model
        own = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA.value, camera) >= 0
        if camera not in FRAMED or not own:
            return None
        axes = standing_axes(model, self.data, camera)
        aspect = self.size[0] / self.size[1]
        time, qpos = self.clip.time, self.clip.qpos
        return frame_movement(model, time, qpos, axes, aspect, room or Room(), FRAMED[camera])

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
        """Return the first camera's view, the second's set into it, and the overlays on it."""
        self._pose(time)
        frame = self._view(0, time)
        if len(self.cameras) > 1:
            height, width = (round(INSET_SHARE * each) for each in frame.shape[:2])
            inset = self._view(1, time, (width, height))
            inset_view(frame, inset, self.clip.inset_below_caption)
        return self._finished(frame, time, self.clip.overlays)

    def draw_all(self, time: float) -> list[Frame]:
        """Return all cameras' views of a contact sheet, the overlays on the first."""
        self._pose(time)
        views = [self._view(i, time) for i in range(len(self.cameras))]
        return [self._finished(views[0], time, self.clip.in_sheets), *views[1:]]

    def _view(self, camera: int, time: float, size: tuple[int, int] | None = None) -> Frame:
        """Draw a camera's view, unless nothing has moved since it was drawn last."""
        shown = self.cameras[camera]
        if isinstance(shown, _Player):
            shown._pose(time)
            return shown._finished(shown._view(0, time, size), time, shown.clip.overlays)
        shown.aim(self.clip.model, self.data, time)
        view = shown.view
        sight = [*view.lookat, view.distance, np.deg2rad(view.azimuth), np.deg2rad(view.elevation)]
        state = np.concatenate([self.data.qpos, sight])
        before = self._drawn.get(camera)
        if before is None or np.abs(state - before[0]).max() > UNMOVED:
            before = self._drawn[camera] = (
                state,
                self.scene.draw(self.data, view, size or self.size),
            )
        return before[1].copy()

    def _finished(self, frame: Frame, time: float, overlays: tuple[Overlay, ...]) -> Frame:
        for overlay in overlays:
            overlay.draw(frame, min(time, self.clip.duration))
        return frame


def _player(clip: Clip, offscreen: Offscreen, camera: str, size: tuple[int, int]) -> _Player:
    """Return the player of a film: the usual camera has an inset where there is room."""
    roomy = has_room(*size)
    insets = clip.beside[:1] if clip.companion is None else (COMPANION,)
    beside = insets if camera == USUAL and roomy else ()
    return _Player(clip, offscreen, camera, *beside, size=size, room=clip.room if roomy else Room())


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
        player = _Player(clip, offscreen, *cameras, room=room)
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

"""A clip drawn at any time, from one camera or several."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.types import Array, Frame
from handsim.viewing.film.clip import Clip, Overlay
from handsim.viewing.film.offscreen import LoadedModel, Offscreen, place_for_drawing
from handsim.viewing.film.overlay import inset_view
from handsim.viewing.stage.camera import FRAMED, Camera, standing_axes
from handsim.viewing.stage.framing import Framing, Room, frame_movement

USUAL = "view"
"""The camera beside which others may be shown."""
COMPANION = "companion"
"""Stands among the cameras for the usual view of `Clip.companion`."""
INSET_SHARE = 0.34
"""Width and height of a second view in a film, over the film's own."""
UNMOVED = 4e-4
"""Change of joints, places and the camera below which a picture is not drawn again [rad], [m]."""


class Player:
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
        self.cameras: list[Camera | Player] = [
            Player(clip.companion, offscreen, USUAL, size=self.size)
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
        place_for_drawing(model, self.data)

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
        if isinstance(shown, Player):
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

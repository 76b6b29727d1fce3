"""Pictures of a run as it stands, off screen."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from contextlib import ExitStack

import mujoco

from handsim.types import Array, Frame
from handsim.viewing.film.offscreen import View, open_offscreen, place_for_drawing
from handsim.viewing.opengl.backend import choose_backend
from handsim.viewing.stage.camera import Camera


class Painter:
    """Draws the states of one model after the other.

    Parameters
    ----------
    view
        Camera and size of the pictures.
    """

    def __init__(self, view: View) -> None:
        self._view = view
        self._open = ExitStack()
        self._model: mujoco.MjModel | None = None

    def paint(self, model: mujoco.MjModel, qpos: Array, time: float) -> Frame:
        """Return a picture (height, width, 3) of a state (nq,) at a time of its run [s].

        Raises
        ------
        MissingToolError
            If nothing renders on this machine.
        UnknownNameError
            If there is no camera of that name.
        """
        if model is not self._model:
            self.close()
            self._load(model, qpos)
        self._pose(model, qpos)
        self._camera.aim(model, self._data, time)
        return self._loaded.draw(self._data, self._camera.view)

    def close(self) -> None:
        """Free what drawing needs; nothing if nothing was drawn."""
        self._open.close()
        self._model = None

    def _load(self, model: mujoco.MjModel, qpos: Array) -> None:
        choose_backend()
        view, self._data = self._view, mujoco.MjData(model)
        self._pose(model, qpos)
        self._camera = Camera(model, self._data, view.camera)
        offscreen = self._open.enter_context(open_offscreen(view.width, view.height, view.shadows))
        self._loaded, self._model = offscreen.add(model), model

    def _pose(self, model: mujoco.MjModel, qpos: Array) -> None:
        self._data.qpos[:] = qpos
        place_for_drawing(model, self._data)

"""Drawing models off screen: the OpenGL context, and the models loaded in it.

All models of a picture share the context, so that a grid of rollouts opens one and not many.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import atexit
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.types import Frame
from handsim.viewing.opengl.backend import (
    GLContext,
    choose_backend,
    does_not_open,
    driver_name,
    gl_context,
    is_software,
)
from handsim.viewing.stage.furniture import draw_furniture, furniture_of

_MAX_GEOMS = 4000
_QUICK_SLICES, _QUICK_STACKS = 16, 10
"""Faces round a part and along it, of pictures drawn quickly; MuJoCo's usual ones are 28 and 16."""
_SHADOW_CLIP = 2.0
"""Half of the width over which shadows fall, in extents of the model. At MuJoCo's 1, lit surfaces
are dotted where the light grazes them, such as a forearm."""
SIZE_LIMITS = (16, 4096)
"""Least and greatest width and height [pixels]."""


@dataclass(frozen=True)
class View:
    """Camera, size and frame rate of a picture or video.

    Attributes
    ----------
    camera
        One of `handsim.viewing.stage.camera.CAMERAS`, or the name of a camera in the model.
    width, height
        Size of the picture [pixels].
    fps
        Frames a second.
    shadows
        None draws them unless the driver draws on the CPU, where they take most of the time.
    quick
        Draws with edges that are not smoothed and round parts of fewer faces: for small pictures,
        three times as fast where the CPU draws.
    """

    camera: str = "view"
    width: int = 640
    height: int = 480
    fps: float = 30.0
    shadows: bool | None = None
    quick: bool = False

    def __post_init__(self) -> None:
        """Check size and rate.

        Raises
        ------
        InputError
            If one is outside what can be drawn and encoded.
        """
        low, high = SIZE_LIMITS
        for name, value in (("width", self.width), ("height", self.height)):
            if not low <= value <= high:
                raise InputError(f"{name} of {value} pixels; give {low} to {high}")
        if not 1 <= self.fps <= 240:
            raise InputError(f"{self.fps:g} frames a second; give 1 to 240")


def parse_size(text: str) -> tuple[int, int]:
    """Read a size given as ``WIDTHxHEIGHT``.

    Raises
    ------
    InputError
        If it is not two whole numbers.
    """
    parts = text.lower().replace("×", "x").split("x")
    # Python refuses to read whole numbers of thousands of digits.
    if len(parts) != 2 or not all(p.strip().isdecimal() and len(p) < 10 for p in parts):
        raise InputError(f"size '{text[:40]}' is not WIDTHxHEIGHT; give one like 640x480")
    return int(parts[0]), int(parts[1])


class Offscreen:
    """Draws models into pictures of one size; made by `open_offscreen`."""

    def __init__(
        self,
        width: int,
        height: int,
        shadows: bool,
        gl: GLContext,
        closing: ExitStack,
        quick: bool = False,
    ) -> None:
        self.width, self.height, self.shadows, self.quick = width, height, shadows, quick
        self._gl, self._closing = gl, closing

    def add(self, model: mujoco.MjModel) -> "LoadedModel":
        """Load a model's meshes and textures for drawing; freed with the context."""
        self.make_current()
        vis, quality, shade = model.vis.global_, model.vis.quality, model.vis.map
        kept = vis.offwidth, vis.offheight, quality.shadowsize, shade.shadowclip
        finer = quality.offsamples, quality.numslices, quality.numstacks
        if self.quick:
            quality.offsamples = 0
            quality.numslices, quality.numstacks = _QUICK_SLICES, _QUICK_STACKS
        # The buffers are made as large as the picture, and none for shadows that are not drawn:
        # at MuJoCo's usual 4096 x 4096 that one alone takes 64 MB.
        vis.offwidth, vis.offheight = self.width, self.height
        quality.shadowsize = quality.shadowsize if self.shadows else 0
        shade.shadowclip = max(shade.shadowclip, _SHADOW_CLIP)
        try:
            context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        except mujoco.FatalError as error:  # a driver without what MuJoCo needs
            raise does_not_open(choose_backend(), error) from error
        finally:
            vis.offwidth, vis.offheight, quality.shadowsize, shade.shadowclip = kept
            quality.offsamples, quality.numslices, quality.numstacks = finer
        self._closing.callback(self._free, context)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        return LoadedModel(self, model, context)

    def make_current(self) -> None:
        """Direct what this thread draws to this context."""
        self._gl.make_current()

    def _free(self, context: mujoco.MjrContext) -> None:
        self.make_current()
        context.free()


def place_for_drawing(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute from the positions of a state what is drawn of it: bodies, lights and tendons."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    mujoco.mj_tendon(model, data)


class LoadedModel:
    """A model whose meshes and textures are loaded into an offscreen context."""

    def __init__(
        self, offscreen: Offscreen, model: mujoco.MjModel, context: mujoco.MjrContext
    ) -> None:
        self.model = model
        self._offscreen, self._context = offscreen, context
        self._scene = mujoco.MjvScene(model, _MAX_GEOMS)
        self._option = mujoco.MjvOption()
        self._furniture = furniture_of(model)
        self._pixels = np.empty((offscreen.height * offscreen.width, 3), np.uint8)

    def draw(
        self, data: mujoco.MjData, camera: mujoco.MjvCamera, size: tuple[int, int] | None = None
    ) -> Frame:
        """Draw a state whose positions are computed.

        Parameters
        ----------
        data
        camera
        size
            Width and height [pixels], if less than that of the context.

        Returns
        -------
        (height, width, 3)
            A new array, top row first.
        """
        width, height = size or (self._offscreen.width, self._offscreen.height)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self.model, data, self._option, None, camera, everything, self._scene
        )
        draw_furniture(self._scene, self._furniture)
        self._offscreen.make_current()
        mujoco.mjr_restoreBuffer(self._context)  # another scene's may be bound
        rectangle, pixels = mujoco.MjrRect(0, 0, width, height), self._pixels[: height * width]
        mujoco.mjr_render(rectangle, self._scene, self._context)
        pixels = pixels.reshape(height, width, 3)
        mujoco.mjr_readPixels(pixels, None, rectangle, self._context)
        return pixels[::-1].copy()  # OpenGL's first row is the bottom one


@contextmanager
def open_offscreen(
    width: int, height: int, shadows: bool | None = None, quick: bool = False
) -> Generator[Offscreen, None, None]:
    """Open the OpenGL context and free it, with all that was loaded into it, at the end.

    Parameters
    ----------
    width, height
        Size of every picture [pixels].
    shadows, quick
        As in `View`.

    Raises
    ------
    MissingToolError
        If no backend renders.
    """
    with ExitStack() as closing:
        gl = closing.enter_context(gl_context())
        # A movement of which not all frames were taken must not be left to the interpreter's end,
        # when the libraries that free the context are half gone.
        atexit.register(closing.close)
        closing.callback(atexit.unregister, closing.close)
        drawn = not is_software(driver_name()) if shadows is None else shadows
        yield Offscreen(width, height, drawn, gl, closing, quick)

"""Drawing models off screen: the OpenGL context, the models loaded in it, and the cameras.

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

from handsim.errors import InputError, UnknownNameError
from handsim.types import Array, Frame
from handsim.viewing.film.chair import direction_deg, eyes_of
from handsim.viewing.film.furniture import draw_furniture, furniture_of
from handsim.viewing.opengl.backend import (
    GLContext,
    choose_backend,
    does_not_open,
    driver_name,
    gl_context,
    is_software,
)

CAMERAS: tuple[str, ...] = ("view", "front", "side", "palm", "top", "chair", "orbit", "follow")
"""Names of the cameras. All but the moving ones are the model's own where it has them."""
_MOVING = ("chair", "orbit", "follow")
_VIEWS = {  # direction of sight in the world [deg]: azimuth (from +x, mirrored where the thumb is
    # on the other side), elevation
    "view": (-140.0, -15.0),
    "front": (180.0, -15.0),
    "side": (-90.0, -10.0),
    "palm": (180.0, 0.0),
    "top": (180.0, -89.0),
    "chair": (0.0, -35.0),  # of a hand with nothing to sit at
    "orbit": (-140.0, -15.0),
    "follow": (-140.0, -20.0),
}
ORBIT_PERIOD_S = 8.0
"""Time of one turn of the orbiting camera [s]."""
_CHAIR_HEIGHT = 1.3
"""Height of what is seen from the chair, in hand lengths."""
FOLLOW_TIME_S = 0.3
"""Time constant with which the following camera lags behind the hand [s]."""
_MAX_GEOMS = 4000
SIZE_LIMITS = (16, 4096)
"""Least and greatest width and height [pixels]."""


@dataclass(frozen=True)
class View:
    """Camera, size and frame rate of a picture or video.

    Attributes
    ----------
    camera
        One of `CAMERAS`, or the name of a camera in the model.
    width, height
        Size of the picture [pixels].
    fps
        Frames a second.
    shadows
        None draws them unless the driver draws on the CPU, where they take most of the time.
    """

    camera: str = "view"
    width: int = 640
    height: int = 480
    fps: float = 30.0
    shadows: bool | None = None

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


class Camera:
    """A named camera on a model: the model's own, or one placed about the hand.

    Parameters
    ----------
    model
        The model looked at.
    data
        Its state at the start, with positions computed: the camera is aimed by it.
    name
        One of `CAMERAS`, or the name of a camera in the model.

    Raises
    ------
    UnknownNameError
        If there is no camera of that name.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, name: str) -> None:
        own = tuple(model.camera(i).name for i in range(model.ncam))
        if name not in CAMERAS and name not in own:
            raise UnknownNameError("camera", name, tuple(dict.fromkeys((*CAMERAS, *own))))
        self.name = name
        self.view = mujoco.MjvCamera()
        if name in own and name not in _MOVING:
            self.view.type = mujoco.mjtCamera.mjCAMERA_FIXED
            self.view.fixedcamid = model.camera(name).id
            return
        self.view.type = mujoco.mjtCamera.mjCAMERA_FREE
        azimuth, self.view.elevation = _VIEWS[name]
        self.view.azimuth = azimuth * _thumb_side(model, data)
        centre, self.view.distance = _framing(model, data, name)
        self.view.lookat[:] = centre
        self._start_azimuth = self.view.azimuth
        self._last_time: float | None = None

    def aim(self, model: mujoco.MjModel, data: mujoco.MjData, time: float) -> None:
        """Turn or move the camera to where it is at ``time`` [s]."""
        if self.name == "orbit":
            self.view.azimuth = self._start_azimuth + 360.0 * time / ORBIT_PERIOD_S
        elif self.name == "chair" and _body(model, "object") >= 0:
            self.view.lookat[:] = _grasp_centre(model, data)
            eyes = eyes_of(model, data)
            self.view.azimuth, self.view.elevation = direction_deg(eyes, self.view.lookat)
        elif self.name == "follow":
            elapsed = 0.0 if self._last_time is None else max(0.0, time - self._last_time)
            self._last_time = time
            share = 1.0 - np.exp(-elapsed / FOLLOW_TIME_S)
            self.view.lookat += share * (_hand_centre(model, data) - self.view.lookat)


def _body(model: mujoco.MjModel, name: str) -> int:
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, name)


def _knuckle(model: mujoco.MjModel, finger: str) -> int:
    """Return the body at a finger's knuckle, -1 without: in robot hands, its first one."""
    own = _body(model, f"{finger}_proximal")
    names = (model.body(i).name for i in range(model.nbody)) if own < 0 else ()
    return next((i for i, name in enumerate(names) if name.startswith(f"{finger}_")), own)


def _hand_centre(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Knuckle of the middle finger; the centre of the model where there is no hand."""
    knuckle = _knuckle(model, "middle")
    return data.xpos[knuckle].copy() if knuckle >= 0 else model.stat.center.copy()


def _grasp_centre(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Middle of knuckle and ends of middle finger and thumb: what is grasped is between them."""
    parts = [_body(model, name) for name in ("middle_proximal", "middle_distal", "thumb_distal")]
    return data.xpos[parts].mean(axis=0) if min(parts) >= 0 else _hand_centre(model, data)


def _thumb_side(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Return 1 where the index finger is further to +y than the little one, else -1."""
    index, little = _knuckle(model, "index"), _knuckle(model, "little")
    return -1.0 if min(index, little) >= 0 and data.xpos[index, 1] < data.xpos[little, 1] else 1.0


def _framing(model: mujoco.MjModel, data: mujoco.MjData, camera: str) -> tuple[Array, float]:
    """Point to look at and distance [m] that hold the hand, and the object where there is one.

    A hand of length L about its knuckle fits into 1.5 L. With an object the hand comes from up to
    two of its lengths away and lifts by half of one.
    """
    palm, knuckle = _body(model, "palm"), _knuckle(model, "middle")
    if palm < 0 or knuckle < 0:
        return model.stat.center.copy(), 1.5 * model.stat.extent
    # The knuckle of the middle finger is about 0.47 of the hand's length from the wrist.
    hand_length = float(np.linalg.norm(data.xpos[knuckle] - data.xpos[palm])) / 0.47
    target = _body(model, "object")
    if camera in ("chair", "follow") or target < 0:
        # From the chair the hand is to fill the picture; the other views show more beside it.
        height = (_CHAIR_HEIGHT if camera == "chair" and target >= 0 else 1.6) * hand_length
        centre = _hand_centre(model, data)
    else:
        centre = data.xpos[target] + np.array([0.0, 0.0, 0.5 * hand_length])
        height = 2.2 * hand_length
    return centre, 0.5 * height / np.tan(np.deg2rad(model.vis.global_.fovy) / 2)


class Offscreen:
    """Draws models into pictures of one size; made by `open_offscreen`."""

    def __init__(
        self, width: int, height: int, shadows: bool, gl: GLContext, closing: ExitStack
    ) -> None:
        self.width, self.height, self.shadows = width, height, shadows
        self._gl, self._closing = gl, closing

    def add(self, model: mujoco.MjModel) -> "LoadedModel":
        """Load a model's meshes and textures for drawing; freed with the context."""
        self.make_current()
        vis, quality = model.vis.global_, model.vis.quality
        kept = vis.offwidth, vis.offheight, quality.shadowsize
        # The buffers are made as large as the picture, and none for shadows that are not drawn:
        # at MuJoCo's usual 4096 x 4096 that one alone takes 64 MB.
        vis.offwidth, vis.offheight = self.width, self.height
        quality.shadowsize = quality.shadowsize if self.shadows else 0
        try:
            context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        except mujoco.FatalError as error:  # a driver without what MuJoCo needs
            raise does_not_open(choose_backend(), error) from error
        finally:
            vis.offwidth, vis.offheight, quality.shadowsize = kept
        self._closing.callback(self._free, context)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        return LoadedModel(self, model, context)

    def make_current(self) -> None:
        """Direct what this thread draws to this context."""
        self._gl.make_current()

    def _free(self, context: mujoco.MjrContext) -> None:
        self.make_current()
        context.free()


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
    width: int, height: int, shadows: bool | None = None
) -> Generator[Offscreen, None, None]:
    """Open the OpenGL context and free it, with all that was loaded into it, at the end.

    Parameters
    ----------
    width, height
        Size of every picture [pixels].
    shadows
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
        yield Offscreen(width, height, drawn, gl, closing)

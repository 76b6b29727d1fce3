"""Cameras: the model's own, those placed about the hand, and the eyes of the person at the table.

From the chair the person is seen to look over the shoulder: the eyes stay where they are and look
at the hand. They are drawn nearer along their line of sight, so that the hand fills the picture and
neither shoulder nor trunk comes before it.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.arm.arm_geometry import SHOULDER_OF_STATURE
from handsim.errors import UnknownNameError
from handsim.types import Array
from handsim.viewing.stage.framing import Framing

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
FRAMED = {"view": 0.24, "front": 0.5, "side": 0.5, "top": 0.5}
"""Standing cameras of scenes, which keep their direction and come as near as there is room, and the
least height that they show about the hand [m]: the person is to be seen from all but the first."""
ORBIT_PERIOD_S = 8.0
"""Time of one turn of the orbiting camera [s]."""
_CHAIR_HEIGHT = 1.3
"""Height of what is seen from the chair, in hand lengths."""
FOLLOW_TIME_S = 0.3
"""Time constant with which the following camera lags behind the hand [s]."""
_EYES = 0.118
"""Height of the eyes over the shoulders, / stature: 0.936 less 0.818 (Drillis and Contini 1966)."""
_USUAL = np.array([-0.42, 0.0, 0.50])
"""Eyes of a person of median size, for a hand that no arm carries [m]."""


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
    framing
        Way along which a standing camera of the model goes, with its direction kept.

    Raises
    ------
    UnknownNameError
        If there is no camera of that name.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        name: str,
        framing: Framing | None = None,
    ) -> None:
        own = tuple(model.camera(i).name for i in range(model.ncam))
        if name not in CAMERAS and name not in own:
            raise UnknownNameError("camera", name, tuple(dict.fromkeys((*CAMERAS, *own))))
        self.name = name
        self.view = mujoco.MjvCamera()
        self._framing = framing
        if framing is not None:
            self.view.type = mujoco.mjtCamera.mjCAMERA_FREE
            sight = -standing_axes(model, data, name)[:, 2]
            self.view.azimuth, self.view.elevation = direction_deg(np.zeros(3), sight)
            self.aim(model, data, 0.0)
            return
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
        if self._framing is not None:
            self.view.lookat[:], self.view.distance = self._framing.at(time)
        elif self.name == "orbit":
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


def standing_axes(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> Array:
    """Return a camera's own right, up and back as columns, (3, 3), its horizon kept level.

    Parameters
    ----------
    model, data
        With positions computed.
    name
        Of a camera in the model.
    """
    back = data.cam_xmat[model.camera(name).id].reshape(3, 3)[:, 2]
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back])


def eyes_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return where the person looks from, (3,) [m] in the world.

    Parameters
    ----------
    model, data
        With positions computed.
    """
    shoulder, trunk = (
        mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, name)
        for name in ("upper_arm", "trunk")
    )
    if min(shoulder, trunk) < 0:
        return _USUAL.copy()
    middle, side = data.xpos[trunk], data.xpos[shoulder]
    stature = float(np.linalg.norm(side - middle)) / SHOULDER_OF_STATURE
    return middle + np.array([0.0, 0.0, _EYES * stature])


def direction_deg(eyes: Array, target: Array) -> tuple[float, float]:
    """Return azimuth and elevation [deg] of MuJoCo's cameras that look from ``eyes`` at a point."""
    x, y, z = target - eyes
    return float(np.rad2deg(np.arctan2(y, x))), float(np.rad2deg(np.arctan2(z, np.hypot(x, y))))

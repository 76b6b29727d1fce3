"""The view from the chair: what the person sees of the hand, over the shoulder.

The eyes stay where they are and look at the hand. They are drawn nearer along their line of sight,
so that the hand fills the picture and neither shoulder nor trunk comes before it.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.arm.arm_geometry import SHOULDER_OF_STATURE
from handsim.types import Array

_EYES = 0.118
"""Height of the eyes over the shoulders, / stature: 0.936 less 0.818 (Drillis and Contini 1966)."""
_USUAL = np.array([-0.42, 0.0, 0.50])
"""Eyes of a person of median size, for a hand that no arm carries [m]."""


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

"""The view from the chair: what the person sees of the hand, from about over the shoulder.

The eyes stay where they are and look at the hand. They are drawn nearer along their line of sight,
so that the hand fills the picture and neither shoulder nor trunk comes before it.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.types import Array

_EYES = 0.118
"""Height of the eyes above the shoulders, / stature: 0.936 less 0.818 (Drillis and Contini 1966)."""
_HALF_SHOULDERS = 0.105
"""From the middle of the body to the shoulder joint, / stature, as the arm is built."""
_TOWARDS = 0.0
"""How far from the middle of the body to the shoulder of the arm the eyes are, as a share."""
_USUAL = np.array([-0.42, -0.09, 0.50])
"""Eyes of a person of median size whose right hand has no arm [m]; in +y for a left hand."""


def eyes_of(model: mujoco.MjModel, data: mujoco.MjData, thumb_side: float) -> Array:
    """Return where the person looks from, (3,) [m] in the world.

    Parameters
    ----------
    model, data
        With positions computed.
    thumb_side
        1 for a right hand, -1 for a left one; it counts where there is no person.
    """
    shoulder, trunk = (
        mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, name)
        for name in ("upper_arm", "trunk")
    )
    if min(shoulder, trunk) < 0:
        return _USUAL * [1.0, thumb_side, 1.0]
    middle, side = data.xpos[trunk], data.xpos[shoulder]
    stature = float(np.linalg.norm(side - middle)) / _HALF_SHOULDERS
    return middle + _TOWARDS * (side - middle) + [0.0, 0.0, _EYES * stature]


def direction_deg(eyes: Array, target: Array) -> tuple[float, float]:
    """Return azimuth and elevation [deg] of MuJoCo's cameras that look from ``eyes`` at a point."""
    x, y, z = target - eyes
    return float(np.rad2deg(np.arctan2(y, x))), float(np.rad2deg(np.arctan2(z, np.hypot(x, y))))

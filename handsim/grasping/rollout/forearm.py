"""Put the forearm where a palm pose and the commanded wrist angles need it."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.joints import JOINT_INDEX
from handsim.types import Array

WRIST = ("wrist_flexion", "wrist_deviation")
"""The wrist's joints, the proximal one first."""


class Wrist:
    """Puts the forearm where a palm pose and wrist angles need it.

    Without it, wrist angles that differ from those of the plan would carry the palm away.

    Parameters
    ----------
    model
        A model with a hand in it.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        palm = model.body("palm")
        self._pos, self._quat = palm.pos.copy(), palm.quat.copy()
        self._joints = [(JOINT_INDEX[name], model.joint(name).axis.copy()) for name in WRIST]

    def forearm(self, palm_pos: Array, palm_quat: Array, q: Array) -> tuple[Array, Array]:
        """Return position (3,) [m] and orientation (4,) of the forearm for a palm pose.

        Parameters
        ----------
        palm_pos, palm_quat : (3,) [m], (4,)
        q : (22,) [rad]
            Posture; only the wrist angles count.
        """
        bent, turn, rotated = self._quat.copy(), np.empty(4), np.empty(4)
        for index, axis in self._joints:
            mujoco.mju_axisAngle2Quat(turn, axis, q[index])
            mujoco.mju_mulQuat(rotated, bent, turn)
            bent[:] = rotated
        mujoco.mju_negQuat(turn, bent)
        quat, offset = np.empty(4), np.empty(3)
        mujoco.mju_mulQuat(quat, palm_quat, turn)
        mujoco.mju_rotVecQuat(offset, self._pos, quat)
        return palm_pos - offset, quat

    def forearms(self, palm_pos: Array, palm_quat: Array, q: Array) -> tuple[Array, Array]:
        """Return what `forearm` does for many poses (n, 3), (n, 4) and postures (n, 22) at once."""
        bent = np.broadcast_to(self._quat, palm_quat.shape)
        for index, axis in self._joints:
            half = 0.5 * q[:, index]
            turn = np.column_stack([np.cos(half), np.sin(half)[:, None] * axis])
            bent = _product(bent, turn)
        quat = _product(palm_quat, bent * np.array([1.0, -1.0, -1.0, -1.0]))
        return palm_pos - _turned(self._pos, quat), quat


def _product(a: Array, b: Array) -> Array:
    """Multiply quaternions (n, 4), rounded as MuJoCo's function for two of them is."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a.T, b.T
    w = (aw * bw - ax * bx) - (ay * by + az * bz)
    x = (aw * bx + ax * bw) + (ay * bz - az * by)
    y = (aw * by - ax * bz) + (ay * bw + az * bx)
    z = (aw * bz + ax * by) - (ay * bx - az * bw)
    return np.column_stack([w, x, y, z])


def _turned(vector: Array, quat: Array) -> Array:
    """Turn a vector (3,) by quaternions (n, 4), rounded as MuJoCo's function is."""
    if not vector.any():  # turned by whatever, no numbers included
        return np.zeros((len(quat), 3))
    w, x, y, z = quat.T
    a, b, c = vector
    i, j, k = w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a
    turned = [a + 2 * (y * k - z * j), b + 2 * (z * i - x * k), c + 2 * (x * j - y * i)]
    return np.column_stack(turned)

"""Put a hand of given posture to an object: alignment of thumb-finger opposition.

Alignment does most of what a search over wrist poses would: the axis from the thumb's pad to the
fingers' pads is laid along the object's opposition axis, its midpoint on the grasp point, and the
palm is turned about that axis until it faces along the approach.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from handsim.hand.grasp_task import Grasp
from handsim.hand.model import HandModel
from handsim.hand.scene import hand_axes
from handsim.joints import FINGERS, JOINT_INDEX, clip_to_range
from handsim.simulation.closings import PINCHED
from handsim.simulation.plan import Pose

Array = npt.NDArray[np.float64]

WRIST = ("wrist_flexion", "wrist_deviation")
"""The wrist's joints, the proximal one first."""


@dataclass(frozen=True)
class Opposition:
    """Thumb against fingers in one posture, palm frame.

    Attributes
    ----------
    midpoint : (3,)
        Between the thumb's pad and the mean of the fingers' pads [m].
    axis : (3,)
        Unit vector from the thumb's pad to the fingers'.
    gap
        Distance between them [m].
    facing : (3,)
        Unit vector normal to ``axis`` in which the palm looks.
    """

    midpoint: Array
    axis: Array
    gap: float
    facing: Array


def opposition(hand: HandModel, q: Array, grasp: Grasp) -> Opposition:
    """Return the opposition of thumb and the grasp's fingers in posture ``q`` (22,) [rad].

    What is thinner than a finger is pinched half-way between pad and tip, as people do who pick it
    up from a table.
    """
    hand.set_posture(q)
    palm = palm_pose(hand)
    touching = hand.pads()[0] if grasp.width > PINCHED else _pinching(hand)
    pads = palm.rotation.inv().apply(touching - palm.pos)
    thumb = pads[0]
    fingers = pads[[FINGERS.index(finger) for finger in grasp.fingers]].mean(axis=0)
    gap = float(np.linalg.norm(fingers - thumb))
    axis = (fingers - thumb) / gap
    palmar = np.array([0.0, 0.0, -1.0])
    facing = palmar - (palmar @ axis) * axis
    return Opposition((thumb + fingers) / 2, axis, gap, facing / np.linalg.norm(facing))


def align_palm(opposed: Opposition, grasp: Grasp) -> Pose:
    """Return the palm's pose in the object frame that lays the opposition on the grasp.

    A hand that wraps an upright object from the side stays level instead, with its breadth along
    the object: laying thumb and finger pads at one height would tilt the forearm into the table. So
    does a hand that rests on an object.
    """
    if grasp.kind in ("side", "rest"):
        rotation = Rotation.from_matrix(hand_axes(grasp))
    else:
        of_hand = _frame(opposed.axis, opposed.facing)
        of_object = _frame(np.array(grasp.opposition), np.array(grasp.approach))
        rotation = Rotation.from_matrix(of_object @ of_hand.T)
    pos = np.array(grasp.point) - rotation.apply(opposed.midpoint)
    return Pose(pos, rotation.as_quat(scalar_first=True))


def close_to_width(hand: HandModel, q_open: Array, q_shut: Array, grasp: Grasp) -> Array:
    """Return the posture between two at which thumb and fingers are the grasp's width apart.

    Where the width is never met, the nearer end is returned.
    """

    def excess(part: float) -> float:
        posture = clip_to_range(q_open + part * (q_shut - q_open))
        return opposition(hand, posture, grasp).gap - grasp.width

    if excess(0.0) <= 0:
        return clip_to_range(q_open)
    if excess(1.0) >= 0:
        return clip_to_range(q_shut)
    part = brentq(excess, 0.0, 1.0, xtol=1e-4)
    return clip_to_range(q_open + float(part) * (q_shut - q_open))  # pyright: ignore[reportArgumentType]


def palm_pose(hand: HandModel) -> Pose:
    """Return the palm's pose in the world as ``hand.data`` has it."""
    palm = hand.data.body("palm")
    return Pose(palm.xpos.copy(), palm.xquat.copy())


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


def _pinching(hand: HandModel) -> Array:
    """Points of the distal segments' surfaces half-way between pad and tip, (5, 3) [m]."""
    centres = np.array([hand.data.geom(f"{finger}_distal_geom").xpos for finger in FINGERS])
    return centres + np.sqrt(0.5) * (hand.fingertips() + hand.pads()[0] - 2 * centres)


def _frame(axis: Array, facing: Array) -> Array:
    """Return a rotation matrix whose first columns are ``axis`` and ``facing`` made normal."""
    first = axis / np.linalg.norm(axis)
    second = facing - (facing @ first) * first
    second /= np.linalg.norm(second)
    return np.column_stack([first, second, np.cross(first, second)])

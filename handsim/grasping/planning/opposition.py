"""Put a hand of given posture to an object by aligning the opposition of thumb and fingers.

The axis from the thumb's pad to the fingers' pads is laid along the object's opposition axis, with
its midpoint on the grasp point. The palm is then turned about that axis until it faces along the
approach. This replaces most of a search over wrist poses.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from handsim.grasping.plan import Pose
from handsim.grasping.planning.preshapes import PINCHED
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, clip_to_range
from handsim.objects.grasp import Grasp
from handsim.tasks.scene import hand_axes
from handsim.types import Array


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

    An object thinner than a finger is pinched half-way between pad and tip, as people do when they
    pick it up from a table.
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

    For grasps from the side and for a hand that rests on an object, the palm stays level instead,
    with its breadth along the object. There, pads at one height would tilt the forearm into the
    table.
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

    Where the width is outside their range, the nearer of both is returned.
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

"""What a person would not do with an arm: how far a posture of it is from natural.

Each term is 0 for a posture that nobody would remark on and 1 where people who sit at a table stop:
the joint at the end of its range, the elbow 5 cm above the shoulder, 2 cm of the forearm in the
table. It grows beyond.

Places are seen from the shoulder, of a right arm, as in `handsim.arm.chain`.
"""

from dataclasses import dataclass

import numpy as np

from handsim.arm.arm_geometry import SHOULDER_OF_STATURE, ArmGeometry, Seat
from handsim.arm.arm_joints import (
    CHAIN_LOWER,
    CHAIN_UPPER,
    highest_elevation,
    rotation_range,
)
from handsim.types import Array

FREE_RANGE = 0.75
"""Part of a half range that is used without thought; discomfort rises beyond it (Cruse, Wischmeyer,
Bruewer, Brockfeld & Dress 1990, Biol. Cybern. 62:519-528: parabolic costs of joint angles)."""
_BEYOND = np.deg2rad(10.0)  # past the end of a range, for one more unit
_ELBOW_HIGH = (-0.05, 0.05)  # of the elbow above the shoulder: where it begins and is 1 [m]
_IN_TRUNK = 0.04  # [m]
_IN_TABLE = 0.02  # [m]
TRUNK_DEPTH_OF_STATURE = 0.065
"""Half the depth of the chest, / stature (chest depth of men 230 mm of 1740, Pheasant)."""
ELBOW_RADIUS_OF_STATURE, WRIST_RADIUS_OF_STATURE = 0.024, 0.017
"""From the axis of the forearm to its underside at the elbow and at the wrist, / stature."""
_ALONG_FOREARM = np.linspace(0.0, 1.0, 6)


@dataclass(frozen=True)
class Unnaturalness:
    """How far postures of an arm are from natural, term by term, each (...) and at least 0.

    Attributes
    ----------
    joints
        The worst joint: 0 to `FREE_RANGE` of its half range, 1 at its end, one more each 10 deg
        beyond.
    elbow
        The elbow near or above the height of the shoulder.
    trunk
        Elbow or wrist in the person's own chest.
    table
        The forearm in the table top.
    """

    joints: Array
    elbow: Array
    trunk: Array
    table: Array

    @property
    def total(self) -> Array:
        """Sum of the terms, (...)."""
        return self.joints + self.elbow + self.trunk + self.table


def range_use(angles: Array) -> Array:
    """Return where each of the 7 joints is in its range: -1 and 1 at the ends, (..., 7).

    Ends of the shoulder's ranges are those of the plane in which the arm is lifted. Beyond an end
    10 deg count as 1. Raising has no lower end: a hanging arm is no strain.
    """
    lower = np.broadcast_to(CHAIN_LOWER, angles.shape).copy()
    upper = np.broadcast_to(CHAIN_UPPER, angles.shape).copy()
    upper[..., 1] = highest_elevation(angles[..., 0])
    lower[..., 2], upper[..., 2] = rotation_range(angles[..., 0])
    # The plane means nothing in a hanging arm, and what it allows is in the two others.
    lower[..., 0], upper[..., 0] = -np.pi, np.pi
    lower[..., 1] = -upper[..., 1]
    lower[..., 3] = -upper[..., 3]  # straight is no strain either
    inside = (2 * angles - lower - upper) / (upper - lower)
    beyond = np.maximum(angles - upper, 0.0) + np.minimum(angles - lower, 0.0)
    return np.clip(inside, -1.0, 1.0) + beyond / _BEYOND


def unnaturalness(
    angles: Array,
    elbow: Array,
    wrist: Array,
    geometry: ArmGeometry,
    seat: Seat | None = None,
    use: Array | None = None,
) -> Unnaturalness:
    """Return how far postures are from natural.

    Parameters
    ----------
    angles : (..., 7) [rad]
    elbow, wrist : (..., 3) [m]
        Seen from the shoulder, of a right arm.
    geometry
    seat
        Where the table is.
    use : (..., 7)
        `range_use` of the angles, where it is known already.
    """
    seat, stature = seat or Seat(), geometry.stature
    most = np.abs(range_use(angles) if use is None else use).max(axis=-1)
    low, high = _ELBOW_HIGH
    return Unnaturalness(
        joints=np.maximum(np.minimum(most, 1.0) - FREE_RANGE, 0.0) / (1.0 - FREE_RANGE)
        + np.maximum(most - 1.0, 0.0),
        elbow=np.maximum(elbow[..., 2] - low, 0.0) / (high - low),
        trunk=np.maximum(_in_trunk(elbow, stature), _in_trunk(wrist, stature)) / _IN_TRUNK,
        table=_in_table(elbow, wrist, seat, stature) / _IN_TABLE,
    )


def _in_trunk(place: Array, stature: float) -> Array:
    """Return how deep places are in a chest of elliptic section [m]."""
    half = np.array([TRUNK_DEPTH_OF_STATURE, SHOULDER_OF_STATURE]) * stature
    middle = np.array([0.0, SHOULDER_OF_STATURE * stature])
    out = np.linalg.norm((place[..., :2] - middle) / half, axis=-1)
    return np.where(place[..., 2] < 0.0, np.maximum(1.0 - out, 0.0), 0.0) * half[0]


def _in_table(elbow: Array, wrist: Array, seat: Seat, stature: float) -> Array:
    """Return how deep the forearm is in a table that begins where the chest ends [m]."""
    part = _ALONG_FOREARM[:, None]
    points = (1 - part) * elbow[..., None, :] + part * wrist[..., None, :]
    radius = (
        1 - _ALONG_FOREARM
    ) * ELBOW_RADIUS_OF_STATURE + _ALONG_FOREARM * WRIST_RADIUS_OF_STATURE
    above = points[..., 2] + stature * (seat.height - radius)
    edge = stature * seat.edge
    deep = np.where(points[..., 0] > edge, np.maximum(-above, 0.0), 0.0)
    # The wrist is where the plan says: only what the elbow decides is judged.
    return deep[..., :-1].max(axis=-1)

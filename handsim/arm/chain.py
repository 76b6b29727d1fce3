"""Where elbow, wrist and palm are for the 7 angles, and the angles for a palm pose and a swivel.

The wrist's joints meet in the origin of the palm. A palm pose therefore says where the wrist is,
whatever the wrist's angles, and leaves one freedom: the elbow may turn about the line from shoulder
to wrist. This angle is the *swivel*: 0 where the elbow hangs lowest, +90 deg where it is level with
that line on the outer side. With it all 7 angles follow in closed form.

Frame: origin at the shoulder, +x ahead, +y left, +z up; of a right arm. That of a left arm is the
mirror image y -> -y (`mirrored`). Rotations are matrices, columns the axes.

Zero posture: the arm hangs, thumb ahead. Upper arm = Rz(plane) Rx(-elevation) Rz(rotation); the
elbow turns the forearm by Ry(-flexion); the frame of the hand in it has x along -z and y along x;
pronation is Rx(-angle) in it, the wrist's are Ry(flexion) and Rz(deviation).
"""

from dataclasses import dataclass

import numpy as np

from handsim.hand.kinematics import cross
from handsim.types import Array

_FLAT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
"""Axes of the hand in the frame of the forearm of the hanging arm, as columns."""
_LEAST = 1e-9


@dataclass(frozen=True)
class ChainPlaces:
    """Where the parts of the arm are, each (..., 3) [m] or (..., 3, 3).

    Attributes
    ----------
    elbow, wrist
        Joint centres.
    forearm, palm
        Orientations; the forearm's, in the axes of the hand, is that beyond its own rotation.
    """

    elbow: Array
    wrist: Array
    forearm: Array
    palm: Array


def places(angles: Array, upper_arm: float, forearm: float) -> ChainPlaces:
    """Return where the parts of the arm are.

    Parameters
    ----------
    angles : (..., 7) [rad]
        Shoulder first, in the order of `handsim.arm.arm_joints.CHAIN_NAMES`.
    upper_arm, forearm
        Lengths [m].
    """
    plane, elevation, rotation, flexion, pronation, bend, deviation = np.moveaxis(angles, -1, 0)
    humerus = _about(2, plane) @ _about(0, -elevation) @ _about(2, rotation)
    elbow = -upper_arm * humerus[..., :, 2]
    bent = humerus @ _about(1, -flexion)
    wrist = elbow - forearm * bent[..., :, 2]
    turned = bent @ _FLAT @ _about(0, -pronation)
    return ChainPlaces(elbow, wrist, turned, turned @ _about(1, bend) @ _about(2, deviation))


def angles_at(
    wrist: Array, palm: Array, swivel: Array, upper_arm: float, forearm: float
) -> tuple[Array, Array]:
    """Return the 7 angles with which wrist and palm are where they should be.

    Parameters
    ----------
    wrist : (..., 3) [m]
        From the shoulder. Beyond the arm's reach, or nearer than it can fold, the angles point it
        there.
    palm : (..., 3, 3)
    swivel : (...) [rad]
        All broadcast against each other.
    upper_arm, forearm
        Lengths [m].

    Returns
    -------
    angles : (..., 7) [rad]
        Whether they are within the ranges is not looked at; the wrist's flexion is within 90 deg.
    elbow : (..., 3) [m]
    """
    distance = np.linalg.norm(wrist, axis=-1)
    along = wrist / np.maximum(distance, _LEAST)[..., None]
    reached = np.clip(distance, abs(upper_arm - forearm) + _LEAST, upper_arm + forearm)
    down, out = _circle(along)
    turned = swivel[..., None]
    bulge = np.cos(turned) * down + np.sin(turned) * out
    foot = (upper_arm**2 - forearm**2 + reached**2) / (2 * reached)
    radius = np.sqrt(np.maximum(upper_arm**2 - foot**2, 0.0))
    elbow = foot[..., None] * along + radius[..., None] * bulge
    up = -elbow / upper_arm
    flexion = np.arccos(
        np.clip((reached**2 - upper_arm**2 - forearm**2) / (2 * upper_arm * forearm), -1.0, 1.0)
    )
    ahead = -bulge + np.sum(bulge * up, axis=-1, keepdims=True) * up
    ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=-1, keepdims=True), _LEAST)
    humerus = np.stack([ahead, cross(up, ahead), up], axis=-1)
    plane = np.arctan2(-up[..., 0], up[..., 1])
    elevation = np.arctan2(np.hypot(up[..., 0], up[..., 1]), up[..., 2])
    rotation = np.arctan2(-humerus[..., 2, 0], -humerus[..., 2, 1])
    forearm_axes = humerus @ _about(1, -flexion) @ _FLAT
    rest = np.swapaxes(forearm_axes, -1, -2) @ palm
    bend = np.arcsin(np.clip(rest[..., 0, 2], -1.0, 1.0))
    pronation = np.arctan2(rest[..., 1, 2], rest[..., 2, 2])
    deviation = np.arctan2(-rest[..., 0, 1], rest[..., 0, 0])
    made = np.broadcast_arrays(plane, elevation, rotation, flexion, pronation, bend, deviation)
    return np.stack(made, axis=-1), elbow


def swivel_of(elbow: Array, wrist: Array) -> Array:
    """Return the swivel of an elbow, (...) [rad], from places (..., 3) seen from the shoulder."""
    along = wrist / np.maximum(np.linalg.norm(wrist, axis=-1, keepdims=True), _LEAST)
    down, out = _circle(along)
    return np.arctan2(np.sum(elbow * out, axis=-1), np.sum(elbow * down, axis=-1))


def mirrored(pos: Array, rotation: Array) -> tuple[Array, Array]:
    """Return positions (..., 3) and rotations (..., 3, 3) mirrored at the plane y = 0."""
    flip = np.array([1.0, -1.0, 1.0])
    return pos * flip, flip[:, None] * rotation * flip


def matrices(quat: Array) -> Array:
    """Return unit quaternions (..., 4), w first, as rotation matrices (..., 3, 3)."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _circle(along: Array) -> tuple[Array, Array]:
    """Return the lowest and the outermost direction across a unit vector (..., 3).

    Right above and below the shoulder there is no lowest one; there it goes over into the back.
    """
    level = 1.0 - along[..., 2:] ** 2
    wanted = np.array([0.0, 0.0, -1.0]) + np.where(level < 1e-6, 1.0, 0.0) * np.array([-1.0, 0, 0])
    down = wanted - np.sum(wanted * along, axis=-1, keepdims=True) * along
    down = down / np.maximum(np.linalg.norm(down, axis=-1, keepdims=True), _LEAST)
    return down, cross(down, along)


def _about(axis: int, angle: Array) -> Array:
    """Return rotations about the x (0), y (1) or z axis (2), (..., 3, 3)."""
    made = np.zeros((*np.shape(angle), 3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    made[..., axis, axis] = 1.0
    made[..., j, j] = made[..., k, k] = np.cos(angle)
    made[..., k, j] = np.sin(angle)
    made[..., j, k] = -np.sin(angle)
    return made

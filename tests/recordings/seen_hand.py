"""A hand that moves, and what cameras see of it: made by the kinematics that fits turn round."""

import numpy as np

from handsim.hand.kinematics import Kinematics
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.fitting.hand_points import HandPoint, HandPoints
from handsim.types import Array, HandSize

SIZE = HandSize(0.178, 0.086)
OPEN_DEG = {
    "thumb_rotation": 25, "thumb_abduction": 25, "thumb_mcp": 5, "thumb_ip": 10,
    "index_mcp": 5, "index_pip": 10, "index_dip": 7, "middle_mcp": 5, "middle_pip": 12,
    "middle_dip": 8, "ring_mcp": 8, "ring_pip": 12, "ring_dip": 8, "little_mcp": 8,
    "little_pip": 12, "little_dip": 8, "index_abduction": 6, "ring_abduction": 5,
    "little_abduction": 9, "palm_arch": 4,
}  # fmt: skip
CLOSED_DEG = {
    "thumb_rotation": 85, "thumb_abduction": 20, "thumb_mcp": 25, "thumb_ip": 35,
    "index_mcp": 50, "index_pip": 60, "index_dip": 40, "middle_mcp": 60, "middle_pip": 65,
    "middle_dip": 44, "ring_mcp": 62, "ring_pip": 60, "ring_dip": 40, "little_mcp": 60,
    "little_pip": 55, "little_dip": 37, "index_abduction": 0, "ring_abduction": 1,
    "little_abduction": 2, "palm_arch": 8,
}  # fmt: skip


def posture(angles_deg: dict[str, float]) -> Array:
    q = np.zeros(N_JOINTS)
    for name, angle in angles_deg.items():
        q[JOINT_INDEX[name]] = np.deg2rad(angle)
    return q


def movement(n: int = 60) -> Array:
    """Postures of a hand that closes and opens; the thumb lags."""
    phase = np.linspace(0, 2 * np.pi, n)
    part = (1 - np.cos(phase))[:, None] / 2
    late = (1 - np.cos(phase - 0.8))[:, None] / 2
    opened, closed = posture(OPEN_DEG), posture(CLOSED_DEG)
    of_thumb = np.arange(N_JOINTS) < 4
    return opened + (closed - opened) * np.where(of_thumb, late, part)


def poses(n: int) -> tuple[Array, Array]:
    """Poses of a palm that turns and goes half a metre."""
    angle = np.linspace(0.3, 1.4, n)
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros(n), np.ones(n)
    turn = np.stack([c, -s, o, s, c, o, o, o, i], axis=1).reshape(n, 3, 3)
    tilt = np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])
    place = np.stack([np.linspace(0.2, 0.7, n), 0.1 * np.sin(angle), 0.9 * i], axis=1)
    return turn @ tilt, place


def seen(
    points: tuple[HandPoint, ...], q: Array, *, size: HandSize = SIZE, offset: Array | None = None
) -> Array:
    """Where points on a moving hand are seen, (n, m, 3) [m]; a left one is the mirror image."""
    on = HandPoints.expected(points, size)
    if offset is not None:
        on = HandPoints(on.points, on.hand, offset)
    hand: Kinematics = on.kinematics
    rotation, position = poses(len(q))
    in_palm = hand.points(hand.frames(q), on.on_hand)
    world = in_palm @ rotation.swapaxes(1, 2) + position[:, None]
    return world * (np.array([1, -1, 1]) if size.side == "left" else 1.0)

"""Postures from which a fit begins: near enough that it ends in the right one.

The pose comes from the points on the palm; then each finger takes, of a few dozen postures, the one
that brings its points nearest. A fit that began with a flat hand would leave fists half open.
"""

from itertools import product

import numpy as np

from handsim.joints import FINGERS, JOINT_INDEX, N_JOINTS, Finger
from handsim.recordings.fitting.hand_points import HandPoints, PalmPostures, are_seen
from handsim.recordings.fitting.rigid import apply, best_poses
from handsim.types import Array, Index

REST_DEG = {
    "thumb_rotation": 45.0, "thumb_abduction": 15.0, "thumb_mcp": 12.0, "thumb_ip": 15.0,
    "index_mcp": 28.0, "index_pip": 32.0, "index_dip": 18.0,
    "middle_mcp": 30.0, "middle_pip": 36.0, "middle_dip": 20.0,
    "ring_mcp": 32.0, "ring_pip": 38.0, "ring_dip": 21.0,
    "little_mcp": 34.0, "little_pip": 38.0, "little_dip": 21.0,
    "index_abduction": 2.0, "ring_abduction": 2.0, "little_abduction": 4.0, "palm_arch": 4.0,
}  # fmt: skip
"""The relaxed hand, towards which joints go that no point tells of [deg]."""
WHOLE_HAND_FLEXIONS = (0.0, 0.3, 0.6, 0.9)
"""How far fingers are flexed in the postures by which a hand is found without its palm."""


def rest_posture() -> Array:
    """Return the relaxed hand, (22,) [rad], wrist 0."""
    q = np.zeros(N_JOINTS)
    for name, angle in REST_DEG.items():
        q[JOINT_INDEX[name]] = np.deg2rad(angle)
    return q


def start_from_palm(points: HandPoints, seen: Array) -> PalmPostures:
    """Return a posture a frame, the palm's pose taken from the points on it.

    Parameters
    ----------
    points
        With at least three on the palm.
    seen : (n, m, 3) [m], NaN where a point is not seen
    """
    rest = np.broadcast_to(rest_posture(), (1, N_JOINTS))
    hand = points.kinematics
    places = hand.points(hand.frames(rest), points.on_hand)[0]
    on_palm = np.array([finger is None for finger in points.fingers])
    there = are_seen(seen)
    enough = (there & on_palm).sum(axis=1) >= 3
    weights = np.where(there & (on_palm | ~enough[:, None]), 1.0, 0.0)
    rotation, position = best_poses(places, np.nan_to_num(seen), weights)
    return with_fingers(points, seen, rotation, position)


def start_from_fingers(points: HandPoints, seen: Array) -> PalmPostures:
    """Return a posture a frame where the points on the palm are not known yet.

    Of a few postures of the whole hand, the one whose finger points can be moved nearest.
    """
    of_finger = np.array([finger is not None for finger in points.fingers])
    hand, rest = points.kinematics, rest_posture()
    weights = np.where(are_seen(seen) & of_finger, 1.0, 0.0)
    known = np.nan_to_num(seen)
    least = np.full(len(seen), np.inf)
    rotation, position = np.empty((len(seen), 3, 3)), np.empty((len(seen), 3))
    for flexion, turn in product(WHOLE_HAND_FLEXIONS, (0.1, 0.5, 0.9)):
        q = rest.copy()
        for finger in FINGERS[1:]:
            _flex(q, finger, flexion)
        q[JOINT_INDEX["thumb_rotation"]] = turn * np.deg2rad(100)
        places = hand.points(hand.frames(q[None]), points.on_hand)[0]
        turned, moved = best_poses(places, known, weights)
        off = known - apply(turned, np.broadcast_to(places, seen.shape)) - moved[:, None]
        error = (weights * (off**2).sum(axis=2)).sum(axis=1)
        better = error < least
        least[better], rotation[better], position[better] = (
            error[better],
            turned[better],
            moved[better],
        )
    return with_fingers(points, seen, rotation, position)


def with_fingers(points: HandPoints, seen: Array, rotation: Array, position: Array) -> PalmPostures:
    """Return poses with each finger in the posture of a grid that is nearest to what is seen."""
    q = np.tile(rest_posture(), (len(seen), 1))
    in_palm = apply(rotation.swapaxes(1, 2), seen - position[:, None])
    fingers = np.array(points.fingers, dtype=object)
    for finger in FINGERS:
        own = np.flatnonzero(fingers == finger)
        if not len(own):
            continue
        grid = _grid(finger)
        places = points.kinematics.points(points.kinematics.frames(grid), points.on_hand)[:, own]
        joints = [j for name, j in JOINT_INDEX.items() if name.startswith(finger)]
        q[:, joints] = grid[_nearest(places, in_palm[:, own])][:, joints]
    return PalmPostures(q, rotation, position)


def _nearest(places: Array, seen: Array) -> Index:
    """Return which of g rows of places (g, m, 3) is nearest to each row seen (n, m, 3)."""
    there = np.isfinite(seen)
    known = np.where(there, seen, 0.0).reshape(len(seen), -1)
    flat = places.reshape(len(places), -1)
    # |p - s|^2 over what is seen, without |s|^2, which is the same for all rows of the grid.
    error = there.reshape(len(seen), -1) @ (flat**2).T - 2 * known @ flat.T
    return np.argmin(error, axis=1)


def _grid(finger: Finger) -> Array:
    """Return postures in which one finger takes many, (g, 22) [rad]."""
    rows: list[Array] = []
    if finger == "thumb":
        turns, opened, flexed = (0, 25, 50, 75, 100), (0, 25, 50), (0, 25, 55)
        for rotation, abduction, mcp, ip in product(turns, opened, flexed, flexed):
            q = rest_posture()
            for name, angle in zip(
                ("rotation", "abduction", "mcp", "ip"), (rotation, abduction, mcp, ip), strict=True
            ):
                q[JOINT_INDEX[f"thumb_{name}"]] = np.deg2rad(angle)
            rows.append(q)
        return np.array(rows)
    sideways = (0.0,) if finger == "middle" else (-5.0, 5.0, 15.0)
    for mcp, pip, aside in product((-10, 10, 30, 50, 70, 85), (5, 30, 55, 80, 100), sideways):
        q = rest_posture()
        _flex(q, finger, 0.0, np.deg2rad(mcp), np.deg2rad(pip))
        if finger != "middle":
            q[JOINT_INDEX[f"{finger}_abduction"]] = np.deg2rad(aside)
        rows.append(q)
    return np.array(rows)


def _flex(
    q: Array, finger: Finger, part: float, mcp: float | None = None, pip: float | None = None
) -> None:
    q[JOINT_INDEX[f"{finger}_mcp"]] = part * np.deg2rad(85) if mcp is None else mcp
    q[JOINT_INDEX[f"{finger}_pip"]] = part * np.deg2rad(100) if pip is None else pip
    q[JOINT_INDEX[f"{finger}_dip"]] = 0.67 * q[JOINT_INDEX[f"{finger}_pip"]]

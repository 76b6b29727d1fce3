"""What markers tell beside the hand: the wrist's angles by the elbow, the arm, the object."""

import numpy as np

from handsim.hand.kinematics import cross
from handsim.recordings.fitting.fit_hand import HandFit
from handsim.recordings.fitting.hand_points import are_seen
from handsim.recordings.fitting.rigid import apply, best_poses
from handsim.types import Array, Side

EPICONDYLE = 0.040
"""From a marker on the outer side of the elbow to the middle of the joint [m]: half of an elbow's
70 mm (Pheasant & Haslegrave 2006) and a marker's radius."""
MIN_MARKERS = 3
"""Markers of an object from which its rotation is known."""


def middle(positions: Array) -> Array:
    """Return the mean of markers (n, k, 3), (n, 3); NaN in frames in which one is missing."""
    mean: Array = positions.mean(axis=1)
    return mean


def elbow_centre(elbow: Array, shoulder: Array, wrist: Array, side: Side) -> Array:
    """Return the middle of an elbow that has one marker, on its outer side.

    The outer side is that of the elbow's axis, across the upper arm and the forearm. In frames in
    which these are in line or the shoulder is not seen, the marker itself is taken.

    Parameters
    ----------
    elbow, shoulder, wrist : (n, 3) [m]
    side
    """
    outwards = cross(elbow - shoulder, wrist - elbow) * (1.0 if side == "right" else -1.0)
    length = np.linalg.norm(outwards, axis=1, keepdims=True)
    known = np.isfinite(length) & (length > 1e-3)  # 1 cm2 and more between the arm's two parts
    return elbow - np.where(known, EPICONDYLE * outwards / np.where(known, length, 1.0), 0.0)


def wrist_angles(fit: HandFit, elbow: Array) -> Array:
    """Return flexion and deviation of the wrist, (n, 2) [rad], by where the elbow is.

    The forearm runs from the elbow to the wrist centre; in the frame of the palm, which the wrist
    turns by flexion about y and then by deviation about z (`handsim.hand.skeleton`), its direction
    is (cos d cos f, -sin d cos f, sin f).

    Parameters
    ----------
    fit
    elbow : (n, 3) [m]
        NaN where it is not seen; the angles are then NaN.
    """
    along = apply(fit.rotation.swapaxes(1, 2), fit.position - elbow)
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    thumb_side = 1.0 if fit.hand.side == "right" else -1.0
    flexion = np.arcsin(np.clip(along[:, 2], -1.0, 1.0))
    deviation = np.arctan2(-thumb_side * along[:, 1], along[:, 0])
    return np.stack([flexion, deviation], axis=1)


def rigid_pose(positions: Array) -> tuple[Array, Array]:
    """Return the pose of an object by its markers.

    Its frame has its origin in the middle of the markers and, in the first frame in which all are
    seen, the axes of the cameras.

    Parameters
    ----------
    positions : (n, k, 3) [m], NaN where a marker is not seen

    Returns
    -------
    rotation : (n, 3, 3)
        NaN in frames with less than `MIN_MARKERS` markers.
    position : (n, 3) [m]
        NaN there too, but where all markers are seen.
    """
    there = are_seen(positions)
    rotation, position = np.full((len(positions), 3, 3), np.nan), middle(positions)
    whole = np.flatnonzero(there.all(axis=1))
    if positions.shape[1] < MIN_MARKERS or not len(whole):
        return rotation, position
    shape = positions[whole[0]] - positions[whole[0]].mean(axis=0)
    known = there.sum(axis=1) >= MIN_MARKERS
    weights = there[known].astype(float)
    rotation[known], position[known] = best_poses(shape, np.nan_to_num(positions[known]), weights)
    return rotation, position

"""The wrist by the elbow, against the kinematics; an object's pose by its markers."""

import numpy as np
import pytest
from seen_hand import SIZE, poses

from handsim.hand.kinematics import Kinematics
from handsim.joints import JOINT_INDEX
from handsim.recordings.fitting.fit_hand import HandFit
from handsim.recordings.fitting.hand_points import HandPoints
from handsim.recordings.points.beside_hand import elbow_centre, rigid_pose, wrist_angles
from handsim.recordings.points.keypoint_order import expected_places
from handsim.types import HandSize, Side


@pytest.mark.parametrize("side", ["right", "left"])
def test_wrist_angles_are_those_of_the_hand(side: Side) -> None:
    n = 30
    q = np.zeros((n, 22))
    q[:, JOINT_INDEX["wrist_flexion"]] = np.linspace(-1.0, 1.1, n)
    q[:, JOINT_INDEX["wrist_deviation"]] = np.linspace(0.3, -0.5, n)
    size = HandSize(SIZE.length, SIZE.breadth, side)
    forearm, wrist = poses(n)
    palm = forearm @ Kinematics(size).frames(q).rotation[:, 0]
    elbow = wrist - 0.26 * forearm[:, :, 0]
    points = HandPoints.expected(expected_places(), SIZE)
    fit = HandFit(size, points, 0 * q, palm, wrist, np.zeros((n, 21)), np.inf)
    assert np.abs(wrist_angles(fit, elbow) - q[:, 20:]).max() < 1e-9
    elbow[3] = np.nan
    assert np.isnan(wrist_angles(fit, elbow)[3]).all()


def test_the_joint_lies_inside_of_a_marker_on_the_outer_side() -> None:
    shoulder, wrist = (
        np.array([[0.0, 0, 0.3]]),
        np.array([[0.25, 0, 0.0]]),
    )  # x ahead, y to the left
    outside = np.array([[0.0, -0.04, 0.0]])
    right = elbow_centre(outside, shoulder, wrist, "right")
    assert np.abs(right).max() < 0.008
    left = elbow_centre(-outside, shoulder, wrist, "left")
    assert np.abs(left).max() < 0.008
    unknown = elbow_centre(outside, np.full((1, 3), np.nan), wrist, "right")
    assert (unknown == outside).all()


def test_pose_of_an_object_by_its_markers() -> None:
    n = 12
    turned, place = poses(n)
    shape = np.array([[0.1, 0, 0], [-0.1, 0.05, 0], [0, -0.05, 0.08], [0, 0, -0.08]])
    markers = shape @ turned.swapaxes(1, 2) + place[:, None]
    markers[4, 0] = np.nan
    markers[5, :2] = np.nan
    rotation, position = rigid_pose(markers)
    assert np.abs(rotation[0] - np.eye(3)).max() < 1e-9
    known = np.arange(n) != 5
    relative = turned[known] @ turned[0].T
    assert np.abs(rotation[known] - relative).max() < 1e-9
    assert np.abs(position[known] - place[known]).max() < 1e-9
    assert np.isnan(rotation[5]).all() and np.isnan(position[5]).all()
    two, middle = rigid_pose(markers[:, 2:])
    assert np.isnan(two).all() and np.isfinite(middle).all()

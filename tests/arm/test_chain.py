import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.arm.arm_joints import CHAIN_LOWER, CHAIN_UPPER
from handsim.arm.chain import angles_at, matrices, mirrored, places, swivel_of

UPPER, FORE = 0.33, 0.26
AHEAD, LEFT, UP = np.eye(3)


def at(**degrees: float):
    names = ("plane", "elevation", "rotation", "elbow", "pronation", "bend", "deviation")
    return places(np.deg2rad([degrees.get(name, 0.0) for name in names]), UPPER, FORE)


def test_the_zero_posture_hangs_with_the_thumb_ahead() -> None:
    arm = at()
    assert arm.elbow == pytest.approx(-UPPER * UP)
    assert arm.wrist == pytest.approx(-(UPPER + FORE) * UP)
    x, y, z = arm.palm.T
    assert (x, y, z) == (pytest.approx(-UP), pytest.approx(AHEAD), pytest.approx(-LEFT))


@pytest.mark.parametrize(
    ("degrees", "elbow"),
    [
        ({"plane": 0, "elevation": 90}, -LEFT),
        ({"plane": 90, "elevation": 90}, AHEAD),
        ({"plane": -90, "elevation": 30}, (-0.5 * AHEAD - 0.75**0.5 * UP)),
    ],
)
def test_the_plane_says_where_the_arm_is_lifted_to(degrees, elbow) -> None:
    assert at(**degrees).elbow == pytest.approx(UPPER * elbow)


def test_elbow_shoulder_and_forearm_turn_the_way_they_are_named() -> None:
    bent = at(elbow=90)
    assert bent.wrist - bent.elbow == pytest.approx(FORE * AHEAD)
    assert bent.palm[:, 1] == pytest.approx(UP)  # thumb up
    inwards = at(elbow=90, rotation=90)
    assert inwards.wrist - inwards.elbow == pytest.approx(FORE * LEFT)
    prone = at(elbow=90, pronation=90)
    assert prone.palm[:, 2] == pytest.approx(UP)  # back of the hand up
    assert at(elbow=90, pronation=90, bend=90).palm[:, 0] == pytest.approx(-UP)
    assert at(elbow=90, pronation=90, deviation=90).palm[:, 0] == pytest.approx(LEFT)
    ahead = at(plane=90, elevation=90, rotation=-90, elbow=90)
    assert ahead.wrist - ahead.elbow == pytest.approx(FORE * UP)  # lifted ahead without turning


def test_angles_bring_wrist_and_palm_back() -> None:
    rng = np.random.default_rng(3)
    q = rng.uniform(CHAIN_LOWER, CHAIN_UPPER, (500, 7))
    q[:, 1], q[:, 3] = np.clip(q[:, 1], 0.05, 3.0), np.maximum(q[:, 3], 0.1)
    arm = places(q, UPPER, FORE)
    found, elbow = angles_at(arm.wrist, arm.palm, swivel_of(arm.elbow, arm.wrist), UPPER, FORE)
    assert np.abs((found - q + np.pi) % (2 * np.pi) - np.pi).max() < 1e-9
    assert np.abs(elbow - arm.elbow).max() < 1e-12


def test_the_swivel_lifts_the_elbow_outwards() -> None:
    wrist, palm = np.array([0.4, 0.0, -0.1]), np.eye(3)
    elbows = angles_at(wrist, palm, np.deg2rad([0.0, 90.0, 180.0]), UPPER, FORE)[1]
    heights = elbows[:, 2]
    assert heights[0] < heights[1] < heights[2]
    assert elbows[0, 1] == pytest.approx(0.0, abs=1e-12)
    assert elbows[1, 1] < -0.1  # to the right
    assert np.linalg.norm(elbows - wrist, axis=1) == pytest.approx(np.full(3, FORE))


def test_beyond_its_reach_the_arm_points_there() -> None:
    angles, elbow = angles_at(np.array([2.0, 0.0, 0.0]), np.eye(3), np.array(0.0), UPPER, FORE)
    assert elbow == pytest.approx([UPPER, 0.0, 0.0])
    assert angles[3] == pytest.approx(0.0, abs=1e-6)
    assert places(angles, UPPER, FORE).wrist == pytest.approx([UPPER + FORE, 0, 0], abs=1e-6)


def test_right_below_the_shoulder_the_elbow_goes_back() -> None:
    elbow = angles_at(np.array([0.0, 0.0, -0.4]), np.eye(3), np.array(0.0), UPPER, FORE)[1]
    assert elbow[0] < -0.1
    assert elbow[1] == pytest.approx(0.0, abs=1e-9)


def test_quaternions_and_mirrors() -> None:
    turn = Rotation.random(5, rng=1)
    assert matrices(turn.as_quat(scalar_first=True)) == pytest.approx(turn.as_matrix())
    pos, rotation = mirrored(np.array([[1.0, 2.0, 3.0]]), turn.as_matrix()[:1])
    assert pos.tolist() == [[1.0, -2.0, 3.0]]
    assert np.linalg.det(rotation) == pytest.approx([1.0])
    assert rotation[0] @ [0, 1, 0] == pytest.approx([1, -1, 1] * -turn.as_matrix()[0][:, 1])

import numpy as np
import pytest

from handsim.arm.arm_geometry import ArmGeometry, Seat
from handsim.arm.arm_joints import CHAIN_UPPER, highest_elevation, rotation_range
from handsim.arm.naturalness import range_use, unnaturalness

ARM = ArmGeometry()
EASY = np.deg2rad([60.0, 40.0, -50.0, 80.0, 20.0, 0.0, 0.0])
ELBOW, WRIST = np.array([0.2, -0.05, -0.25]), np.array([0.4, 0.1, -0.22])


def judged(angles=EASY, elbow=ELBOW, wrist=WRIST, seat: Seat | None = None):
    return unnaturalness(np.asarray(angles), np.asarray(elbow), np.asarray(wrist), ARM, seat)


def test_nobody_remarks_on_an_arm_at_work() -> None:
    found = judged()
    assert found.joints == found.elbow == found.trunk == found.table == 0
    assert found.total == 0


def test_a_joint_counts_1_at_the_end_of_its_range_and_one_more_each_10_deg() -> None:
    for beyond, expected in ((0.0, 1.0), (10.0, 2.0)):
        angles = EASY.copy()
        angles[4] = CHAIN_UPPER[4] + np.deg2rad(beyond)
        assert judged(angles).joints == pytest.approx(expected)
    angles = EASY.copy()
    angles[4] = 0.0
    assert judged(angles).joints == 0


def test_the_shoulder_turns_and_lifts_as_far_as_its_plane_lets_it() -> None:
    assert np.rad2deg(highest_elevation(np.deg2rad([-90.0, 90.0]))) == pytest.approx([62, 167])
    low, high = rotation_range(np.deg2rad(np.array([0.0, 90.0])))
    assert np.rad2deg(low) == pytest.approx([-104, -150])
    assert np.rad2deg(high) == pytest.approx([69, 30])
    behind = np.deg2rad([-90.0, 80.0, 90.0, 60.0, 0.0, 0.0, 0.0])
    assert range_use(behind)[1] == pytest.approx(1 + 1.8)  # 18 deg too far
    turned = np.deg2rad([90.0, 45.0, 50.0, 60.0, 0.0, 0.0, 0.0])
    assert range_use(turned)[2] == pytest.approx(1 + 2.0)


def test_a_hanging_or_straight_arm_is_no_strain() -> None:
    assert np.abs(range_use(np.zeros(7))[[1, 3]]).max() == 0


def test_an_elbow_above_the_shoulder_counts() -> None:
    heights = [judged(elbow=[0.3, -0.1, z]).elbow for z in (-0.06, 0.0, 0.05, 0.10)]
    assert heights == pytest.approx([0, 0.5, 1.0, 1.5])


def test_an_elbow_in_the_chest_counts() -> None:
    assert judged(elbow=[0.0, 0.12, -0.2]).trunk > 1
    assert judged(elbow=[0.0, -0.03, -0.33]).trunk == 0  # beside it
    assert judged(elbow=[0.0, 0.12, 0.2]).trunk == 0  # above it


def test_a_forearm_in_the_table_counts_and_one_before_it_does_not() -> None:
    height = ARM.stature * Seat().height
    radius = 0.024 * ARM.stature
    on_table = np.array([0.25, -0.1, -height + radius])
    wrist = np.array([0.45, 0.0, -height + 0.1])
    assert judged(elbow=on_table, wrist=wrist).table == pytest.approx(0.0, abs=1e-12)
    deeper = on_table - [0, 0, 0.02]
    assert judged(elbow=deeper, wrist=wrist).table == pytest.approx(1.0)
    assert judged(elbow=deeper - [0.2, 0, 0], wrist=wrist).table < 0.3
    assert judged(elbow=deeper, wrist=wrist, seat=Seat(height=0.3)).table == 0

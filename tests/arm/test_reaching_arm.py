from time import perf_counter

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.arm.arm_geometry import Seat
from handsim.arm.arm_joints import CHAIN_LOWER, CHAIN_UPPER
from handsim.arm.reaching_arm import ReachingArm
from handsim.arm.swivel import SwivelLaw
from handsim.errors import InputError
from handsim.types import HandSize

RIGHT = ReachingArm()
LEFT = ReachingArm(HandSize(side="left"))


def path(n: int = 200, down_deg: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    """From beside to the middle of the table, the palm down, then up by 12 cm."""
    s = np.linspace(0.0, 1.0, n)[:, None]
    pos = np.array([-0.2, -0.2, 0.08]) + s * [0.08, 0.12, 0.0] + s**2 * [0.0, 0.0, 0.12]
    turn = Rotation.from_euler("zy", [30.0, down_deg], degrees=True)
    return pos, np.tile(turn.as_quat(scalar_first=True), (n, 1))


def test_the_palm_is_where_it_should_be() -> None:
    pos, quat = path()
    found = RIGHT.posture(pos, quat)
    got, rotation = RIGHT.palm(found.arm, found.wrist)
    assert np.abs(got - pos).max() < 1e-9
    wanted = Rotation.from_quat(quat, scalar_first=True).as_matrix()
    assert np.abs(rotation - wanted).max() < 1e-9
    assert found.position_error.max() < 1e-9
    assert found.rotation_error.max() < 1e-6
    assert found.strain.max() < 1.0


def test_the_elbow_is_beside_the_person_and_below_the_shoulder() -> None:
    found = RIGHT.posture(*path())
    shoulder = RIGHT.geometry.shoulder()
    reach = np.linalg.norm(found.elbow - shoulder, axis=1)
    assert reach == pytest.approx(np.full(len(reach), RIGHT.geometry.upper_arm))
    assert found.elbow[:, 2].max() < shoulder[2] - 0.1
    assert (found.elbow[:, 1] < -0.12).all()


def test_a_movement_is_smooth() -> None:
    found = RIGHT.posture(*path(600))
    steps = np.abs(np.diff(found.arm, n=2, axis=0)).max()
    assert steps < np.deg2rad(0.05)


def test_a_left_arm_is_the_mirror_image() -> None:
    pos, quat = path()
    right = RIGHT.posture(pos, quat, np.array([0.1, 0.05]))
    left = LEFT.posture(pos * [1, -1, 1], quat * [1, -1, 1, -1], np.array([0.1, 0.05]))
    assert np.abs(left.arm - right.arm).max() < 1e-9
    assert np.abs(left.wrist - right.wrist).max() < 1e-9
    assert np.abs(left.elbow - right.elbow * [1, -1, 1]).max() < 1e-9
    assert LEFT.palm(left.arm, left.wrist)[0] == pytest.approx(pos * [1, -1, 1])


def test_the_wrist_goes_towards_what_is_asked_of_it() -> None:
    pos, quat = path()
    plain = RIGHT.posture(pos, quat).wrist.mean(axis=0)
    for change in ([0.0, 0.3], [0.0, -0.3]):
        asked = RIGHT.posture(pos, quat, plain + change).wrist.mean(axis=0)
        assert np.sign(change[1]) * (asked - plain)[1] > np.deg2rad(3)


def test_the_law_draws_the_elbow() -> None:
    pos, quat = path()
    low, high = (
        ReachingArm(law=SwivelLaw(np.deg2rad(angle), spread=0.05)).posture(pos, quat).swivel
        for angle in (10.0, 45.0)
    )
    assert np.rad2deg(np.median(low)) == pytest.approx(10, abs=6)
    assert np.rad2deg(np.median(high)) == pytest.approx(45, abs=6)


def test_what_is_too_far_is_said_and_pointed_at() -> None:
    pos, quat = path()
    found = RIGHT.posture(pos + [0.6, 0.0, 0.0], quat)
    distance = np.linalg.norm(pos + [0.6, 0, 0] - RIGHT.geometry.shoulder(), axis=1)
    assert found.position_error == pytest.approx(distance - RIGHT.geometry.reach, abs=0.02)
    assert found.strain.min() > 10


def test_no_joint_leaves_its_range_and_what_is_missed_is_measured() -> None:
    pos, quat = path()
    backwards = Rotation.from_euler("z", 180, degrees=True) * Rotation.from_quat(
        quat, scalar_first=True
    )
    found = RIGHT.posture(pos, backwards.as_quat(scalar_first=True))
    angles = np.hstack([found.arm, found.wrist])
    assert (angles >= CHAIN_LOWER - 1e-12).all()
    assert (angles <= CHAIN_UPPER + 1e-12).all()
    assert (np.abs(found.use).max(axis=1) > 1).all()
    got = RIGHT.palm(found.arm, found.wrist)[1]
    missed = (Rotation.from_matrix(got).inv() * backwards).magnitude()
    assert found.rotation_error == pytest.approx(missed)
    assert found.rotation_error.min() > np.deg2rad(20)


def test_one_pose_is_a_path() -> None:
    pos, quat = path(1)
    assert RIGHT.posture(pos, quat).arm.shape == (1, 5)
    assert RIGHT.posture(*path(2)).arm.shape == (2, 5)


def test_another_seat_is_another_arm() -> None:
    pos, quat = path()
    near = ReachingArm(seat=Seat(distance=0.2)).posture(pos, quat)
    assert near.arm[:, 3].min() > RIGHT.posture(pos, quat).arm[:, 3].min() + 0.2


def test_quaternions_need_no_unit_length() -> None:
    pos, quat = path()
    assert RIGHT.posture(pos, 2 * quat).arm == pytest.approx(RIGHT.posture(pos, quat).arm)


@pytest.mark.parametrize(
    ("pos", "quat", "wrist", "said"),
    [
        (np.zeros((3, 2)), np.ones((3, 4)), None, "give"),
        (np.zeros((3, 3)), np.ones((2, 4)), None, "give"),
        (np.zeros((0, 3)), np.ones((0, 4)), None, "give"),
        (np.zeros((3, 3)), np.ones((3, 4)), np.zeros((3, 1)), "give"),
        (np.full((3, 3), np.nan), np.ones((3, 4)), None, "finite"),
        (np.zeros((3, 3)), np.zeros((3, 4)), None, "quaternion"),
    ],
)
def test_bad_input_is_said_in_one_line(pos, quat, wrist, said) -> None:
    with pytest.raises(InputError, match=said) as error:
        RIGHT.posture(pos, quat, wrist)
    assert "\n" not in str(error.value)


def test_a_path_of_600_poses_takes_little_time() -> None:
    """8 ms where it was measured; 50 ms were asked for."""
    pos, quat = path(600)
    taken = []
    for _ in range(10):
        began = perf_counter()
        RIGHT.posture(pos, quat)
        taken.append(perf_counter() - began)
    assert min(taken) < 0.05


def test_a_path_that_is_asked_for_again_is_known_and_another_is_not():
    arm = ReachingArm()
    pos, quat = np.tile([-0.12, -0.08, 0.12], (30, 1)), np.tile([1.0, 0.0, 0.0, 0.0], (30, 1))
    pos[:, 0] += np.linspace(0.0, 0.05, 30)
    found = arm.posture(pos, quat)
    assert arm.posture(pos.copy(), quat.copy()) is found
    assert not found.arm.flags.writeable
    kept = found.arm.copy()
    pos[-1] += 0.01
    for other in (
        arm.posture(pos, quat),
        arm.posture(pos, quat, np.array([0.1, 0.0])),
        ReachingArm(HandSize(0.175, 0.078)).posture(pos, quat),
    ):
        assert not np.array_equal(other.arm, kept)
    np.testing.assert_array_equal(found.arm, kept)


def test_positions_and_orientations_may_be_numbers_of_any_kind() -> None:
    pos, quat = np.array([[0, 0, 0], [0, 0, 0]]), np.array([[1, 0, 0, 0], [1, 0, 0, 0]])
    np.testing.assert_array_equal(
        RIGHT.posture(pos, quat).arm, RIGHT.posture(pos.astype(float), quat.astype(float)).arm
    )

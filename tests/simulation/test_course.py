"""What a run is told to do, checked without physics."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.hand.tasks import task_by_name
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.simulation.closings import REST
from handsim.simulation.conditions import Conditions
from handsim.simulation.course import LOST, Course
from handsim.simulation.glove import DataGlove
from handsim.simulation.plan import GraspPlan, Pose, Schedule, schedule_for
from handsim.simulation.squeeze import squeeze_offset

MOVE = task_by_name("jar-move")
MOVE = replace(MOVE, yaw_deg=90.0, grasp=replace(MOVE.grasp, fingers=("index", "middle")))
TURNED = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
PLAN = GraspPlan(
    Pose(np.array([0.1, 0.02, 0.05]), TURNED.as_quat(scalar_first=True)),
    retreat=np.array([-0.16, 0.0, 0.0]),
    q_start=REST,
    q_goal=REST,
    squeeze=0.8,
)
SCHEDULE = Schedule(steps=(0.8, 0.8), hold=3.1)
"""Reach until 1.2 s, squeeze until 1.7 s, lift until 2.5 s, move until 3.3 s, hold until 6.4 s."""
QUIET = DataGlove(noise=0.0)


@pytest.fixture(scope="module")
def course() -> Course:
    return Course.of(PLAN, MOVE, SCHEDULE)


def test_there_is_a_row_for_each_hundredth_of_a_second_to_the_end(course):
    assert schedule_for(MOVE) == SCHEDULE
    assert SCHEDULE.hold_start == pytest.approx(3.3)
    np.testing.assert_allclose(course.times, np.arange(641) / 100)
    for rows in (course.palm_pos, course.palm_quat, course.added, course.lift, course.disturbance):
        assert len(rows) == 641


def test_the_palm_goes_to_the_object_as_it_is_expected_to_stand(course):
    """Turned by 90 deg to the left, so that the object's x is the world's y."""
    np.testing.assert_allclose(course.palm_pos[150], [-0.02, 0.1, 0.05], atol=1e-12)
    np.testing.assert_allclose(course.palm_pos[0], [-0.02, -0.06, 0.05], atol=1e-12)
    expected = Rotation.from_euler("z", 90, degrees=True) * TURNED
    reached = Rotation.from_quat(course.palm_quat[150], scalar_first=True)
    assert (reached * expected.inv()).magnitude() == pytest.approx(0.0, abs=1e-9)


def test_the_squeeze_begins_when_the_reach_ends_and_is_whole_in_the_action(course):
    whole = squeeze_offset(0.8, ("index", "middle"))
    assert whole[JOINT_INDEX["thumb_mcp"]] == pytest.approx(np.deg2rad(8.0))
    assert not whole[JOINT_INDEX["ring_mcp"]]
    np.testing.assert_array_equal(course.added[:121], np.zeros((121, 22)))
    assert (course.added[122, whole > 0] > 0).all()
    np.testing.assert_allclose(course.added[145], 0.5 * whole, atol=1e-12)
    np.testing.assert_allclose(course.added[170:], np.tile(whole, (471, 1)), atol=1e-12)


def test_fingers_that_act_are_added_to_the_squeeze():
    click = task_by_name("mouse-left-click")
    acting = Course.of(PLAN, click, schedule_for(click))
    index = JOINT_INDEX["index_mcp"]
    assert acting.added[170, index] == 0.0
    assert acting.added[200, index] == pytest.approx(np.deg2rad(12.0))
    squeezed = squeeze_offset(0.8, click.grasp.fingers)
    np.testing.assert_allclose(np.delete(acting.added[200] - squeezed, index), 0.0, atol=1e-12)


def test_arrival_is_the_last_reading_of_the_reach(course):
    assert course.arrival == 120
    between = Course.of(PLAN, MOVE, replace(SCHEDULE, reach=1.205))
    assert between.arrival == 120


def test_the_lift_is_what_the_palm_rose_since_the_action_began(course):
    assert (course.lift[:171] == -np.inf).all()
    assert np.isfinite(course.lift[171:]).all()
    assert course.lift[210] == pytest.approx(0.06)
    np.testing.assert_allclose(course.lift[250:], 0.12, atol=1e-9)
    assert LOST == 0.02


def shaken(acceleration: float, seed: int = 0) -> Course:
    course = Course.of(PLAN, MOVE, SCHEDULE)
    return course.disturbed(Conditions(seed=seed, shake=acceleration), QUIET)


def test_the_hand_is_shaken_in_the_hold_alone(course):
    way = shaken(2.0).palm_pos - course.palm_pos
    np.testing.assert_allclose(way[:331], 0.0, atol=1e-12)
    assert np.linalg.norm(way[335:], axis=1).max() > 0.01
    assert np.abs(way[:, 2]).max() == 0.0
    np.testing.assert_array_equal(shaken(2.0).palm_quat, course.palm_quat)


@pytest.mark.parametrize("acceleration", [1.0, 2.0])
def test_shaking_has_the_amplitude_and_frequency_that_are_said(course, acceleration):
    way = (shaken(acceleration).palm_pos - course.palm_pos)[380:]  # it has grown for 0.5 s
    along = np.linalg.svd(way, full_matrices=False)[2][0]
    np.testing.assert_allclose(way, np.outer(way @ along, along), atol=1e-9)  # one direction
    swing = way @ along
    felt = np.diff(swing, 2) * 100**2
    assert np.abs(felt).max() == pytest.approx(acceleration, rel=0.01)
    np.testing.assert_allclose(swing[25:], -swing[:-25], atol=1e-9)  # half a swing of 2 Hz


def test_shaking_grows_smoothly(course):
    """From sample 330 on, by minimum jerk within half a second: half of it after a quarter."""
    way = np.linalg.norm((shaken(2.0).palm_pos - course.palm_pos)[330:], axis=1)
    amplitude = 2.0 / (4 * np.pi) ** 2
    sine = np.abs(np.sin(4 * np.pi * np.arange(len(way)) / 100))
    assert way[20] == pytest.approx(amplitude * sine[20] * (10 - 15 * 0.4 + 6 * 0.16) * 0.4**3)
    np.testing.assert_allclose(way[50:], amplitude * sine[50:], atol=1e-12)


def test_shaking_has_the_direction_of_its_seed(course):
    ways = [(shaken(2.0, seed).palm_pos - course.palm_pos)[340, :2] for seed in range(40)]
    for seed, way in enumerate(ways):
        angle = np.random.default_rng(seed).uniform(0.0, 2 * np.pi)
        np.testing.assert_allclose(
            way / np.linalg.norm(way), [np.cos(angle), np.sin(angle)], atol=1e-9
        )
    quadrants = {tuple(np.sign(way)) for way in ways}
    assert len(quadrants) == 4


def test_nothing_is_shaken_or_misread_unless_asked_for(course):
    np.testing.assert_array_equal(shaken(0.0).palm_pos, course.palm_pos)
    assert not course.disturbance.any()
    assert not shaken(2.0).disturbance.any()


def test_noise_follows_the_seed_and_the_glove(course):
    noisy = [course.disturbed(Conditions(seed=seed), DataGlove()) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(noisy[0].disturbance, noisy[1].disturbance)
    assert (noisy[0].disturbance != noisy[2].disturbance).any()
    assert np.rad2deg(noisy[0].disturbance.std()) == pytest.approx(0.25, rel=0.05)


def test_commands_are_targets_and_what_is_added_within_the_ranges(course):
    targets = 0.5 * (LOWER + UPPER)
    np.testing.assert_allclose(course.commanded(targets, 100), targets)
    np.testing.assert_allclose(
        course.commanded(targets, slice(120, None)), targets + course.added[120:]
    )
    np.testing.assert_array_equal(course.commanded(UPPER, 200), UPPER)
    np.testing.assert_array_equal(course.commanded(LOWER - 1.0, 0), LOWER)

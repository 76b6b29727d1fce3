"""Commands of a run, checked without physics."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Pose, Schedule, schedule_for
from handsim.grasping.planning.preshapes import REST
from handsim.grasping.rollout.commands import LOST, Commands
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.squeeze import squeeze_offset
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.tasks.table_one import task_by_name

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
def commands() -> Commands:
    return Commands.of(PLAN, MOVE, SCHEDULE)


def test_there_is_a_row_for_each_hundredth_of_a_second_to_the_end(commands):
    assert schedule_for(MOVE) == SCHEDULE
    assert SCHEDULE.hold_start == pytest.approx(3.3)
    np.testing.assert_allclose(commands.times, np.arange(641) / 100)
    for rows in (
        commands.palm_pos,
        commands.palm_quat,
        commands.added,
        commands.lift,
        commands.disturbance,
    ):
        assert len(rows) == 641


def test_the_palm_goes_to_the_object_as_it_is_expected_to_stand(commands):
    """Turned by 90 deg to the left, so that the object's x is the world's y."""
    np.testing.assert_allclose(commands.palm_pos[150], [-0.02, 0.1, 0.05], atol=1e-12)
    np.testing.assert_allclose(commands.palm_pos[0], [-0.02, -0.06, 0.05], atol=1e-12)
    expected = Rotation.from_euler("z", 90, degrees=True) * TURNED
    reached = Rotation.from_quat(commands.palm_quat[150], scalar_first=True)
    assert (reached * expected.inv()).magnitude() == pytest.approx(0.0, abs=1e-9)


def test_the_squeeze_begins_when_the_reach_ends_and_is_whole_in_the_action(commands):
    whole = squeeze_offset(0.8, ("index", "middle"))
    assert whole[JOINT_INDEX["thumb_mcp"]] == pytest.approx(np.deg2rad(8.0))
    assert not whole[JOINT_INDEX["ring_mcp"]]
    np.testing.assert_array_equal(commands.added[:121], np.zeros((121, 22)))
    assert (commands.added[122, whole > 0] > 0).all()
    np.testing.assert_allclose(commands.added[145], 0.5 * whole, atol=1e-12)
    np.testing.assert_allclose(commands.added[170:], np.tile(whole, (471, 1)), atol=1e-12)


def test_fingers_that_act_are_added_to_the_squeeze():
    click = task_by_name("mouse-left-click")
    acting = Commands.of(PLAN, click, schedule_for(click))
    index = JOINT_INDEX["index_mcp"]
    assert acting.added[170, index] == 0.0
    assert acting.added[200, index] == pytest.approx(np.deg2rad(12.0))
    squeezed = squeeze_offset(0.8, click.grasp.fingers)
    np.testing.assert_allclose(np.delete(acting.added[200] - squeezed, index), 0.0, atol=1e-12)


def test_arrival_is_the_last_reading_of_the_reach(commands):
    assert commands.arrival == 120
    between = Commands.of(PLAN, MOVE, replace(SCHEDULE, reach=1.205))
    assert between.arrival == 120


def test_the_lift_is_what_the_palm_rose_since_the_action_began(commands):
    assert (commands.lift[:171] == -np.inf).all()
    assert np.isfinite(commands.lift[171:]).all()
    assert commands.lift[210] == pytest.approx(0.06)
    np.testing.assert_allclose(commands.lift[250:], 0.12, atol=1e-9)
    assert LOST == 0.02


def shaken(acceleration: float, seed: int = 0) -> Commands:
    commands = Commands.of(PLAN, MOVE, SCHEDULE)
    return commands.disturbed(Conditions(seed=seed, shake=acceleration), QUIET)


def test_the_hand_is_shaken_in_the_hold_alone(commands):
    way = shaken(2.0).palm_pos - commands.palm_pos
    np.testing.assert_allclose(way[:331], 0.0, atol=1e-12)
    assert np.linalg.norm(way[335:], axis=1).max() > 0.01
    assert np.abs(way[:, 2]).max() == 0.0
    np.testing.assert_array_equal(shaken(2.0).palm_quat, commands.palm_quat)


@pytest.mark.parametrize("acceleration", [1.0, 2.0])
def test_shaking_has_the_amplitude_and_frequency_that_are_said(commands, acceleration):
    way = (shaken(acceleration).palm_pos - commands.palm_pos)[380:]  # it has grown for 0.5 s
    along = np.linalg.svd(way, full_matrices=False)[2][0]
    np.testing.assert_allclose(way, np.outer(way @ along, along), atol=1e-9)  # one direction
    swing = way @ along
    felt = np.diff(swing, 2) * 100**2
    assert np.abs(felt).max() == pytest.approx(acceleration, rel=0.01)
    np.testing.assert_allclose(swing[25:], -swing[:-25], atol=1e-9)  # half a swing of 2 Hz


def test_shaking_grows_smoothly(commands):
    """From sample 330 on, by minimum jerk within half a second: half of it after a quarter."""
    way = np.linalg.norm((shaken(2.0).palm_pos - commands.palm_pos)[330:], axis=1)
    amplitude = 2.0 / (4 * np.pi) ** 2
    sine = np.abs(np.sin(4 * np.pi * np.arange(len(way)) / 100))
    assert way[20] == pytest.approx(amplitude * sine[20] * (10 - 15 * 0.4 + 6 * 0.16) * 0.4**3)
    np.testing.assert_allclose(way[50:], amplitude * sine[50:], atol=1e-12)


def test_shaking_has_the_direction_of_its_seed(commands):
    ways = [(shaken(2.0, seed).palm_pos - commands.palm_pos)[340, :2] for seed in range(40)]
    for seed, way in enumerate(ways):
        angle = np.random.default_rng(seed).uniform(0.0, 2 * np.pi)
        np.testing.assert_allclose(
            way / np.linalg.norm(way), [np.cos(angle), np.sin(angle)], atol=1e-9
        )
    quadrants = {tuple(np.sign(way)) for way in ways}
    assert len(quadrants) == 4


def test_nothing_is_shaken_or_misread_unless_asked_for(commands):
    np.testing.assert_array_equal(shaken(0.0).palm_pos, commands.palm_pos)
    assert not commands.disturbance.any()
    assert not shaken(2.0).disturbance.any()


def test_noise_follows_the_seed_and_the_glove(commands):
    noisy = [commands.disturbed(Conditions(seed=seed), DataGlove()) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(noisy[0].disturbance, noisy[1].disturbance)
    assert (noisy[0].disturbance != noisy[2].disturbance).any()
    assert np.rad2deg(noisy[0].disturbance.std()) == pytest.approx(0.25, rel=0.05)


def test_commands_are_targets_and_what_is_added_within_the_ranges(commands):
    targets = 0.5 * (LOWER + UPPER)
    np.testing.assert_allclose(commands.commanded(targets, 100), targets)
    np.testing.assert_allclose(
        commands.commanded(targets, slice(120, None)), targets + commands.added[120:]
    )
    np.testing.assert_array_equal(commands.commanded(UPPER, 200), UPPER)
    np.testing.assert_array_equal(commands.commanded(LOWER - 1.0, 0), LOWER)


def test_commands_of_several_runs_are_those_of_each():
    each = [shaken(2.0, seed) for seed in range(3)]
    together = Commands.together(each)
    assert together.schedule is SCHEDULE
    targets = LOWER + np.linspace(0.1, 0.9, 3)[:, None] * (UPPER - LOWER)
    for rows in (130, slice(125, None)):
        ctrl = together.commanded(targets, rows)
        for i, alone in enumerate(each):
            np.testing.assert_array_equal(ctrl[..., i, :], alone.commanded(targets[i], rows))
            for name in ("palm_pos", "palm_quat", "added", "disturbance"):
                mine, its = getattr(together, name)[rows], getattr(alone, name)[rows]
                np.testing.assert_array_equal(mine[..., i, :], its)
            np.testing.assert_array_equal(together.lift[:, i], alone.lift)


def test_an_object_is_due_to_rise_once_the_palm_has_risen_twice_as_far(commands):
    due = commands.due_to_rise(0.1)
    assert due[210] and not due[170]
    np.testing.assert_array_equal(due, commands.lift >= 0.04)
    np.testing.assert_array_equal(commands.due_to_rise(LOST), due)
    assert not commands.due_to_rise(0.0199).any()  # what is not to be lifted

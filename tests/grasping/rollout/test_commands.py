"""Commands of a run, checked without physics."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.arm.reaching_arm import ReachingArm
from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.squeeze import closing, squeeze_offset
from handsim.grasping.plan import GraspPlan, Pose, Schedule, schedule_for
from handsim.grasping.planning.preshapes import REST
from handsim.grasping.rollout.commands import LOST, Commands
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.glove import DataGlove
from handsim.hand.kinematics import Kinematics
from handsim.joints import JOINT_INDEX, JOINTS
from handsim.tasks.scene import start_pose
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

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
    for name in (
        *("palm_pos", "palm_quat", "closed", "flexion", "lift", "load", "disturbance", "lost"),
        "weight",
    ):
        assert len(getattr(commands, name)) == 641


def test_the_palm_goes_to_the_object_as_it_is_expected_to_stand(commands):
    """Turned by 90 deg to the left, so that the object's x is the world's y."""
    np.testing.assert_allclose(commands.palm_pos[150], [-0.02, 0.1, 0.05], atol=1e-12)
    np.testing.assert_allclose(commands.palm_pos[0], [-0.02, -0.06, 0.05], atol=1e-12)
    expected = Rotation.from_euler("z", 90, degrees=True) * TURNED
    reached = Rotation.from_quat(commands.palm_quat[150], scalar_first=True)
    assert (reached * expected.inv()).magnitude() == pytest.approx(0.0, abs=1e-9)


def test_the_palm_goes_where_the_object_stands_on_the_table(commands):
    moved = Commands.of(PLAN, replace(MOVE, place=(0.03, -0.07)), SCHEDULE)
    away = moved.palm_pos - commands.palm_pos
    np.testing.assert_allclose(away, np.tile([0.03, -0.07, 0.0], (len(away), 1)), atol=1e-12)
    np.testing.assert_allclose(moved.palm_quat, commands.palm_quat, atol=1e-12)


def test_the_hand_turns_an_object_about_itself_wherever_it_stands():
    drink = task_by_name("cup-drink")
    usual, moved = (
        Commands.of(PLAN, replace(drink, place=place), schedule_for(drink)).palm_pos
        for place in ((0.0, 0.0), (0.1, 0.1))
    )
    np.testing.assert_allclose(moved - usual, np.tile([0.1, 0.1, 0.0], (len(usual), 1)), atol=1e-12)


def test_the_squeeze_begins_when_the_reach_ends_and_is_whole_in_the_action(commands):
    fingers = squeeze_offset(0.8, ("index", "middle"))
    assert fingers[JOINT_INDEX["index_mcp"]] == pytest.approx(np.deg2rad(0.8 * 12.0))
    assert not fingers[JOINT_INDEX["ring_mcp"]]
    of_thumb = [joint.finger == "thumb" for joint in JOINTS]
    np.testing.assert_array_equal(
        commands.closing[~np.array(of_thumb)], fingers[~np.array(of_thumb)]
    )
    # The thumb's most moved joint goes 12 deg times the squeeze; its pad goes the grasp's way.
    assert np.abs(commands.closing[of_thumb]).max() == pytest.approx(np.deg2rad(0.8 * 12.0))
    across = TURNED.inv().apply(MOVE.grasp.opposition)
    kept = closing(REST, across, MOVE.grasp.fingers, 0.8, Kinematics(HandSize()))
    np.testing.assert_allclose(commands.closing, kept, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(commands.closed[:121], 0.0)
    assert commands.closed[122] > 0.0
    assert commands.closed[145] == pytest.approx(0.5)
    np.testing.assert_allclose(commands.closed[170:], 1.0)


def test_each_hand_closes_as_its_own_size_and_side_say():
    """In whatever order they come: of the thumbs, a left one goes another way."""
    across, found = PLAN.palm.rotation.inv().apply(MOVE.grasp.opposition), []
    for side in ("right", "left", "right"):
        size = HandSize(0.18, 0.08, side)
        found.append(Commands.of(PLAN, MOVE, SCHEDULE, size).closing)
        expected = closing(PLAN.q_goal, across, MOVE.grasp.fingers, PLAN.squeeze, Kinematics(size))
        np.testing.assert_array_equal(found[-1], expected)
    assert np.abs(found[1] - found[0]).max() > 0.01
    np.testing.assert_array_equal(found[2], found[0])


def test_fingers_that_act_flex_beside_the_squeeze():
    click = task_by_name("mouse-left-click")
    acting = Commands.of(PLAN, click, schedule_for(click))
    index = JOINT_INDEX["index_mcp"]
    assert acting.flexion[170, index] == 0.0
    assert acting.flexion[200, index] == pytest.approx(np.deg2rad(12.0))
    assert not np.delete(acting.flexion, index, axis=1).any()


def test_commands_know_when_the_action_begins_and_whether_it_lifts(commands):
    assert commands.action == 170
    assert commands.lifted
    click = task_by_name("mouse-left-click")
    assert not Commands.of(PLAN, click, schedule_for(click)).lifted


def test_the_load_is_gravity_and_what_accelerates_the_palm(commands):
    """Up by 12 cm in 0.8 s by minimum jerk: at most 5.77 h / T^2, 1.08 m/s^2."""
    np.testing.assert_allclose(commands.load[120:170], np.tile([0, 0, 9.81], (50, 1)), atol=1e-9)
    assert commands.load[170:251, 2].max() == pytest.approx(9.81 + 5.7735 * 0.12 / 0.64, rel=2e-3)
    assert commands.load[170:251, 2].min() == pytest.approx(9.81 - 5.7735 * 0.12 / 0.64, rel=2e-3)
    np.testing.assert_allclose(commands.load[331:], np.tile([0, 0, 9.81], (310, 1)), atol=1e-6)


def test_the_hand_is_to_carry_the_weight_and_what_lifts_it(commands):
    """Whatever the object really weighs, and however the hand is shaken sideways."""
    mass = MOVE.object.mass
    np.testing.assert_allclose(commands.weight, mass * commands.load[:, 2], rtol=1e-12)
    assert commands.weight[-1] == pytest.approx(9.81 * mass, rel=1e-6)
    heavy = commands.disturbed(Conditions(seed=3, shake=2.0, mass_scale=2.0), QUIET)
    np.testing.assert_array_equal(heavy.weight, commands.weight)


def test_the_load_grows_with_the_shaking(commands):
    felt = shaken(2.0).load - commands.load
    assert np.linalg.norm(felt[400:], axis=1).max() == pytest.approx(2.0, rel=0.01)
    assert np.abs(felt[:, 2]).max() < 1e-9
    np.testing.assert_allclose(felt[:330], 0.0, atol=1e-9)


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


def disturbed(**values) -> Commands:
    """Commands of a run whose glove has no noise."""
    return Commands.of(PLAN, MOVE, SCHEDULE).disturbed(Conditions(**values), QUIET)


def test_a_biased_glove_is_off_in_every_joint_to_one_side_or_the_other():
    off = disturbed(bias=0.05).disturbance
    np.testing.assert_array_equal(off, np.tile(off[0], (641, 1)))
    np.testing.assert_allclose(np.abs(off[0]), 0.05)
    assert 3 < (off[0] > 0).sum() < 19
    assert (disturbed(bias=0.05, seed=1).disturbance[0] != off[0]).any()
    np.testing.assert_array_equal(disturbed(bias=0.05).disturbance, off)


def test_a_glove_drifts_with_time_to_the_side_of_its_bias():
    drift = disturbed(drift=0.02).disturbance
    np.testing.assert_allclose(np.abs(drift), 0.02 * np.arange(641)[:, None] / 100 * np.ones(22))
    both = disturbed(bias=0.05, drift=0.02).disturbance
    np.testing.assert_allclose(both, disturbed(bias=0.05).disturbance + drift)
    assert (np.sign(both[-1]) == np.sign(both[0])).all()


def test_readings_are_lost_in_their_share_at_random():
    assert not disturbed().lost.any()
    lost = disturbed(lost=0.3).lost
    assert lost.mean() == pytest.approx(0.3, abs=0.05)
    assert 50 < np.diff(lost.astype(int)).astype(bool).sum() < 400  # in no long stretches
    assert (disturbed(lost=0.3, seed=1).lost != lost).any()


def test_what_else_disturbs_leaves_noise_and_shaking_as_they_were():
    """A seed is the same trial whether or not its glove is biased, late or loses readings."""
    usual = Commands.of(PLAN, MOVE, SCHEDULE).disturbed(Conditions(shake=2.0), DataGlove())
    other = Commands.of(PLAN, MOVE, SCHEDULE).disturbed(
        Conditions(shake=2.0, bias=0.05, drift=0.01, lost=0.2), DataGlove()
    )
    np.testing.assert_array_equal(usual.palm_pos, other.palm_pos)
    added = other.disturbance - usual.disturbance
    expected = 0.05 + 0.01 * np.arange(641)[:, None] / 100
    np.testing.assert_allclose(np.abs(added), expected * np.ones(22), atol=1e-12)


def test_commands_of_several_runs_are_those_of_each():
    each = [disturbed(shake=2.0, bias=0.01, lost=0.2, seed=seed) for seed in range(3)]
    together = Commands.together(each)
    assert together.schedule is SCHEDULE
    for i, alone in enumerate(each):
        for name in ("palm_pos", "palm_quat", "lift", "load", "weight", "disturbance", "lost"):
            np.testing.assert_array_equal(getattr(together, name)[:, i], getattr(alone, name))
    for name in ("closing", "closed", "flexion"):
        np.testing.assert_array_equal(getattr(together, name), getattr(each[0], name))


def test_an_object_is_due_to_rise_once_the_palm_has_risen_twice_as_far(commands):
    due = commands.due_to_rise(0.1)
    assert due[210] and not due[170]
    np.testing.assert_array_equal(due, commands.lift >= 0.04)
    np.testing.assert_array_equal(commands.due_to_rise(LOST), due)
    assert not commands.due_to_rise(0.0199).any()  # what is not to be lifted


def test_an_arm_follows_the_palm_and_would_like_the_plans_wrist():
    task = task_by_name("cube-raise")
    pos, quat = start_pose(task, Conditions().hand)
    turn = Rotation.from_euler("z", -np.deg2rad(task.yaw_deg))
    palm = Pose(turn.apply(pos), (turn * Rotation.from_quat(quat, scalar_first=True)).as_quat(
        scalar_first=True
    ))  # fmt: skip
    plan = replace(PLAN, palm=palm, retreat=np.array([0.0, 0.0, 0.02]))
    commands = Commands.of(plan, task, schedule_for(task))
    assert commands.reach is None
    arm, q = ReachingArm(), np.zeros(22)
    reach = commands.reached(arm, q).reach
    assert reach is not None
    assert reach.arm.shape == (len(commands.times), 5)
    where, turned = arm.palm(reach.arm, reach.wrist)
    np.testing.assert_allclose(where, commands.palm_pos, atol=1e-9)
    wanted = Rotation.from_quat(commands.palm_quat, scalar_first=True).as_matrix()
    np.testing.assert_allclose(turned, wanted, atol=1e-9)
    q[WRIST_COLUMNS] = np.deg2rad([25.0, 10.0])
    bent = commands.reached(arm, q).reach
    assert (bent.wrist - reach.wrist)[:, 0].min() > 0.01

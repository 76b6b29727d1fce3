"""What a robot is told follows what the controller does with a person's hand."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.grasping.plan import schedule_for
from handsim.grasping.robots.robot_movement import WIDER, robot_movement, told_postures
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.drivers import ScriptedDriver, learned_driver
from handsim.joints import FINGERS, JOINT_INDEX, N_JOINTS, clip_to_range
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")
HOLDING = ("index", "middle", "ring")


@pytest.fixture(scope="module")
def commands(plan):
    return Commands.of(plan, TASK, schedule_for(TASK))


@pytest.fixture(scope="module")
def driver(controller, plan):
    schedule = schedule_for(TASK)
    return learned_driver(controller, plan, np.zeros(N_JOINTS), schedule, TASK.object_name)


@pytest.fixture(scope="module")
def movement(retargeter, driver, commands):
    return robot_movement(retargeter, driver, commands, 0.8, HOLDING)


def test_the_postures_are_the_path_of_the_controller_to_its_destination(driver, commands):
    q = told_postures(driver, commands)
    assert len(q) == len(commands.times)
    step = driver.timing.velocities(driver.z_start[None], 0.0) * 0.01
    z = driver.controller.subspace.transform(q)
    np.testing.assert_allclose(z[1], (driver.z_start + step)[0], atol=2e-3)  # clipped
    np.testing.assert_array_equal(q[-1], driver.destination)
    assert np.abs(np.diff(q, axis=0)).max() < np.deg2rad(5.0)


def test_a_script_is_played_as_it_is(commands, plan):
    q_open = clip_to_range(plan.q_start + 0.1)
    script = ScriptedDriver(plan.q_start, q_open, plan.q_goal, schedule_for(TASK).reach)
    q = told_postures(script, commands)
    np.testing.assert_array_equal(q[0], plan.q_start)
    np.testing.assert_allclose(q[-1], plan.q_goal)


def test_the_robot_ends_where_the_same_hand_ends(movement, retargeter, driver):
    """The own hand, at full size, has no other openings to make."""
    robot = retargeter.robot
    x = movement.told[-1]
    (mine, _, _), _ = robot.poses_in(robot.link_frames(x[None]))
    person = retargeter.person
    (theirs, _, _), _ = person.hand.poses_in(
        person.hand.link_frames(driver.destination[person.glove][None])
    )
    np.testing.assert_allclose(mine, theirs, atol=2e-3)


def test_what_was_mapped_before_is_not_mapped_again(
    retargeter, driver, commands, movement, monkeypatch
):
    """Where links evade each other, another processor maps the same postures otherwise."""
    mapped = Retargeter.retarget

    def elsewhere(self, q):
        found = mapped(self, q)
        return replace(found, positions=found.positions + 0.1)

    monkeypatch.setattr(Retargeter, "retarget", elsewhere)
    kept = robot_movement(retargeter, driver, commands, 0.8, HOLDING, movement.mapped)
    for name in ("told", "closing", "flexion", "shift", "mapped"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(movement, name))
    for other in (movement.mapped[1:], movement.mapped[:, 1:]):  # of another movement
        anew = robot_movement(retargeter, driver, commands, 0.8, HOLDING, other)
        np.testing.assert_allclose(anew.mapped, movement.mapped + 0.1)


def test_until_the_palm_is_there_it_opens_wider_along_the_squeeze(retargeter, driver, commands):
    early, late = (
        robot_movement(retargeter, driver, commands, arrival, HOLDING) for arrival in (0.3, 1.1)
    )
    row = 90  # at 0.9 s: long after the one arrival, before the other
    apart = early.told[row] - late.told[row]
    share = np.median(apart[early.closing != 0] / early.closing[early.closing != 0])
    assert 0.2 * WIDER < share < WIDER
    np.testing.assert_allclose(early.told[-1], late.told[-1], atol=1e-9)


def test_the_middle_between_thumb_and_fingers_goes_where_the_persons_does(movement, retargeter):
    robot, person = retargeter.robot, retargeter.person

    def middles(hand: RobotHand, x: np.ndarray) -> np.ndarray:
        (points, _, _), _ = hand.poses_in(hand.link_frames(x))
        fingers = [FINGERS.index(finger) for finger in HOLDING]
        return 0.5 * (points[:, 0] + points[:, fingers].mean(axis=1))

    mine = middles(robot, movement.told) + movement.shift
    theirs = middles(person.hand, movement.postures[:, person.glove])
    np.testing.assert_allclose(mine - mine[-1], theirs - theirs[-1], atol=1e-9)
    np.testing.assert_array_equal(movement.shift[-1], 0.0)


def test_what_jumps_from_posture_to_posture_is_evened_out(
    retargeter, driver, commands, movement, monkeypatch
):
    """Links that evade each other make a mapped movement jagged, and with it the palm's way."""
    mapped = Retargeter.retarget

    def jagged(self, q):
        found = mapped(self, q)
        to_and_fro = np.resize([0.05, -0.05], len(q))
        return replace(found, positions=found.positions + to_and_fro[:, None])

    monkeypatch.setattr(Retargeter, "retarget", jagged)
    jumping = robot_movement(retargeter, driver, commands, 0.8, HOLDING)
    fast, faster = (np.abs(np.diff(each.told, axis=0)).max() for each in (movement, jumping))
    assert faster < 1.2 * fast < 0.05  # of 0.1 rad to and fro
    assert np.abs(np.diff(jumping.shift, axis=0)).max() < 0.001  # of some 8 mm
    way = movement.told[: commands.arrival]
    assert np.ptp(way, axis=0).max() > 0.3  # which is not evened out


def test_a_finger_that_the_action_flexes_moves_by_itself(retargeter, driver, commands):
    flexion = np.zeros((len(commands.times), N_JOINTS))
    flexion[-50:, JOINT_INDEX["index_mcp"]] = np.deg2rad(15.0)
    moved = robot_movement(
        retargeter, driver, replace(commands, flexion=flexion), 0.8, HOLDING
    ).flexion
    names = retargeter.robot.joint_names
    assert np.rad2deg(moved[-1, names.index("index_mcp")]) > 5.0
    np.testing.assert_array_equal(moved[:-50], 0.0)
    others = [i for i, name in enumerate(names) if not name.startswith("index")]
    assert np.rad2deg(np.abs(moved[-1, others]).max()) < 3.0


def test_nothing_is_added_where_no_finger_is_flexed(movement):
    np.testing.assert_array_equal(movement.flexion, 0.0)


def test_a_hand_without_a_thumb_cannot_grasp(hand_file, driver, commands):
    two = RobotHand(hand_file, "palm", {f: f"{f}_pad" for f in ("index", "middle")})
    with pytest.raises(InputError, match="only index, middle; a grasp needs a thumb"):
        robot_movement(Retargeter(two), driver, commands, 0.8, ("index",))

"""What an arm is commanded, and what of it the driver hears."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.arm.arm_strength import leading_targets
from handsim.grasping.rollout import forearm, jobs
from handsim.grasping.rollout.forearm import WRIST_COLUMNS

from .short_runs import TASK, made_with


@pytest.fixture(scope="module")
def on_arm():
    """The same on an arm."""
    return made_with(seed=6, shake=3.0)


def test_an_arm_is_commanded_to_bring_the_palm_where_it_is_to_be(on_arm):
    arm = on_arm.scene.arm
    reach = on_arm.commands.reached(arm, on_arm.plan.q_goal).reach
    ctrl, run = on_arm.run.ctrl, on_arm.run
    sags = reach.arm - run.qpos[:, on_arm.scene.arm_qpos]
    sags[:10] = 0.0  # before the action
    # Brought back with a time constant of 0.25 s.
    expected = leading_targets(reach.arm, 0.01, arm.geometry) + 0.01 / 0.25 * sags.cumsum(axis=0)
    assert np.abs(sags).max() > 0.01
    np.testing.assert_allclose(ctrl[:, on_arm.scene.arm_ctrl], expected, atol=1e-12)
    of_hand = ctrl[:, on_arm.scene.hand.ctrl_index]
    np.testing.assert_allclose(of_hand[:, WRIST_COLUMNS], reach.wrist, atol=1e-12)
    np.testing.assert_array_equal(run.mocap_pos, on_arm.commands.palm_pos)
    np.testing.assert_array_equal(run.mocap_quat, on_arm.commands.palm_quat)


def corrected(made) -> np.ndarray:
    """How far targets of the arm are off those for a path that is followed, (61, 5) [rad]."""
    arm = made.scene.arm
    reach = made.commands.reached(arm, made.plan.q_goal).reach
    leading = leading_targets(reach.arm, 0.01, arm.geometry)
    return made.run.ctrl[:, made.scene.arm_ctrl] - leading


def test_an_arm_is_lifted_no_farther_than_it_may_be(monkeypatch):
    """By 0.3 rad, either way; here by less, since nothing sags so far."""
    assert forearm.MOST_FELT == 0.3
    monkeypatch.setattr(forearm, "MOST_FELT", 0.002)
    moved = corrected(made_with(seed=6, shake=3.0))
    assert moved.max() == pytest.approx(0.002)
    assert moved.min() == pytest.approx(-0.002)


def test_where_nothing_is_lifted_arm_and_grip_go_by_what_they_were_told(monkeypatch):
    felt = []

    def command(self, told, slip, load, *args, **named):
        felt.append((slip, load))
        return usual(self, told, slip, load, *args, **named)

    usual = jobs.GripLayer.command
    monkeypatch.setattr(jobs.GripLayer, "command", command)
    aside = (replace(TASK.steps[0], shift=(0.05, 0.0, 0.0)),)
    rule = replace(TASK.rule, kind="slide", lift=0.0, distance=0.05)
    resting = replace(TASK, rule=rule, steps=aside)
    assert not rule.lifted
    moved = corrected(made_with(resting, seed=6, shake=3.0))
    np.testing.assert_allclose(moved, 0.0, atol=1e-12)
    assert felt == [(None, None)] * 61


def test_an_arm_begins_where_it_is_to_be_at_rest(on_arm):
    reach = on_arm.commands.reached(on_arm.scene.arm, on_arm.plan.q_goal).reach
    np.testing.assert_array_equal(on_arm.run.qpos[0, on_arm.scene.arm_qpos], reach.arm[0])
    of_hand = on_arm.run.qpos[0, on_arm.scene.hand.qpos_index]
    np.testing.assert_array_equal(of_hand[WRIST_COLUMNS], reach.wrist[0])
    fingers = np.delete(of_hand, WRIST_COLUMNS)
    np.testing.assert_array_equal(fingers, np.delete(on_arm.plan.q_start, WRIST_COLUMNS))
    assert not on_arm.run.qvel[0].any()


def test_what_the_arm_does_with_the_wrist_is_not_told_to_the_driver(on_arm):
    """It reads its own wrist again, so that it answers nothing."""
    readings = np.array([each[1] for each in on_arm.driver.asked])
    np.testing.assert_array_equal(readings[1:, WRIST_COLUMNS], readings[:-1, WRIST_COLUMNS])
    rest = np.delete(np.arange(22), WRIST_COLUMNS)
    np.testing.assert_array_equal(readings[:, rest], on_arm.run.reading[:6, rest])


def test_a_hand_has_arrived_whatever_the_arm_does_with_its_wrist(on_arm):
    """Readings of the fingers are compared with the destination, not those of the wrist."""
    driver, reading = on_arm.driver, on_arm.run.reading[5]
    away = np.abs(reading - driver.destination)[WRIST_COLUMNS]
    assert away.max() > np.deg2rad(5.0)
    expected = reading.copy()
    expected[WRIST_COLUMNS] = driver.destination[WRIST_COLUMNS]
    np.testing.assert_array_equal(driver.at_last, expected)


def test_the_wrist_of_a_free_hand_is_part_of_what_arrives():
    made = made_with(seed=6, base="free")
    np.testing.assert_array_equal(made.driver.at_last, made.run.reading[5])

"""A robot's palm stays up as far as keeps fingers, told where to go, off the table."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.grasping.plan import Pose
from handsim.grasping.robots.robot_clearance import CLEARANCE, RISES, cleared, depth_in_table

LOWER = np.array([0.0, 0.0, -0.05])


@pytest.fixture(scope="module")
def told(grasps, scene, plan):
    return grasps.told(scene, plan)


def lowered(told, by):
    return replace(told.commands, palm_pos=told.commands.palm_pos + by)


def depths(scene, told, commands, rows):
    x = told.movement.told[rows]
    x = x + commands.closed[rows, None] * told.movement.closing
    x = np.clip(x, scene.robot.lower, scene.robot.upper)
    return np.array([
        depth_in_table(scene, Pose(commands.palm_pos[i], commands.palm_quat[i]), each)
        for i, each in zip(rows, x, strict=True)
    ])  # fmt: skip


def test_depth_is_that_of_the_lowest_part(scene, told):
    commands, x = told.commands, told.movement.told[-1]
    at = Pose(commands.palm_pos[-1], commands.palm_quat[-1])
    assert depth_in_table(scene, at.moved(np.array([0.0, 0.0, 0.5])), x) == 0.0
    low = [at.moved(np.array([0.0, 0.0, -at.pos[2] + z])) for z in (0.02, 0.01)]
    deep, deeper = (depth_in_table(scene, each, x) for each in low)
    assert deep > 0.0
    assert deeper - deep == pytest.approx(0.01, abs=1e-6)


def test_a_hand_in_the_air_goes_where_it_was_told(scene, told):
    high = lowered(told, -LOWER)
    same = cleared(scene, high, told.movement, 0.7)
    np.testing.assert_array_equal(same.palm_pos, high.palm_pos)


def test_what_would_be_in_the_table_stays_above_it(scene, told):
    low, arrival = lowered(told, LOWER), 0.7
    raised = cleared(scene, low, told.movement, arrival)
    rows = np.arange(0, low.action + 1)
    assert depths(scene, told, low, rows).max() > 0.02
    assert depths(scene, told, raised, rows[::3]).max() == 0.0
    higher = raised.palm_pos - low.palm_pos
    np.testing.assert_array_equal(higher[:, :2], 0.0)
    there = low.times >= arrival
    assert np.ptp(higher[there, 2]) < 1e-12
    down = lowered(replace(told, commands=raised), np.array([0.0, 0.0, -CLEARANCE]))
    at = depths(scene, told, down, rows[low.times[rows] >= arrival])
    assert at.max() == pytest.approx(0.0, abs=3e-4)  # a third of the readings is looked at
    steps = np.abs(np.diff(higher[:, 2]))
    assert 0.0 < steps.max() <= RISES * 0.01 + 1e-9
    assert higher[0, 2] < higher[-1, 2]


def test_a_run_presses_on_the_table_no_more(grasps, scene, plan, monkeypatch):
    low = replace(plan, palm=plan.palm.moved(LOWER / 2))
    assert grasps.run(scene, low).outcome.table_force_n == 0.0
    module = "handsim.grasping.robots.robot_planner.cleared"
    monkeypatch.setattr(module, lambda scene, commands, movement, arrival: commands)
    assert grasps.run(scene, low).outcome.table_force_n > 5.0


def test_fingers_that_reach_deeper_as_they_squeeze_count_too(scene, told):
    """The palm is where the hand is clear as it is told, but not as it has squeezed."""
    action, end = np.array([told.commands.action]), told.movement.told[-1]
    low = lowered(told, np.array([0.0, 0.0, -told.commands.palm_pos[action[0], 2]]))

    def depth(closing):
        moved = replace(told.movement, closing=closing)
        return depths(scene, replace(told, movement=moved), low, action)[0]

    ways = [sign * 0.4 * way for way in np.eye(len(end)) for sign in (1.0, -1.0)]
    open_, deepest = depth(0.0 * end), max(ways, key=depth)
    deep = depth(deepest)
    assert deep > open_ + 0.003
    high = lowered(replace(told, commands=low), np.array([0.0, 0.0, deep - 0.002]))
    raised = cleared(scene, high, replace(told.movement, closing=deepest), 0.7)
    higher = raised.palm_pos - high.palm_pos
    assert 0.002 + CLEARANCE - 1e-6 <= higher[action[0], 2] < 0.006

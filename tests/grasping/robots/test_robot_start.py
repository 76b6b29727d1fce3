"""Where a robot's palm goes first."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.grasping.conditions import Conditions
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_start import (
    CLEAR,
    clear_of_table,
    overlap_with_table,
    palm_at_grasp,
    palm_for,
)
from handsim.grasping.rollout.commands import expected_object
from handsim.tasks.table_one import task_by_name

FREE = Conditions(base="free")


def test_the_same_hand_goes_where_the_person_went(retargeter, plan):
    person = retargeter.person
    x = plan.q_goal[person.glove]
    palm = palm_for(retargeter, plan.palm, plan.q_goal, x, ("index", "middle", "ring"))
    np.testing.assert_allclose(palm.pos, plan.palm.pos, atol=1e-6)
    turned = (palm.rotation * plan.palm.rotation.inv()).magnitude()
    assert turned == pytest.approx(0.0, abs=1e-5)


def test_a_bent_hand_is_turned_so_that_its_tips_lie_where_the_pads_did(retargeter, plan):
    person, robot = retargeter.person, retargeter.robot
    x = plan.q_goal[person.glove].copy()
    x[0] += 0.2  # the arch of the palm
    palm = palm_for(retargeter, plan.palm, plan.q_goal, x, ("index", "middle"))
    mine = palm.pos + palm.rotation.apply(robot.forward(x).points[[0, 1, 2]])
    pads = person.hand.forward(plan.q_goal[person.glove]).points[[0, 1, 2]]
    theirs = plan.palm.pos + plan.palm.rotation.apply(pads)
    apart = np.linalg.norm(mine - theirs, axis=1)
    unturned = plan.palm.pos + plan.palm.rotation.apply(robot.forward(x).points[[0, 1, 2]])
    assert apart.mean() <= np.linalg.norm(unturned - theirs, axis=1).mean()
    np.testing.assert_allclose(mine.mean(axis=0), theirs.mean(axis=0), atol=2e-3)


def test_overlap_is_that_of_the_lowest_part(scene, retargeter, plan):
    x = plan.q_goal[retargeter.person.glove]
    high = plan.palm.moved(np.array([0.0, 0.0, 0.5]))
    assert overlap_with_table(scene, high, x) == 0.0
    low = plan.palm.moved(np.array([0.0, 0.0, -0.02]))
    lower = plan.palm.moved(np.array([0.0, 0.0, -0.03]))
    deeper = overlap_with_table(scene, lower, x) - overlap_with_table(scene, low, x)
    assert deeper == pytest.approx(0.01, abs=1e-6)


def test_a_plan_that_is_clear_stays(scene, retargeter, plan):
    found = clear_of_table(retargeter, scene, plan)
    np.testing.assert_array_equal(found.palm.pos, plan.palm.pos)


def test_a_hand_in_the_table_is_turned_about_what_it_holds(robot, retargeter, plan):
    task = task_by_name("cube-raise")
    scene = RobotScene.build(task, FREE, robot)
    pads = retargeter.person.hand.forward(plan.q_goal[retargeter.person.glove]).points
    line = np.array(task.grasp.opposition)

    def middle(at):
        between = 0.5 * (pads[0] + pads[[1, 2, 3]].mean(axis=0))
        return at.palm.pos + at.palm.rotation.apply(between)

    # Turned by 80 deg about the same line and point, the hand lies in the table.
    turn = Rotation.from_rotvec(np.deg2rad(80.0) * line / np.linalg.norm(line))
    away = plan.palm.pos - middle(plan)
    lying = replace(plan, palm=plan.palm.moved(turn.apply(away) - away, turn))
    x = plan.q_goal[retargeter.person.glove]
    before = overlap_with_table(scene, lying.palm, x)
    found = clear_of_table(retargeter, scene, lying)
    assert before > 10 * CLEAR
    assert overlap_with_table(scene, found.palm, x) < before
    np.testing.assert_allclose(middle(found), middle(lying), atol=1e-9)


def test_the_palm_of_a_run_is_where_it_was_in_the_frame_of_the_object(grasps, scene, plan):
    run = grasps.run(scene, plan)
    at = palm_at_grasp(run)
    told = grasps.told(scene, plan).commands
    row = round(next(p.start for p in run.phases if p.name == "squeeze") * 100)
    on = expected_object(scene.task).rotation.inv()
    np.testing.assert_allclose(at.pos, on.apply(told.palm_pos[row]), atol=3e-3)
    wanted = on * Rotation.from_quat(told.palm_quat[row], scalar_first=True)
    assert (at.rotation * wanted.inv()).magnitude() < np.deg2rad(3.0)

"""Leads of a robot: the learned controller and the script, what they know and what they vary."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.demonstrator_offsets import SPREADS, DemonstratorOffsets
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.planner import STEPS
from handsim.grasping.planning.preshapes import REST
from handsim.grasping.robots.robot_grasper import RobotGrasper
from handsim.grasping.robots.robot_lead import LearnedLead, ScriptedLead
from handsim.grasping.robots.robot_planner import RobotGrasps
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND

TASK = task_by_name("cube-raise")
OFFSETS = DemonstratorOffsets.of(np.eye(len(SPREADS))[0])
LEFT = Conditions(hand=replace(MEDIAN_HAND, side="left"))


def plan_of(size, offsets=None):
    hand = HandModel.from_spec(build_hand(size))
    return scripted_plan(TASK.for_side(size.side), hand, offsets, size.side)


def test_a_script_leads_by_its_own_plan_on_either_side() -> None:
    for conditions in (Conditions(), LEFT):
        led, (plan, _) = ScriptedLead().plan(TASK, conditions), plan_of(conditions.hand)
        np.testing.assert_array_equal(led.palm.pos, plan.palm.pos)
        np.testing.assert_array_equal(led.q_goal, plan.q_goal)
    assert led.palm.pos[1] == pytest.approx(-ScriptedLead().plan(TASK, Conditions()).palm.pos[1])


def test_offsets_change_the_plan_and_the_run(scene) -> None:
    usual, other = ScriptedLead(), ScriptedLead(OFFSETS)
    at = [lead.plan(TASK, Conditions()).palm.pos for lead in (usual, other)]
    assert np.linalg.norm(at[1] - at[0]) > 0.001
    assert usual.digest != other.digest != ScriptedLead(DemonstratorOffsets()).digest
    runs = [lead.run(TASK, Conditions()) for lead in (usual, other)]
    assert runs[0].driver == runs[1].driver == "demonstrator"
    assert not np.array_equal(runs[0].qpos, runs[1].qpos)


def test_its_driver_opens_and_closes_to_the_destination_in_the_time_given(scene) -> None:
    lead = ScriptedLead()
    plan, q_open = plan_of(scene.conditions.hand)
    goal = np.clip(plan.q_goal + 0.1, -1.5, 1.5)
    schedule = replace(schedule_for(TASK), reach=2.0)
    driver = lead.driver(scene, replace(plan, q_goal=goal), schedule)
    assert driver.reach == 2.0
    postures = [
        driver.step(time, 0.01, driver.start(1), np.zeros((1, 22)))[0] for time in (0.0, 1.24, 2.0)
    ]
    np.testing.assert_allclose(postures, [REST, q_open, goal], atol=1e-9)
    assert not lead.refuses(plan)


def test_a_search_by_script_varies_all_but_the_destination() -> None:
    lead = ScriptedLead()
    plan = lead.plan(TASK, Conditions())
    point = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0, -0.5, 1.0])
    assert len(point) == lead.n_varied
    other = lead.varied(plan, point)
    np.testing.assert_array_equal(other.q_goal, plan.q_goal)
    np.testing.assert_allclose(other.palm.pos - plan.palm.pos, [STEPS["shift"], 0.0, 0.0])
    turned = (other.palm.rotation * plan.palm.rotation.inv()).as_rotvec()
    np.testing.assert_allclose(turned, [0.0, 0.0, 2 * STEPS["turn"]], atol=1e-12)
    assert other.squeeze == pytest.approx(plan.squeeze + STEPS["squeeze"])
    assert other.arrive == pytest.approx(plan.arrive - 0.5 * STEPS["arrive"])
    assert other.grip == pytest.approx(plan.grip * np.exp(STEPS["grip"]))


def test_a_controller_leads_a_robot_within_its_subspace_from_the_first(controller, plan, scene):
    """A robot begins where its first posture is mapped to: nothing has to fade."""
    lead = LearnedLead(ControllerGrasper(controller))
    driver = lead.driver(scene, plan, schedule_for(scene.task))
    start = driver.start(1)
    rest = controller.subspace.inverse_transform(start)
    targets, _ = driver.step(0.0, 0.01, start, rest)
    np.testing.assert_allclose(targets, clip_to_range(rest), atol=np.deg2rad(0.01))


def test_a_controller_refuses_what_it_cannot_lead_to(controller, plan) -> None:
    lead = LearnedLead(ControllerGrasper(controller))
    assert not lead.refuses(plan)
    assert lead.refuses(replace(plan, z_goal=np.full(3, 50.0)))


@pytest.mark.ci
def test_a_robot_holds_the_cube_by_script(retargeter, scene) -> None:
    lead = ScriptedLead()
    run = RobotGrasps(lead, retargeter).run(scene, lead.plan(TASK, Conditions()))
    assert run.outcome.success, run.outcome
    assert run.driver == "demonstrator"
    assert run.z.shape == (len(run.time), 0)


def test_plans_by_script_are_others_than_those_of_a_controller(controller, robot) -> None:
    learned = RobotGrasper(LearnedLead(ControllerGrasper(controller)), robot)
    assert learned.lead.digest == controller.digest != ScriptedLead().digest
    by_script = RobotGrasper(ScriptedLead(), robot)
    assert isinstance(by_script.lead, ScriptedLead)
    scene = RobotScene.build(TASK, by_script.usual(), robot)
    assert by_script.grasps.told(scene, by_script.lead.plan(TASK, Conditions())).driver.name == (
        "demonstrator"
    )

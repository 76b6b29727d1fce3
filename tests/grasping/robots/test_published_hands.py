"""Published robot hands hold a thing by a person's plan, before any search."""

from dataclasses import replace
from pathlib import Path

import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.fingertip_fit import mirrored
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.robots.robot_lead import LearnedLead
from handsim.grasping.robots.robot_planner import RobotGrasps
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_start import clear_of_table
from handsim.learning.controller import GraspController
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND

HANDS = Path(__file__).parents[4] / "shared" / "data" / "robot_hands"


@pytest.mark.real_data
@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("wonik_allegro/right_hand.xml", "cube-raise"),
        ("leap_hand/leap_hand_right.urdf", "tall-glass-side-move"),
        ("shadow_hand/right_hand.xml", "cup-top-move"),
        ("shadow_hand/left_hand.xml", "cup-top-move"),
    ],
)
def test_a_published_hand_holds_by_the_plan_of_a_person(file: str, name: str) -> None:
    if not (HANDS / file).is_file():
        pytest.skip(f"{HANDS / file} is not there")
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    plan = shipped_plans(controller.digest, Conditions()).read()[name]
    robot, task = RobotHand(HANDS / file), task_by_name(name)
    lead = LearnedLead(ControllerGrasper(controller))
    grasps = RobotGrasps(lead, Retargeter(robot, opening_scale=1.0))
    size = replace(MEDIAN_HAND, side=robot.side)
    scene = RobotScene.build(task, Conditions(base="free", hand=size), robot)
    plan = plan if robot.side == "right" else mirrored(plan)
    outcome = grasps.run(scene, clear_of_table(grasps.retargeter, scene, plan)).outcome
    assert outcome.success, (outcome.reason, outcome.detail)
    assert outcome.margin < 4.0

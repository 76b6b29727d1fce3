"""A robot hand that needs no file of others: the own hand, written out and read like any other."""

from dataclasses import replace

import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.robots.robot_lead import LearnedLead
from handsim.grasping.robots.robot_planner import RobotGrasps
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.hand.export import write_hand
from handsim.joints import FINGERS
from handsim.learning.controller import GraspController
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND

TASK = task_by_name("cube-raise")
FREE = Conditions(base="free")


@pytest.fixture(scope="session")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="session")
def hand_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot") / "hand"
    return write_hand(replace(MEDIAN_HAND, side="right"), folder)


@pytest.fixture(scope="session")
def robot(hand_file) -> RobotHand:
    return RobotHand(hand_file, "palm", {finger: f"{finger}_pad" for finger in FINGERS})


@pytest.fixture(scope="session")
def three_fingers(hand_file) -> RobotHand:
    """The same hand, of which ring and little finger are not used."""
    return RobotHand(hand_file, "palm", {f: f"{f}_pad" for f in ("thumb", "index", "middle")})


@pytest.fixture(scope="session")
def retargeter(robot) -> Retargeter:
    return Retargeter(robot, opening_scale=1.0)


@pytest.fixture(scope="session")
def grasps(controller, retargeter) -> RobotGrasps:
    return RobotGrasps(LearnedLead(ControllerGrasper(controller)), retargeter)


@pytest.fixture(scope="session")
def plan(controller):
    return shipped_plans(controller.digest, Conditions()).read()[TASK.name]


@pytest.fixture(scope="session")
def scene(robot) -> RobotScene:
    return RobotScene.build(TASK, FREE, robot)

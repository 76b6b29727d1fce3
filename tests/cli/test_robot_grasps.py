"""`handsim grasp --hand FILE`: what it takes, what it says, what it refuses."""

import json
import shutil
from dataclasses import replace

import pytest
import trimesh

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.trials import own_object
from handsim.grasping.robots import robot_grasper
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout_file import read_rollout
from handsim.hand.export import write_hand
from handsim.joints import FINGERS
from handsim.robot_hands.hand_frames import AttachedFrame, HandFrames, frames_as_toml
from handsim.types import MEDIAN_HAND

CONTROLLER = data_folder("assets") / "controller.npz"


@pytest.fixture
def hand(tmp_path):
    """The own hand as a file, with a map of its frames beside it."""
    file = write_hand(MEDIAN_HAND, tmp_path / "hand")
    tips = {finger: AttachedFrame(f"{finger}_pad") for finger in FINGERS}
    file.with_suffix(".toml").write_text(frames_as_toml(HandFrames(AttachedFrame("palm"), tips)))
    return file


@pytest.fixture
def searched(monkeypatch):
    """Tasks that were searched; the start is taken as it is."""
    tasks = []

    def quickly(grasps, task, conditions, starts, *, progress):
        tasks.append(task.name)
        start = replace(starts[0], arrive=0.85)
        scene = RobotScene.build(task, conditions, grasps.retargeter.robot)
        told = grasps.told(scene, start)
        return start, grasps.run_told(scene, start, told), told.movement.mapped

    monkeypatch.setattr(robot_grasper, "plan_robot_grasp", quickly)
    return tasks


def test_a_hand_grasps_and_its_plan_lies_beside_the_controller(run, hand, searched, tmp_path):
    own = tmp_path / "controller.npz"
    shutil.copy(CONTROLLER, own)
    asked = ("grasp", own, "--hand", hand, "--task", "cube-raise", "--json", "-o", tmp_path / "out")
    first = run(*asked)
    assert first.code == 0, first.err
    said = json.loads(first.out)
    assert said["nominal_success"]
    assert said["per_trial"][0]["base"] == "free"
    assert said["robot_hand"]["file"] == str(hand)
    assert said["robot_hand"]["side"] == "right"
    assert said["robot_hand"]["fingers"] == list(FINGERS)
    assert (said["robot_hand"]["joints"], said["robot_hand"]["actuators"]) == (20, 20)
    assert "the hand flies" in first.err
    assert "plan of cube-raise is searched for this hand" in first.err
    assert read_rollout(tmp_path / "out" / "cube-raise.npz").outcome.success
    assert len(list((tmp_path / "controller.plans").iterdir())) == 1
    again = json.loads(run(*asked).out)
    assert searched == ["cube-raise"]
    assert again["per_trial"] == said["per_trial"]


def test_a_script_leads_a_hand_and_its_plan_lies_among_those_of_the_package(
    run, hand, searched, tmp_path, monkeypatch
):
    monkeypatch.setattr("handsim.cli.defaults.plan_folder", lambda file: tmp_path / "plans")
    asked = ("grasp", "demonstrator", "--hand", hand, "--task", "cube-raise", "--json")
    first = run(*asked, "-o", tmp_path / "out")
    assert first.code == 0, first.err
    said = json.loads(first.out)
    assert said["nominal_success"]
    assert said["per_trial"][0]["base"] == "free"
    assert said["per_trial"][0]["certified"] is None
    assert read_rollout(tmp_path / "out" / "cube-raise.npz").driver == "demonstrator"
    again = json.loads(run(*asked).out)
    assert searched == ["cube-raise"]
    assert again["per_trial"] == said["per_trial"]


def test_a_mounted_hand_has_a_plan_of_its_own(run, hand, searched, tmp_path):
    own = tmp_path / "controller.npz"
    shutil.copy(CONTROLLER, own)
    asked = ("grasp", own, "--hand", hand, "--task", "cube-raise", "--json")
    free = run(*asked, "--base", "free")
    mounted = run(*asked, "--base", "mounted")
    assert (free.code, mounted.code) == (0, 0), mounted.err
    said = json.loads(mounted.out)
    assert said["nominal_success"]
    assert said["per_trial"][0]["base"] == "mounted"
    assert "mounted as on an arm for 5 kg: at most 150 N and 28 N m" in mounted.err
    assert "the hand flies" in free.err
    assert "the hand flies" not in mounted.err
    assert searched == ["cube-raise"] * 2
    assert len(list((tmp_path / "controller.plans").iterdir())) == 2
    run(*asked, "--base", "mounted")
    assert len(searched) == 2


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (("--task", "cube-raise", "--base", "arm"), "--base arm is a person's"),
        (("--task", "cube-raise", "--replay"), "person's destination"),
        (("--task", "cube-raise", "--protocol", "six-axis"), "six-axis"),
    ],
)
def test_what_a_robot_hand_cannot_do_is_refused_in_a_line(run, hand, options, word):
    said = run("grasp", *options, "--hand", hand)
    assert said.code == 2
    assert said.out == ""
    assert word in said.err
    assert said.err.count("\n") == 1


def test_a_hand_that_cannot_grasp_is_refused_before_anything_is_said(run, hand):
    tips = {"index": AttachedFrame("index_pad")}
    hand.with_suffix(".toml").write_text(frames_as_toml(HandFrames(AttachedFrame("palm"), tips)))
    said = run("grasp", CONTROLLER, "--hand", hand, "--task", "cube-raise")
    assert said.code == 2
    assert said.err == "handsim: the hand has only index; a grasp needs a thumb and a finger\n"


def test_a_hand_that_is_not_there_is_named(run, tmp_path):
    said = run("grasp", "--task", "cube-raise", "--hand", tmp_path / "none.xml")
    assert said.code == 2
    assert "none.xml: no such file" in said.err


def test_a_mount_without_a_robot_is_refused_in_a_line(run):
    said = run("grasp", "--task", "cube-raise", "--base", "mounted")
    assert (said.code, said.out, said.err.count("\n")) == (2, "", 1)
    assert "name one by --hand" in said.err


def test_without_a_hand_nothing_is_said_of_one(run):
    said = run("grasp", "demonstrator", "--task", "cube-raise", "--json")
    assert "robot_hand" not in json.loads(said.out)
    assert Conditions().base == json.loads(said.out)["per_trial"][0]["base"]


@pytest.mark.slow
@pytest.mark.ci
def test_an_own_thing_is_grasped_by_the_grasp_that_a_person_found(
    run, hand, searched, tmp_path, monkeypatch
):
    monkeypatch.setattr(own_object, "MOST_TRIED", 3)
    monkeypatch.setattr(own_object, "N_COMPARED", 1)
    trimesh.creation.box((0.05, 0.05, 0.05)).export(tmp_path / "block.stl")
    own = tmp_path / "controller.npz"
    shutil.copy(CONTROLLER, own)
    asked = ("grasp", own, "--hand", hand, "--object", tmp_path / "block.stl", "--mass", "0.1")
    first = run(*asked, "--jobs", "1", "--json", "-o", tmp_path / "out")
    assert first.code == 0, first.err
    said = json.loads(first.out)
    assert said["nominal_success"]
    assert said["task"] == searched[0] == "block-lift"
    assert said["per_trial"][0]["base"] == "free"
    assert said["object"]["name"] == "block"
    assert said["robot_hand"]["fingers"] == list(FINGERS)
    assert "chosen: block" in first.err
    assert read_rollout(tmp_path / "out" / "block-lift.npz").outcome.success
    again = json.loads(run(*asked, "--json").out)  # both plans lie beside the controller
    assert len(searched) == 1
    assert again["per_trial"] == said["per_trial"]


def test_meshes_of_a_hand_are_looked_for_in_the_folders_that_are_named(run, hand, tmp_path):
    trimesh.creation.box([0.01] * 3).export(tmp_path / "elsewhere.stl")
    text = hand.read_text()
    at = text.index("<worldbody>")
    mesh = '<asset><mesh name="elsewhere" file="package://things/elsewhere.stl"/></asset>'
    hand.write_text(text[:at] + mesh + text[at:])
    (tmp_path / "far" / "things").mkdir(parents=True)
    shutil.move(tmp_path / "elsewhere.stl", tmp_path / "far" / "things")
    asked = ("grasp", "--task", "no-task", "--hand", hand)
    assert "1 mesh is left out" in run(*asked).err
    assert "left out" not in run(*asked, "--folder", tmp_path / "far").err


def test_a_folder_without_a_hand_is_refused(run, tmp_path):
    said = run("grasp", "--task", "cube-raise", "--folder", tmp_path)
    assert said.code == 2
    assert "--folder is about meshes of a robot hand; give its file by --hand" in said.err

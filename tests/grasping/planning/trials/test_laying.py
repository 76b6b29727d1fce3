"""Own objects are turned so that an arm comes to a grasp, and what it does not come to is left."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from handsim.arm.reaching_arm import ReachingArm
from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning import planner
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.search import NO_ARM, WORST, strain_of
from handsim.grasping.planning.trials import controller_trials, laying, scripted_trials
from handsim.grasping.planning.trials.laying import LaidGrasp, laid_for, lay_out
from handsim.grasping.planning.trials.scripted_trials import try_by_script
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.objects.grasp import Grasp
from handsim.objects.object import GraspObject, Piece, TriangleMesh, box
from handsim.objects.proposals import propose_grasps
from handsim.tasks.lift import lift_task
from handsim.tasks.task import Task
from handsim.types import HandSize

ARM, FREE = Conditions(), Conditions(base="free")


@pytest.fixture(scope="module")
def block() -> GraspObject:
    sides, middle = (0.05, 0.05, 0.10), (0.0, 0.0, 0.05)
    solid = trimesh.creation.box(sides).apply_translation(middle)
    surface = TriangleMesh(np.array(solid.vertices), np.array(solid.faces, dtype=np.int32))
    pieces = (Piece(surface, 0.15, (0.6, 0.4, 0.3, 1.0)),)
    return GraspObject("block", "any", pieces, (box(sides, middle),), source="made up")


@pytest.fixture(scope="module")
def by_a_handle(block: GraspObject) -> Task:
    """As if it had a handle: laid by the table's rule alone, the hand would come from beyond it."""
    grasp = Grasp(
        "handle", (0.05, 0.0, 0.058), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), 0.012,
        ("index", "middle"),
    )  # fmt: skip
    return lift_task(block, grasp)


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


def strains_at(task: Task, hand: HandModel) -> dict[float, float]:
    """Strains by turn of the object [deg], for the right hand of median size."""
    plan, _ = scripted_plan(task, hand)
    turned = {turn: replace(task, yaw_deg=task.yaw_deg + turn) for turn in range(0, 360, 45)}
    return {turn: strain_of(plan, each, ReachingArm()) for turn, each in turned.items()}


def test_an_object_is_turned_to_where_the_arm_is_strained_the_least(by_a_handle, hand):
    strains = strains_at(by_a_handle, hand)
    assert strains[0] > NO_ARM
    task, strain = laid_for(by_a_handle, ARM)
    turn = min(strains, key=strains.__getitem__)
    assert turn and task == replace(by_a_handle, yaw_deg=by_a_handle.yaw_deg + turn)
    assert strain == pytest.approx(strains[turn]) and strain < 2.0 < NO_ARM
    assert len({round(each, 3) for each in strains.values()}) == 8  # no two turns are alike


def test_of_turns_without_strain_the_first_is_taken(block, monkeypatch):
    monkeypatch.setattr(laying, "strain_of", lambda plan, task, arm: 0.25)
    task = lift_task(block)
    assert laid_for(task, ARM) == (task, 0.25)


def test_a_free_hand_finds_the_object_as_it_is(by_a_handle):
    assert laid_for(by_a_handle, FREE) == (by_a_handle, 0.0)


def test_left_arms_have_objects_laid_as_the_mirror_image(by_a_handle):
    """Tasks are those of the right hand; yaws are mirrored with the hand."""
    right, strain = laid_for(by_a_handle, ARM)
    left, of_left = laid_for(by_a_handle, Conditions(hand=HandSize(side="left")))
    assert left == right
    assert of_left == pytest.approx(strain, abs=1e-6)


def test_the_arm_is_that_of_the_hand(by_a_handle):
    """A short arm reaches less far; its strain is another."""
    _, strain = laid_for(by_a_handle, ARM)
    _, of_small = laid_for(by_a_handle, Conditions(hand=HandSize(0.165, 0.075)))
    assert of_small != pytest.approx(strain, abs=1e-3)


def test_what_no_arm_comes_to_is_passed_over_and_the_list_is_filled_with_others(block, monkeypatch):
    proposals = propose_grasps(block)
    from_above = [each for each in proposals if each.grasp.kind == "top"]
    assert 3 < len(from_above) < len(proposals)
    strain = {"top": NO_ARM, "side": NO_ARM + 0.01}

    def laid(task, conditions):
        return replace(task, yaw_deg=77.0), strain.get(task.grasp.kind, 99.0)

    monkeypatch.setattr(laying, "laid_for", laid)
    done: list[float] = []
    found = lay_out(block, ARM, 3, progress=done.append)
    assert len(found) == 3 and {each.task.grasp.kind for each in found} == {"top"}
    assert {each.task.yaw_deg for each in found} == {77.0}
    assert all(each.task.grasp == each.proposal.grasp for each in found)
    assert done == sorted(done) and done[-1] == 1.0 and len(done) == len(proposals)
    assert len(lay_out(block, ARM, 500)) == len(from_above)


def test_an_object_that_no_arm_comes_to_is_refused_in_one_line(block, monkeypatch):
    monkeypatch.setattr(laying, "laid_for", lambda task, conditions: (task, 8.125))
    with pytest.raises(InputError) as caught:
        lay_out(block, ARM)
    said = str(caught.value)
    assert "'block': no arm comes to any of its" in said and "strain 8.1 at least" in said
    assert "more than 8" in said and "--base free" in said and "\n" not in said


def test_all_that_is_tried_is_within_reach(block):
    """And the object lies for it as it is laid for that grasp by itself."""
    found = lay_out(block, ARM, 4)
    assert len(found) == 4
    as_proposed = [lift_task(block, each.proposal.grasp) for each in found]
    for each, task in zip(found, as_proposed, strict=True):
        assert (each.task.yaw_deg - task.yaw_deg) % 45.0 == pytest.approx(0.0)
        assert each.task == laid_for(task, ARM)[0]


def high(block: GraspObject) -> LaidGrasp:
    """A grasp of a block that floats out of reach."""
    proposal = propose_grasps(block)[0]
    x, y, z = proposal.grasp.point
    task = lift_task(block, replace(proposal.grasp, point=(x, y, z + 1.5)))
    return LaidGrasp(proposal, task)


def test_scripts_are_not_run_where_no_arm_comes(block, monkeypatch):
    monkeypatch.setattr(scripted_trials, "demonstrate_on", None)
    (tried,) = try_by_script([high(block)], ARM)
    assert not tried.held and tried.cost > 2 * WORST


def test_plans_of_controllers_are_not_run_where_no_arm_comes(block, hand, monkeypatch):
    monkeypatch.setattr(planner, "run_plan", None)
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    scene = Scene.build(lift_task(block), ARM)
    plan, _ = scripted_plan(scene.task, hand)
    z_goal = controller.demonstrations[0].z_goal
    q_goal = controller.subspace.inverse_transform(z_goal)
    plan = replace(plan, z_goal=z_goal, q_goal=q_goal)
    plan = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 1.5])))
    cost = controller_trials.plan_cost(controller, scene.task, plan, ARM)
    assert 2 * WORST < cost < 3 * WORST

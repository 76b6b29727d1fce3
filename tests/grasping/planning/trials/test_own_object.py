"""Grasps of own objects are proposed, tried, and planned."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import PlanStore
from handsim.grasping.planning.trials import laying, own_object
from handsim.grasping.planning.trials.laying import laid_for
from handsim.grasping.planning.trials.own_object import grasp_by_controller, grasp_by_script
from handsim.grasping.planning.trials.scripted_trials import script_cost
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.objects.object import GraspObject, Piece, TriangleMesh, box
from handsim.objects.proposals import Proposal, propose_grasps, short_list
from handsim.tasks.lift import lift_task


@pytest.fixture(scope="module")
def block() -> GraspObject:
    sides, middle = (0.05, 0.06, 0.07), (0.0, 0.0, 0.035)
    solid = trimesh.creation.box(sides).apply_translation(middle)
    surface = TriangleMesh(np.array(solid.vertices), np.array(solid.faces, dtype=np.int32))
    pieces = (Piece(surface, 0.15, (0.6, 0.4, 0.3, 1.0)),)
    return GraspObject("block", "any", pieces, (box(sides, middle),), source="made up")


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def proposals(block: GraspObject) -> tuple[Proposal, ...]:
    return propose_grasps(block)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch, proposals: tuple[Proposal, ...]) -> pytest.MonkeyPatch:
    """Few grasps, so that this takes seconds."""
    monkeypatch.setattr(laying, "propose_grasps", lambda block, side: short_list(proposals, 6))
    monkeypatch.setattr(own_object, "MOST_TRIED", 3)
    monkeypatch.setattr(own_object, "N_COMPARED", 1)
    monkeypatch.setattr(own_object, "N_FITTED", 1)
    return monkeypatch


def test_by_script_the_grasp_that_holds_best_is_chosen(
    block: GraspObject, few, proposals: tuple[Proposal, ...]
) -> None:
    done: list[float] = []
    chosen = grasp_by_script(block, Conditions(), progress=done.append)
    assert (chosen.n_tried, chosen.n_held, chosen.held) == (3, 3, True)
    costs = {
        each.grasp: script_cost(
            laid_for(lift_task(block, each.grasp), Conditions())[0], Conditions()
        )
        for each in short_list(short_list(proposals, 6), 3)
    }
    assert costs[chosen.proposal.grasp] == min(costs.values()) < 0
    assert chosen.grasper(chosen.task, Conditions()).outcome.success
    assert done == sorted(done) and done[-1] == 1.0


def test_by_script_a_search_follows_where_nothing_is_steady(block: GraspObject, few) -> None:
    few.setattr(own_object, "STEADY", -9.0)
    asked = []

    def searched(task, conditions, seed):
        asked.append((task.grasp.kind, len(task.grasp.fingers)))
        return 5.0, own_object.DemonstratorOffsets()

    few.setattr(own_object, "search_offsets", searched)
    chosen = grasp_by_script(block, Conditions())
    assert len(asked) == 2 and len(set(asked)) == 2  # grasps of different kinds
    assert chosen.held  # that which was held before costs less than what the search found


def test_a_controller_plans_the_grasp_and_keeps_it(
    block: GraspObject, controller: GraspController, few, tmp_path: Path
) -> None:
    store = PlanStore(tmp_path / "plans.json")
    chosen = grasp_by_controller(ControllerGrasper(controller, store=store), block, Conditions())
    assert (chosen.n_tried, chosen.held) == (3, True)
    assert chosen.grasper(chosen.task, Conditions()).outcome.success
    (stored,) = json.loads(store.path.read_text())["plans"].values()
    assert stored["held"] is True and len(stored["z_goal_rad"]) == 3
    few.setattr(own_object, "try_by_script", None)  # nothing is tried again
    again = grasp_by_controller(ControllerGrasper(controller, store=store), block, Conditions())
    assert (again.n_tried, again.task.grasp) == (0, chosen.task.grasp)


@pytest.mark.slow
def test_a_controller_plans_in_full_where_no_fit_is_steady(
    block: GraspObject, controller: GraspController, few
) -> None:
    few.setattr(own_object, "STEADY", -9.0)
    asked = []

    def planned(controller, task, conditions, known, *, generations):
        asked.append(known)
        return known, own_object.run_plan(
            controller, own_object.Scene.build(task, conditions), known
        )

    few.setattr(own_object, "plan_grasp", planned)
    chosen = grasp_by_controller(ControllerGrasper(controller), block, Conditions())
    assert len(asked) == 1 and asked[0].z_goal is not None
    assert asked[0].transport == shipped_transport()
    assert chosen.held == chosen.grasper(chosen.task, Conditions()).outcome.success


def test_a_recorded_destination_cannot_be_replayed(
    block: GraspObject, controller: GraspController
) -> None:
    with pytest.raises(InputError, match="no recorded destination"):
        grasp_by_controller(ControllerGrasper(controller, "replay"), block, Conditions())

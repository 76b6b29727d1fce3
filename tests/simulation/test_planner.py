"""What the planner does with what its search finds; the search itself costs minutes."""

from types import SimpleNamespace

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.hand.tasks import task_by_name
from handsim.learning.controller import GraspController
from handsim.simulation import planner
from handsim.simulation.conditions import Conditions

TASK = task_by_name("cube-raise")


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


def test_starts_are_of_both_kinds_and_lie_apart(controller):
    search = planner._Search(controller, TASK, Conditions())
    plans = search.starts()
    coordinates = {plan.q_goal.tobytes(): plan.q_goal for plan in plans}.values()
    assert len(plans) == len(planner.ARRIVALS) * len(coordinates)
    assert len(coordinates) > planner.N_PLACEMENTS
    assert {plan.arrive for plan in plans} == set(planner.ARRIVALS)
    for plan in plans:
        z = controller.subspace.transform(plan.q_goal)
        assert (z >= search.box[0] - 0.2).all() and (z <= search.box[1] + 0.2).all()


@pytest.mark.parametrize("holds_longer", [True, False])
def test_what_slips_in_the_whole_hold_is_searched_with_it(controller, monkeypatch, holds_longer):
    searched, judged = [], iter([holds_longer, True])

    class Search:
        def __init__(self, controller, task, conditions):
            self.hold = task.rule.hold

        def starts(self):
            return ["first", "second"]

        def cost(self, plan):
            return {"first": -0.1, "second": -0.3}[plan]

        def from_start(self, start, generations, seed):
            searched.append((self.hold, start))
            return -0.5, f"better than {start}"

    def run_plan(controller, stage, plan):
        return SimpleNamespace(plan=plan, outcome=SimpleNamespace(success=next(judged)))

    monkeypatch.setattr(planner, "_Search", Search)
    monkeypatch.setattr(planner, "run_plan", run_plan)
    plan, run = planner.plan_grasp(controller, TASK, Conditions())
    assert run.outcome.success
    assert run.plan == plan
    short, whole = min(TASK.rule.hold, 1.0), TASK.rule.hold
    assert searched[0] == (short, "second")
    assert searched[1:] == ([] if holds_longer else [(whole, "better than second")])


def test_a_destination_outside_costs_more_than_any_failure(controller):
    search = planner._Search(controller, TASK, Conditions())
    plan = planner.replace(search.scripted, q_goal=np.full(22, 3.0))
    assert search.cost(plan) == pytest.approx(planner.NO_WAY + planner.WORST)

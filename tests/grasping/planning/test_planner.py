"""What the planner does with what its search finds; the search itself costs minutes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning import planner
from handsim.grasping.planning.plan_store import StoredPlan
from handsim.grasping.planning.search import POPULATION, Estimate
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

TASK = task_by_name("cube-raise")


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def search(controller):
    return planner._Search(controller, TASK, Conditions(), Estimate(None))


@pytest.fixture(scope="module")
def starts(search):
    return search.starts()  # which takes seconds


def test_starts_are_of_both_kinds_and_lie_apart(controller, search, starts):
    plans = starts
    coordinates = {plan.q_goal.tobytes(): plan.q_goal for plan in plans}.values()
    assert len(plans) == len(planner.ARRIVALS) * len(coordinates)
    assert len(coordinates) > planner.N_FITS
    assert {plan.arrive for plan in plans} == set(planner.ARRIVALS)
    for plan in plans:
        z = controller.subspace.transform(plan.q_goal)
        assert (z >= search.box[0] - 0.2).all() and (z <= search.box[1] + 0.2).all()


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_palm_comes_in_as_it_will_by_every_start(controller, search, starts, side):
    """Whatever comes of a start by variation keeps its transport."""
    usual = Conditions(hand=HandSize(side=side))
    here = search if side == "right" else planner._Search(controller, TASK, usual, Estimate(None))
    straight = [replace(plan, transport=None) for plan in starts[:2]]
    known = [
        *here.known(straight[0], ()),
        *here.known(None, [StoredPlan(plan, True) for plan in straight]),
        *(starts if side == "right" else ()),
        planner.varied(controller, next(here.known(straight[0], ())), np.ones(12), here.box),
    ]
    assert len(known) >= 4
    assert {plan.transport for plan in known} == {shipped_transport(side)}


@pytest.mark.parametrize("holds_longer", [True, False])
def test_what_slips_in_the_whole_hold_is_searched_with_it(controller, monkeypatch, holds_longer):
    searched, verdicts = [], iter([holds_longer, True])

    class Search:
        def __init__(self, controller, task, conditions, estimate, n_perturbed):
            self.hold = task.rule.hold

        def known(self, known, others):
            return iter(())

        def starts(self):
            return ["first", "second"]

        def cost(self, plan):
            return {"first": -0.1, "second": -0.3}[plan]

        def confirmed(self, plan, cost):
            return {"first": 0.4, "second": 0.6}.get(plan, 0.95), plan

        def from_start(self, start, generations, seed):
            searched.append((self.hold, start))
            return -0.5, f"better than {start}"

    def run_plan(controller, scene, plan):
        return SimpleNamespace(plan=plan, outcome=SimpleNamespace(success=next(verdicts)))

    monkeypatch.setattr(planner, "_Search", Search)
    monkeypatch.setattr(planner, "run_plan", run_plan)
    plan, run = planner.plan_grasp(controller, TASK, Conditions())
    assert run.outcome.success
    assert run.plan == plan
    short, whole = min(TASK.rule.hold, 1.0), TASK.rule.hold
    assert searched[0] == (short, "second")
    assert searched[1:] == ([] if holds_longer else [(whole, "better than second")])


def test_a_destination_outside_costs_more_than_any_failure(search):
    plan = replace(search.scripted, q_goal=np.full(22, 3.0))
    assert search.cost(plan) == pytest.approx(planner.NO_WAY + planner.WORST)


def test_a_destination_beyond_a_joint_range_stays_the_destination(
    controller, search, starts, monkeypatch
):
    """Its posture is cut off at the range, and would project to a point elsewhere."""
    monkeypatch.setattr(planner, "clip_to_range", lambda q: np.minimum(q, 0.5))
    plan, steps = starts[0], planner.STEPS["z"]
    z = plan.z_goal
    for point in np.random.default_rng(0).normal(size=(5, search.n_varied)):
        z = np.clip(z + steps * point[: len(z)], *search.box)
        plan = planner.varied(search.controller, plan, point, search.box)
        assert plan.z_goal.tobytes() == z.tobytes()
        lifted = controller.subspace.inverse_transform(z)
        np.testing.assert_array_equal(plan.q_goal, np.minimum(lifted, 0.5))
        assert np.abs(controller.subspace.transform(plan.q_goal) - z).max() > np.deg2rad(0.5)


def test_the_search_tries_and_runs_what_the_plan_says(controller, starts, monkeypatch):
    """A hint leads to the projection of its posture; what is found was tried, to the bit."""
    hint = replace(starts[0], z_goal=None)
    tried, run = [], []
    monkeypatch.setattr(planner._Search, "starts", lambda self: [])
    monkeypatch.setattr(planner._Search, "cost", lambda self, plan: tried.append(plan) or -0.1)
    monkeypatch.setattr(planner._Search, "confirmed", lambda self, plan, cost: (0.5, plan))

    def run_plan(controller, scene, plan):
        run.append(plan)
        return SimpleNamespace(outcome=SimpleNamespace(success=True))

    monkeypatch.setattr(planner, "run_plan", run_plan)
    plan, _ = planner.plan_grasp(controller, TASK, Conditions(), hint, generations=1, seed=3)
    wanted = controller.subspace.transform(hint.q_goal)
    np.testing.assert_array_equal(tried[0].z_goal, wanted)
    assert plan is run[0]
    assert plan.z_goal is not None
    assert any(plan.z_goal.tobytes() == each.z_goal.tobytes() for each in tried)


def test_seeds_of_one_planning_do_not_reach_those_of_the_next(controller, monkeypatch):
    seeds, held = [], iter([False, False])

    class Search:
        def __init__(self, controller, task, conditions, estimate, n_perturbed):
            pass

        def known(self, known, others):
            return iter(())

        def starts(self):
            return [1.0, 2.0, 3.0]

        def cost(self, plan):
            return plan

        def confirmed(self, plan, cost):
            return 0.0, plan

        def from_start(self, start, generations, seed):
            seeds.append(seed)
            return planner.NOMINAL_FAILS + (start - 2.9), start

    def run_plan(controller, scene, plan):
        return SimpleNamespace(outcome=SimpleNamespace(success=next(held)))

    monkeypatch.setattr(planner, "_Search", Search)
    monkeypatch.setattr(planner, "run_plan", run_plan)
    planner.plan_grasp(controller, TASK, Conditions(), seed=planner.SEEDS)
    assert seeds
    assert planner.SEEDS <= min(seeds) <= max(seeds) < 2 * planner.SEEDS


def test_of_what_is_found_that_is_kept_which_holds_in_runs_that_no_search_has_seen(
    controller, monkeypatch
):
    """The cheapest plan is not the best; a known plan that always holds ends the search."""
    share = {"known": 0.3, "start": 0.2, "found 0": 0.4, "found 1": 0.8, "found 2": 0.5}
    searches = []

    class Search:
        def __init__(self, controller, task, conditions, estimate, n_perturbed):
            pass

        def known(self, known, others):
            return iter([known])

        def starts(self):
            return ["start"]

        def cost(self, plan):
            return {"known": -0.1, "start": -0.9}[plan]

        def confirmed(self, plan, cost):
            return share[plan], plan

        def from_start(self, start, generations, seed):
            searches.append(start)
            return -1.0, f"found {len(searches) - 1}"

    def run_plan(controller, scene, plan):
        return SimpleNamespace(outcome=SimpleNamespace(success=True))

    monkeypatch.setattr(planner, "_Search", Search)
    monkeypatch.setattr(planner, "run_plan", run_plan)
    assert planner.plan_grasp(controller, TASK, Conditions(), "known")[0] == "found 1"
    assert searches == ["start", "known"]
    share["known"] = planner.ENOUGH
    assert planner.plan_grasp(controller, TASK, Conditions(), "known")[0] == "known"
    assert searches == ["start", "known"]


def test_a_plan_is_confirmed_by_its_share_of_runs_that_hold(search, monkeypatch):
    costs = iter([-0.5, -0.5, 2.0, -0.5, -0.5, 2.0])
    monkeypatch.setattr(search, "_cost_on", lambda scene, plan: next(costs))
    share, plan = search.confirmed("plan", -0.5)
    assert plan == "plan" and len(search.unseen) == planner.N_CONFIRMED == 6
    assert share == pytest.approx((1 + 4 - 0.01 * (4 * -0.5 + 2 * 2.0) / 6) / 7)
    assert search.confirmed("plan", planner.NOMINAL_FAILS) == (0.0, "plan")


def test_how_far_planning_is_counts_what_is_ahead_and_half_of_what_may_be(controller, monkeypatch):
    """Twelve starts, then three searches of which the second finds enough."""
    told = []

    class Search:
        def __init__(self, controller, task, conditions, estimate, n_perturbed):
            self.estimate, self.found = estimate, 0

        def known(self, known, others):
            return iter(())

        def starts(self):
            return list(range(4))

        def cost(self, plan):
            self.estimate.step()
            return 1.0

        def confirmed(self, plan, cost):
            return (planner.ENOUGH if plan == "found 2" else 0.0), plan

        def from_start(self, start, effort, seed):
            for _ in range(3):
                self.estimate.step()
            self.found += 1
            return -0.5, f"found {self.found}"

    run = SimpleNamespace(outcome=SimpleNamespace(success=True))
    monkeypatch.setattr(planner, "_Search", Search)
    monkeypatch.setattr(planner, "run_plan", lambda *_: run)
    plan, _ = planner.plan_grasp(
        controller, TASK, Conditions(), generations=2, progress=told.append
    )
    assert plan == "found 2"
    each = 1 + POPULATION * 2
    starts = [n / (planner.N_STARTS + each // 2) for n in (1, 2, 3, 4)]
    first = [n / (4 + 2 * each) for n in (5, 6, 7)]
    second = [n / (7 + each + each // 2) for n in (8, 9, 10)]
    assert told == pytest.approx([*starts, *first, *second])


def test_as_many_perturbed_runs_are_looked_at_as_are_asked_for(controller, starts, monkeypatch):
    made, search = [], planner._Search

    def held(self, plan, cost):
        made.append(self)
        return 1.0, plan

    monkeypatch.setattr(search, "cost", lambda self, plan: -0.1)
    monkeypatch.setattr(search, "confirmed", held)
    planner.plan_grasp(controller, TASK, Conditions(), starts[0], n_perturbed=4)
    assert (len(made[0].scenes), len(made[0].unseen)) == (5, planner.N_CONFIRMED)

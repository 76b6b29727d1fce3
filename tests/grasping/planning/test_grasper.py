"""What grasps, and what it remembers."""

import pickle
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.errors import FileError, UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, made_hard, perturb, trial_conditions
from handsim.grasping.planning import grasper as grasping
from handsim.grasping.planning.grasper import (
    ATTEMPTS,
    ControllerGrasper,
    Wanted,
    search_plan,
    search_plans,
)
from handsim.grasping.planning.plan_key import PlanKey, key_for, planned_for
from handsim.grasping.planning.plan_store import PlanStore, StoredPlan, plan_store
from handsim.grasping.planning.planner import SEEDS
from handsim.grasping.pool import one_by_one
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND, HandSize


def test_trials_have_the_seeds_that_follow():
    usual = Conditions(seed=7, hand=HandSize(0.18))
    nominal, *trials = trial_conditions(usual, 2)
    assert nominal == usual
    assert [each.seed for each in trials] == [8, 9]
    assert not any(each.nominal for each in trials)
    assert {each.hand.length for each in trials} == {0.18}


def test_hard_trials_are_hard_in_one_thing_alone():
    usual = Conditions(seed=7, hand=HandSize(0.18))
    nominal, *trials = trial_conditions(usual, 3, "bias")
    assert nominal == usual
    assert trials == [made_hard(usual, seed, "bias") for seed in (8, 9, 10)]


TASK, JAR = task_by_name("cube-raise"), task_by_name("jar-move")
STRICTER = replace(TASK, rule=replace(TASK.rule, slip=0.019))  # the same name, another task
OTHER = PlanKey("another", *["the same"] * 4)


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def built_in(controller):
    return plan_store(data_folder("assets") / "plans", controller.digest, Conditions())


@pytest.fixture(scope="module")
def plan(built_in):
    return built_in.read()[TASK.name]


@pytest.fixture
def searches(monkeypatch, plan):
    """Searches that take no time; ``held`` says what comes of them, in turn."""

    class Searches(list):
        held = iter([True] * 9)

    asked = Searches()

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        assert conditions == planned_for(conditions)
        asked.append(
            SimpleNamespace(task=task, conditions=conditions, known=known, others=others, seed=seed)
        )
        found = replace(plan, squeeze=plan.squeeze + 0.01 * len(asked))
        return found, SimpleNamespace(outcome=SimpleNamespace(success=next(asked.held)))

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    return asked


@pytest.fixture
def grasper(controller, tmp_path):
    def make(name="p.json", **changes):
        told = []
        made = ControllerGrasper(controller, store=PlanStore(tmp_path / name), note=told.append)
        return replace(made, made={}, **changes), told

    return make


def bits(plan):
    numbers = (plan.palm.pos, plan.palm.quat, plan.retreat, plan.q_start, plan.q_goal, plan.z_goal)
    return np.concatenate([*numbers, [plan.squeeze, plan.arrive]]).tobytes()


def test_a_plan_found_run_and_read_again_is_one_to_the_bit(grasper, plan, monkeypatch):
    found = replace(plan, z_goal=plan.z_goal * (1 + np.linspace(0, 1e-9, len(plan.z_goal))))
    found = replace(found, q_goal=found.q_goal * (1 + np.linspace(0, 1e-6, 22)))
    found = replace(found, transport=shipped_transport())
    assert np.any(np.deg2rad(np.rad2deg(found.q_goal)) != found.q_goal)
    run = []

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        return found, SimpleNamespace(outcome=SimpleNamespace(success=True))

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    monkeypatch.setattr(grasping, "run_plan", lambda controller, scene, plan: run.append(plan))
    first, _ = grasper()
    first(TASK, Conditions())
    again, _ = grasper()
    again(TASK, Conditions())
    assert {bits(each) for each in run} == {bits(again.read()[TASK.name])} == {bits(found)}
    assert {each.transport for each in run} == {shipped_transport()}
    assert [each.read()[TASK.name].transport for each in (first, again)] == [None, None]


def test_what_fits_is_not_planned_again(grasper, searches):
    first, told = grasper()
    plan = first.plan_for(TASK, Scene.build(TASK, Conditions()))
    again, _ = grasper()
    for conditions in (Conditions(), Conditions(seed=3, friction=0.5), perturb(Conditions(), 4)):
        scene = Scene.build(TASK, conditions)
        assert bits(again.plan_for(TASK, scene)) == bits(plan)
    assert again.known([TASK, JAR], Conditions()).keys() == {TASK.name}
    again.prepare([TASK], Conditions(), 1)
    assert len(searches) == 1
    assert searches[0].known is None
    assert told == []


def test_a_plan_of_another_task_is_where_the_search_begins(grasper, searches):
    first, _ = grasper()
    old = first.plan_for(TASK, Scene.build(TASK, Conditions()))
    for method in ("plan_for", "prepare"):
        later, told = grasper()
        if method == "plan_for":
            later.plan_for(STRICTER, Scene.build(STRICTER, Conditions()))
        else:
            later.prepare([TASK], Conditions(), 1)
        assert told == ["plan of cube-raise is of another task: planned again"]
    assert len(searches) == 3
    assert bits(searches[1].known) == bits(old)
    assert searches[1].task == STRICTER
    assert grasper()[0].known([TASK], Conditions())


def test_all_that_is_another_is_named_and_what_is_shown_is_left_out(grasper, plan, searches):
    made, told = grasper()
    key = replace(key_for(TASK, Conditions()), object="another", physics="another")
    made.store.add(TASK.name, StoredPlan(plan, True, key))
    assert made.known([TASK], Conditions()) == {}
    assert told == ["plan of cube-raise is of another object and another physics: left out"]
    assert searches == []
    made.store.add(TASK.name, StoredPlan(plan, True))
    made.plan_for(TASK, Scene.build(TASK, Conditions()))
    assert told[1:] == ["plan of cube-raise does not say what it was made for: planned again"]
    assert bits(searches[0].known) == bits(plan)


def test_a_hand_that_is_another_has_a_plan_of_its_own(grasper, searches):
    made, told = grasper(store=None)
    small = Conditions(hand=HandSize(0.175))
    first = made.plan_for(TASK, Scene.build(TASK, Conditions()))
    made.plan_for(TASK, Scene.build(TASK, small))
    assert [each.conditions for each in searches] == [Conditions(), small]
    assert "is of another hand" in told[0]
    assert [each.known for each in searches] == [None, None]
    (other,) = searches[1].others
    assert (other.hand, bits(other.plan)) == (MEDIAN_HAND, bits(first))


def test_searches_for_another_hand_begin_with_plans_for_the_task_and_for_its_object(
    grasper, searches, built_in, tmp_path
):
    """Coordinates are kept where the controller is the same."""
    foreign = replace(built_in, controller="another")
    left = Conditions(hand=HandSize(side="left"))
    made, told = grasper(hints=(built_in, foreign, built_in))
    made.plan_for(JAR, Scene.build(JAR, left))
    (search,) = searches
    assert (search.known, told) == (None, [])
    known = built_in.read()
    wanted = [known[name] for name in ("jar-move", "jar-move", "jar-unscrew", "jar-unscrew")]
    assert [each.plan.q_goal.tobytes() for each in search.others] == [
        plan.q_goal.tobytes() for plan in wanted
    ]
    assert [each.plan.z_goal is None for each in search.others] == [False, True, False, True]
    assert {each.hand for each in search.others} == {MEDIAN_HAND}
    assert made.made[JAR.name].hand == left.hand
    # A plan of this hand comes first, if only of another controller.
    searches.clear()
    own = plan_store(tmp_path, "another", left)
    own.add(JAR.name, StoredPlan(known[JAR.name], True))
    made, _ = grasper("q.json", hints=(built_in, own))
    made.plan_for(JAR, Scene.build(JAR, left))
    (search,) = searches
    (other,) = search.others
    assert (search.known, other.plan.z_goal, other.hand) == (None, None, left.hand)


def test_what_is_found_is_where_the_next_search_begins_beside_plans_of_other_hands(
    grasper, searches, built_in
):
    searches.held = iter([False, True])
    made, _ = grasper(hints=(built_in,))
    left = Conditions(hand=HandSize(side="left"))
    made.plan_for(JAR, Scene.build(JAR, left))
    first, second = searches
    assert [each.known for each in searches] == [None, None]
    assert [each.seed for each in searches] == [0, SEEDS]
    found, *others = second.others
    assert others == list(first.others)
    assert found.hand == left.hand
    assert found.plan.squeeze == pytest.approx(built_in.read()[TASK.name].squeeze + 0.01)


def test_what_does_not_hold_is_searched_again_with_other_seeds_and_then_left(grasper, searches):
    searches.held = iter([False, False, False, True])
    made, _ = grasper()
    scene = Scene.build(TASK, Conditions())
    made.plan_for(TASK, scene)
    assert [each.seed for each in searches] == [0, SEEDS]
    assert searches[0].known is None
    assert searches[1].known is not None
    later, told = grasper()
    later.plan_for(TASK, scene)
    assert len(searches) == ATTEMPTS == 2
    assert not told
    assert not later.store.entries()[TASK.name].held


def test_what_was_searched_too_little_is_searched_on(grasper, searches, plan):
    made, told = grasper()
    key = key_for(TASK, Conditions())
    made.store.add(TASK.name, StoredPlan(plan, False, key, attempts=ATTEMPTS - 1))
    scene = Scene.build(TASK, Conditions())
    found = made.plan_for(TASK, scene)
    assert [each.seed for each in searches] == [(ATTEMPTS - 1) * SEEDS]
    assert bits(searches[0].known) == bits(plan) != bits(found)
    assert told == ["plan of cube-raise did not hold after 1 of 2 searches: planned again"]
    stored = grasper()[0].store.entries()[TASK.name]
    assert (stored.held, stored.attempts, bits(stored.plan)) == (True, ATTEMPTS, bits(found))
    # What has held of another key counts for nothing, and its attempts neither.
    made.store.add(TASK.name, StoredPlan(plan, False, OTHER, attempts=ATTEMPTS))
    searches.clear()
    grasper()[0].plan_for(TASK, scene)
    assert [each.seed for each in searches] == [0]


def test_plans_of_the_same_controller_elsewhere_are_taken_as_they_are(
    grasper, searches, built_in, plan
):
    made, told = grasper(shared=(built_in,))
    scene = Scene.build(TASK, Conditions())
    assert bits(made.plan_for(TASK, scene)) == bits(plan)
    made.prepare([TASK, JAR], Conditions(), 2)
    assert made.known([TASK, JAR], Conditions()).keys() == {TASK.name, JAR.name}
    assert made.read().keys() == built_in.read().keys()
    assert searches == []
    assert not made.store.path.exists()
    # One's own comes first, but not where it does not fit or hold.
    own, key = replace(plan, squeeze=0.123), key_for(TASK, Conditions())
    for stored, squeeze in (
        (StoredPlan(own, True, key), 0.123),
        (StoredPlan(own, False, key, ATTEMPTS), plan.squeeze),
        (StoredPlan(own, True, OTHER), plan.squeeze),
    ):
        made.store.add(TASK.name, stored)
        assert made.plan_for(TASK, scene).squeeze == squeeze
    assert (searches, told) == ([], [])


def test_plans_of_other_controllers_are_hints_without_their_coordinates(
    grasper, searches, built_in, plan
):
    made, _ = grasper(hints=(replace(built_in, controller="another"),))
    made.plan_for(TASK, Scene.build(TASK, Conditions()))
    (search,) = searches
    (other,) = search.others
    assert search.known is None  # the search is near it, and short
    assert other.plan.z_goal is None
    assert other.plan.q_goal.tobytes() == plan.q_goal.tobytes()


def test_a_plan_that_cannot_be_kept_is_used_all_the_same(grasper, searches, tmp_path):
    (tmp_path / "c.plans").write_text("a file, and no folder")
    made, told = grasper("c.plans/p.json")
    scene = Scene.build(TASK, Conditions())
    first = made.plan_for(TASK, scene)
    assert bits(made.plan_for(TASK, scene)) == bits(first)
    made.prepare([TASK], Conditions(), 1)
    assert bits(pickle.loads(pickle.dumps(replace(made, note=None))).plan_for(TASK, scene)) == bits(
        first
    )
    assert made.read().keys() == made.known([TASK], Conditions()).keys() == {TASK.name}
    assert len(searches) == 1
    (line,) = told
    assert line.startswith("plan of cube-raise is used, but could not be kept: ")
    assert str(tmp_path / "c.plans") in line
    assert "\n" not in line


def test_a_file_that_cannot_be_read_is_no_reason_to_plan(grasper, searches, tmp_path):
    (tmp_path / "p.json").write_text('{"schema": 3}')
    made, _ = grasper()
    for attempt in (
        lambda: made.plan_for(TASK, Scene.build(TASK, Conditions())),
        lambda: made.prepare([TASK], Conditions(), 1),
        lambda: made.known([TASK], Conditions()),
    ):
        with pytest.raises(FileError, match="newer than 2"):
            attempt()
    assert searches == []
    assert (tmp_path / "p.json").read_text() == '{"schema": 3}'


def test_errors_come_through_from_other_processes():
    error = UnknownNameError("task", "cube-rase", ("cube-raise",))
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)
    assert copy.known == error.known


def test_a_search_that_is_made_again_is_half_done(controller, plan, monkeypatch):
    """And the fraction is that of all plans where several are searched in this process."""
    held = iter([False, True, True])

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        for fraction in (0.5, 1.0):
            progress(fraction)
        return plan, SimpleNamespace(outcome=SimpleNamespace(success=next(held)))

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    told: list[float] = []
    search_plan(controller, Wanted(TASK, Conditions()), told.append)
    assert told == [0.5, 1.0, 0.75, 1.0]
    missing = [(ControllerGrasper(controller), Wanted(each, Conditions())) for each in (TASK, JAR)]
    held, told = iter([True, True]), []
    assert [i for i, _ in search_plans(missing, one_by_one, told.append)] == [0, 1]
    assert told == [0.25, 0.5, 0.5, 0.75, 1.0, 1.0]


def test_who_waits_for_a_plan_is_told_whose_it_is_and_how_far(controller, plan, monkeypatch):
    labels, told = [], []

    @contextmanager
    def planning(label):
        labels.append(label)
        yield told.append
        labels.append("done")

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        progress(0.5)
        return plan, SimpleNamespace(outcome=SimpleNamespace(success=True))

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    grasper = ControllerGrasper(controller, planning=planning)
    grasper.plan_for(TASK, Scene.build(TASK, Conditions()))
    assert (labels, told) == ([f"planning {TASK.name}", "done"], [0.5])
    grasper.plan_for(TASK, Scene.build(TASK, Conditions()))  # is known now
    assert len(labels) == 2
    grasper.prepare([JAR], Conditions(), 2)  # one alone is searched in this process
    assert labels[2:] == ["planning", "done"]
    assert told[1:] == [0.5, 1.0]

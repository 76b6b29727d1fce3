from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.arm.reaching_arm import ReachingArm
from handsim.grasping.conditions import Conditions, Perturbation, perturb
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.search import (
    BROKEN,
    NO_ARM,
    POPULATION,
    WIDE,
    WORST,
    Effort,
    Estimate,
    cost_of,
    minimise,
    out_of_reach,
    robust_cost,
    shortened,
    strain_of,
    tried_conditions,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Phase
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import Task
from handsim.types import HandSize


def counted(values):
    made = []
    return made, [lambda v=v: made.append(v) or v for v in values]


@pytest.mark.parametrize(
    ("values", "worst"),
    [
        ([-0.5], -0.5),
        ([-0.5, -0.3, 2.0], 2.0),
        ([-0.5, -0.7, -0.1, -0.6], -0.1),  # a quarter of four
        ([-0.8, -0.5, -0.7, -0.3, -0.6, -0.9, -0.7], -0.3),  # of seven there is one
        ([-0.9, -0.8, -0.2, -0.7, 1.5, -0.6, -0.5, -0.3], (1.5 - 0.2) / 2),  # of eight, two
        ([-0.1, *[-0.5] * 8, -0.2, -0.3], (-0.1 - 0.2) / 2),  # of eleven too, the first among them
    ],
)
def test_all_tries_count_by_half_and_the_worst_quarter_by_half(values, worst):
    made, tries = counted(values)
    expected = 0.5 * sum(values) / len(values) + 0.5 * worst
    assert robust_cost(tries) == pytest.approx(expected, abs=1e-12)
    assert made == values


def test_nothing_more_is_tried_where_the_nominal_try_fails():
    made, tries = counted([1.5, -0.3, -0.3])
    assert robust_cost(tries) == pytest.approx(1.5 + WORST)
    assert made == [1.5]


def test_after_three_failures_the_rest_is_taken_to_fail():
    made, tries = counted([-0.5, 2.0, 3.0, 4.0, -0.5, -0.5])
    assert robust_cost(tries) == pytest.approx(0.5 * (-0.5 + 2 + 3 + 4 + 3 + 3) / 6 + 0.5 * 4)
    assert len(made) == 4


def test_the_search_finds_the_bottom_of_a_bowl_and_repeats():
    bowl = lambda x: float(((x - [1.0, -2.0]) ** 2).sum())  # noqa: E731
    cost, point = minimise(bowl, np.zeros(2), generations=40, enough=1e-4)
    assert cost < 1e-2
    np.testing.assert_allclose(point, [1.0, -2.0], atol=0.1)
    again = minimise(bowl, np.zeros(2), generations=40, enough=1e-4)
    np.testing.assert_array_equal(again[1], point)


def test_the_search_never_ends_worse_than_it_began():
    cost, point = minimise(lambda x: float(x @ x), np.zeros(2), generations=3, enough=-1.0)
    assert cost == 0.0
    assert not point.any()


def test_a_search_shortens_the_hold_and_nothing_else():
    task = task_by_name("cube-raise")
    quick = shortened(task)
    assert quick.rule.hold == 1.0
    assert quick.rule.slip == task.rule.slip
    assert shortened(task_by_name("mouse-slide")).rule.hold == 1.0
    assert shortened(replace(task, rule=replace(task.rule, hold=0.5))).rule.hold == 0.5


MOVE, SLIDE, CLICK = (
    task_by_name(name) for name in ("jar-move", "mouse-slide", "mouse-left-click")
)
LIMITS = (MOVE.rule.lift, MOVE.rule.hold, MOVE.rule.slip, MOVE.rule.tilt_deg)
HELD = Outcome(True, None, 0.12, 0.005, 3.0, 3.1, 4, 0.0, opposed=1.0, done=1.0)
LOST = Outcome(False, "slipped", 0.0, 0.0, 0.0, 0.0, 0, 0.0, opposed=1.0, done=0.0)


def cost(task: Task = MOVE, start: Outcome = LOST, touch=(), **values) -> float:
    """Cost of a run of 3 s that squeezes from 1 s on; from 2 s on parts ``touch`` with a force."""
    time = np.arange(0.0, 3.005, 0.01)
    force = np.zeros((len(time), 6))
    force[time > 2.0, : len(touch)] = touch
    phases = (Phase("reach", 0.0), Phase("squeeze", 1.0), Phase("action", 1.5), Phase("hold", 2.5))
    run = SimpleNamespace(
        outcome=replace(start, **values), time=time, contact_force=force, phases=phases
    )
    return cost_of(run, task)


def test_the_limits_that_costs_are_measured_by():
    assert LIMITS == (0.1, 3.0, 0.02, 30.0)


def test_a_success_is_worth_what_is_left_of_the_narrower_limit():
    assert cost(start=HELD) == pytest.approx(0.005 / 0.02 - 1)
    assert cost(start=HELD, peak_slip_m=0.001, peak_tilt_deg=15.0) == pytest.approx(-0.5)
    assert cost(start=HELD, peak_slip_m=0.0, peak_tilt_deg=0.0) == -1.0
    assert -1 <= cost(start=HELD) < 0


def test_a_failure_of_everything_costs_the_most():
    assert cost() == pytest.approx(1 + 1 + 0.5 + 1 + 0.5)
    assert cost(peak_slip_m=1.0, peak_tilt_deg=300.0) == pytest.approx(WORST) == 5.0
    assert cost(opposed=0.0) == pytest.approx(cost() + BROKEN)


WHOLE = {
    "penetration_m": 0.002, "pushed_m": 0.010, "pushed_deg": 10.0, "table_force_n": 15.0,
    "margin": 4.0, "strain": 2.0,
}  # fmt: skip
"""What every grasp may use up of its limits; twice a natural strain is what a search may."""


@pytest.mark.parametrize("name", WHOLE)
def test_a_success_is_worth_what_is_left_of_any_limit(name):
    assert cost(start=HELD, **{name: 0.7 * WHOLE[name]}) == pytest.approx(-0.3)
    assert cost(start=HELD, **{name: 0.2 * WHOLE[name]}) == pytest.approx(-0.75)  # slip's


@pytest.mark.parametrize("name", WHOLE)
def test_a_failure_costs_more_the_more_it_breaks_rules(name):
    assert cost(**{name: WHOLE[name]}) == pytest.approx(cost())
    assert cost(**{name: 2 * WHOLE[name]}) == pytest.approx(cost() + BROKEN)
    assert cost(**{name: 4 * WHOLE[name]}) == pytest.approx(cost() + 3 * BROKEN)
    assert cost(**{name: 99 * WHOLE[name]}) == pytest.approx(cost() + 3 * BROKEN)


def test_what_breaks_several_rules_costs_for_each_up_to_three_limits():
    values = {name: 1.25 * most for name, most in WHOLE.items()}
    assert cost(**values) == pytest.approx(cost() + 6 * 0.25 * BROKEN)
    assert cost(**values, opposed=0.0) == pytest.approx(cost() + 2.5 * BROKEN)
    values = {name: 2 * most for name, most in WHOLE.items()}
    assert cost(**values) == pytest.approx(cost() + 3 * BROKEN)


def test_no_failure_costs_as_much_as_a_nominal_one_that_ends_a_trial_of_a_plan():
    worst = cost(**{name: 99 * most for name, most in WHOLE.items()}, opposed=0.0,
                 peak_slip_m=1.0, peak_tilt_deg=300.0)  # fmt: skip
    assert worst == pytest.approx(5.9) and worst < 1.0 + WORST


def test_a_success_beyond_a_limit_that_no_rule_has_costs_less_than_any_failure():
    """The strain of the arm is no rule; a search leaves it all the same."""
    assert cost(start=HELD, strain=2.4) == pytest.approx(0.2)
    assert cost(start=HELD, strain=99.0) == pytest.approx(0.9)


def test_margins_of_what_is_not_lifted_and_hands_that_rest_cost_nothing():
    assert cost(CLICK, margin=40.0) == pytest.approx(cost(CLICK))
    assert cost(CLICK, table_force_n=30.0) == pytest.approx(cost(CLICK))
    assert cost(CLICK, start=HELD, peak_slip_m=0.0, table_force_n=15.0) == pytest.approx(-0.5)


@pytest.mark.parametrize(("opposed", "more"), [(0.95, 0.0), (1.0, 0.0), (0.475, 0.5), (0.0, 1.0)])
def test_a_failure_costs_more_the_less_it_is_opposed(opposed, more):
    assert cost(opposed=opposed) == pytest.approx(cost() + BROKEN * more)


def test_what_no_arm_can_follow_is_not_tried():
    scene = Scene.build(task_by_name("cube-raise"), Conditions())
    plan, _ = scripted_plan(scene.task, HandModel.from_spec(build_hand()))
    assert out_of_reach(scene, plan) is None
    far = [replace(plan, palm=plan.palm.moved(np.array([0, 0, z]))) for z in (0.8, 1.2, 5.0)]
    costs = [out_of_reach(scene, each) for each in far]
    assert None not in costs
    assert WORST < costs[0] < costs[1] < costs[2] == WORST + 5.0
    strains = [strain_of(each, scene.task, ReachingArm()) for each in far]
    assert NO_ARM < strains[0] < strains[1] < strains[2]
    assert costs[:2] == [WORST + min(each, 100.0) / 20.0 for each in strains[:2]]
    from_afar = replace(plan, retreat=np.array([0.0, 0.0, 1.2]))  # out of reach as it begins
    assert strain_of(plan, scene.task, ReachingArm()) < 1.0
    assert strain_of(from_afar, scene.task, ReachingArm()) > NO_ARM
    free = Scene.build(scene.task, Conditions(base="free"))
    assert out_of_reach(free, far[0]) is None


@pytest.mark.parametrize(
    ("values", "saved"),
    [
        ({"hold_s": 1.5}, 0.5),
        ({"hold_s": 9.0}, 1.0),
        ({"lift_m": 0.05}, 0.25),
        ({"lift_m": 0.9}, 0.5),
        ({"done": 0.6}, 0.6),
        ({"peak_slip_m": 0.01}, -0.05),
        ({"peak_tilt_deg": 60.0}, -0.2),
        # A tenth of a sixth of half the time since the squeeze began.
        ({"touch": (3.0,)}, 0.5 * 0.5 / 6),
        ({"touch": (3.0, 0.1, 0.1)}, 0.5 * 0.5 / 2),
    ],
)
def test_a_failure_costs_less_the_nearer_it_came(values, saved):
    assert cost() - cost(**values) == pytest.approx(saved)


def test_the_best_failure_costs_more_than_any_success():
    touch = (1.0,) * 6
    nearly = cost(lift_m=0.12, hold_s=3.2, done=1.0, touch=touch)
    assert nearly == pytest.approx(1 + 0.25)  # for the half of the time in which nothing touched
    assert nearly > cost(start=HELD)


def test_nothing_is_saved_by_what_a_rule_does_not_ask_for():
    """Sliding and clicking ask for no lift: there is none to be come near to."""
    for task in (SLIDE, CLICK):
        assert cost(task) == pytest.approx(4.0)
        assert cost(task, lift_m=0.2) == pytest.approx(4.0)
        assert cost(task, hold_s=0.5) == pytest.approx(3.5)
        brief = replace(task, rule=replace(task.rule, hold=0.0))
        assert cost(brief, hold_s=3.0) == pytest.approx(4.0)


def test_grip_counts_after_the_squeeze_began():
    time = np.arange(0.0, 3.005, 0.01)
    force = np.where(time <= 1.0, 1.0, 0.0)[:, None] * np.ones(6)
    phases = (Phase("reach", 0.0), Phase("squeeze", 1.0), Phase("action", 1.5))
    run = SimpleNamespace(outcome=LOST, time=time, contact_force=force, phases=phases)
    assert cost_of(run, MOVE) == pytest.approx(4.0)
    run.contact_force = 1.0 - force
    assert cost_of(run, MOVE) == pytest.approx(3.5)


def test_a_search_tries_as_it_is_and_perturbed():
    nominal = Conditions(seed=3, hand=HandSize(0.18))
    tried = tried_conditions(nominal, 2)
    assert tried[0] is nominal
    assert [each.nominal for each in tried] == [True, False, False]
    # Trials are given the seeds that follow the nominal one's; none of them may be practised.
    assert [each.seed for each in tried[1:]] == [1000, 1001]
    assert len({each.friction for each in tried}) == 3
    assert {each.hand.length for each in tried} == {0.18}
    assert tried_conditions(nominal, 0) == [nominal]


def test_perturbed_tries_are_by_turns_as_usual_and_wide():
    nominal = Conditions(hand=HandSize(0.18))
    tried = tried_conditions(nominal, 5)[1:]
    usual, wide = tried[::2], tried[1::2]
    assert usual == [perturb(nominal, seed) for seed in (1000, 1002, 1004)]
    assert wide == [perturb(nominal, seed, WIDE) for seed in (1001, 1003)]
    assert {(each.shake, each.bias) for each in usual} == {(2.0, 0.0)}
    assert {(each.shake, each.bias) for each in wide} == {(3.0, np.deg2rad(1.5))}


def test_wide_tries_are_wider_than_usual_trials_in_all():
    usual = Perturbation()
    for name in ("position", "yaw", "mass", "shake", "bias"):
        assert getattr(WIDE, name) > getattr(usual, name)
    assert WIDE.friction[0] < usual.friction[0] and WIDE.friction[1] == usual.friction[1]
    assert (WIDE.position, WIDE.mass, WIDE.friction) == (0.007, 0.5, (0.35, 0.8))
    assert (WIDE.yaw, WIDE.bias) == (np.deg2rad(7.0), np.deg2rad(1.5))


def test_a_nominal_failure_is_worse_than_failures_of_all_perturbed_tries():
    _, tries = counted([-0.1, 5.0, 5.0, 5.0, 5.0])
    assert robust_cost(tries) < 1.0 + WORST


def test_a_cost_of_one_is_a_failure():
    made, tries = counted([1.0, -0.5])
    assert robust_cost(tries) == 1.0 + WORST
    assert made == [1.0]
    made, tries = counted([-0.5, 1.0, 1.0, 1.0, -0.5])
    assert robust_cost(tries) == pytest.approx(0.5 * 3.5 / 5 + 0.5 * 1)
    assert len(made) == 4


def test_two_failures_end_nothing():
    made, tries = counted([-0.5, 2.0, -0.5, 3.0, -0.5])
    assert robust_cost(tries) == pytest.approx(0.5 * 3.5 / 5 + 0.5 * 3)
    assert len(made) == 5


def test_rests_that_count_as_failures_are_among_the_worst():
    """Of eight the worst two: the three failures count 1, 1 and 4, the four left out 2 each."""
    made, tries = counted([-0.5, 1.0, 1.0, 4.0, -0.5, -0.5, -0.5, -0.5])
    assert robust_cost(tries) == pytest.approx(0.5 * (5.5 + 4 * 2) / 8 + 0.5 * (4 + 2) / 2)
    assert len(made) == 4


def test_one_failure_outweighs_a_mean_that_is_a_little_better():
    """Four runs of which one slips are worse than four that just hold, of a greater mean cost."""
    _, slips = counted([-0.9, -0.9, -0.9, 1.5])
    _, holds = counted([-0.1, -0.1, -0.1, -0.1])
    assert np.mean([-0.9, -0.9, -0.9, 1.5]) < -0.1
    assert robust_cost(slips) > robust_cost(holds)


def evaluated(cost, **options):
    """What is evaluated in a search, in order, and its result."""
    points = []
    result = minimise(lambda x: points.append(np.array(x)) or cost(x), np.zeros(3), **options)
    return points, result


def bumpy(x) -> float:
    return float(((x - 0.7) ** 2).sum() + 0.3 * np.cos(9 * x).sum())


def test_a_search_returns_the_least_it_met_and_where():
    points, (least, where) = evaluated(bumpy, generations=4)
    assert len(points) == 1 + 4 * 8
    costs = [bumpy(x) for x in points]
    assert least == min(costs) < costs[0]
    np.testing.assert_array_equal(where, points[int(np.argmin(costs))])
    assert bumpy(where) == least


def test_a_search_follows_its_seed():
    first, second, other = (
        evaluated(bumpy, generations=1, seed=seed, population=6)[0] for seed in (0, 0, 1)
    )
    assert len(first) == 7
    np.testing.assert_array_equal(first, second)
    assert (np.array(first[1:]) != np.array(other[1:])).any()


def test_a_search_ends_when_what_it_met_is_good_enough():
    """By itself at -0.25, with room left in every limit: a grasp that just holds is not enough."""
    assert len(evaluated(lambda x: -0.26, generations=3)[0]) == 1
    assert len(evaluated(lambda x: -0.24, generations=3)[0]) > 1
    assert len(evaluated(lambda x: -0.24, generations=3, enough=-0.2)[0]) == 1


def test_of_equals_the_first_met_is_kept():
    points, (_, where) = evaluated(lambda x: 1.0, generations=1)
    assert len(points) == 9
    assert not where.any()


def test_an_estimate_counts_what_may_be_ahead_by_half_and_never_passes_the_end():
    told: list[float] = []
    estimate = Estimate(told.append)
    estimate.expect(2, 4)
    for _ in range(2):
        estimate.step()
    estimate.expect(2)
    for _ in range(3):  # one more than was expected
        estimate.step()
    assert told == [1 / 4, 2 / 4, 3 / 4, 1.0, 1.0]
    silent = Estimate(None)
    silent.step()
    assert Effort(3).most == 1 + 3 * POPULATION

import numpy as np
import pytest

from handsim.hand.tasks import task_by_name
from handsim.simulation.search import WORST, mean_cost, minimise, shortened


def counted(values):
    made = []
    return made, [lambda v=v: made.append(v) or v for v in values]


def test_the_mean_of_all_tries_counts_when_the_nominal_one_holds():
    made, tries = counted([-0.5, -0.3, 2.0])
    assert mean_cost(tries) == pytest.approx(0.4)
    assert len(made) == 3


def test_nothing_more_is_tried_where_the_nominal_try_fails():
    made, tries = counted([1.5, -0.3, -0.3])
    assert mean_cost(tries) == pytest.approx(1.5 + WORST)
    assert made == [1.5]


def test_after_three_failures_the_rest_is_taken_to_fail():
    made, tries = counted([-0.5, 2.0, 3.0, 4.0, -0.5, -0.5])
    assert mean_cost(tries) == pytest.approx((-0.5 + 2 + 3 + 4 + 3 + 3) / 6)
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
    assert shortened(task_by_name("mouse-slide")).rule.hold == 0.0

"""How many coefficients a box is given: what the budget allows, and no cap beside it."""

from itertools import product
from math import prod

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.navigation.workspace import knot_counts, lay_basis

RULES = {"variance": 1.0, "deviation": 0.5, "gentle": 0.25, "equal": 0.0}


@pytest.mark.parametrize("budget", [20, 62, 63, 100, 1000, 1_000_000])
def test_one_dimension_gets_the_whole_budget(budget):
    assert knot_counts(np.ones(1), budget=budget) == (budget,)


@pytest.mark.parametrize(("budget", "side"), [(62**2, 62), (63**2, 63), (300**2, 300)])
def test_equal_shares_of_a_plane_are_the_root_of_the_budget(budget, side):
    assert knot_counts(np.array([4.0, 1.0]), rule="equal", budget=budget) == (side, side)
    assert knot_counts(np.array([4.0, 1.0]), rule="equal", budget=budget - 1) == (side - 1,) * 2


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("budget", [500, 20_000, 3_000_000])
def test_as_many_as_the_budget_allows_in_the_rules_proportion(rule, budget):
    """One cell more along the first dimension would be more than the budget."""
    variance = np.array([1.0, 0.4, 0.09])
    counts = knot_counts(variance, 3, rule, budget)
    cells = counts[0] - 3
    assert prod(counts) <= budget
    assert prod(shared(variance, cells + 1, rule)) > budget
    assert counts == shared(variance, cells, rule)


def shared(variance: np.ndarray, cells: int, rule: str) -> tuple[int, ...]:
    return tuple(max(7, round(3 + cells * float(v ** RULES[rule]))) for v in variance)


def test_the_usual_budgets_give_what_they_gave():
    known = {
        (1.0,): (20,),
        (1.0, 0.5): (15, 13),
        (1.0, 0.5, 0.2): (14, 12, 10),
        (1.0, 0.6, 0.3, 0.1): (9, 8, 7, 7),
        (1.0, 0.5, 0.3, 0.2, 0.1): (7, 7, 7, 7, 7),
    }
    for variance, counts in known.items():
        assert knot_counts(np.array(variance)) == counts


def test_the_least_goes_before_the_budget():
    assert knot_counts(np.ones(3), budget=10) == (7, 7, 7)
    assert knot_counts(np.ones(2), budget=10, least=9) == (9, 9)


def test_a_greater_budget_never_gives_less():
    variance = np.array([1.0, 0.3])
    for rule, budget in product(RULES, range(49, 400, 7)):
        fewer, more = (knot_counts(variance, 3, rule, each) for each in (budget, budget + 7))
        assert all(a <= b for a, b in zip(fewer, more, strict=True))


def test_a_basis_takes_the_budget_that_it_is_given():
    line = [np.linspace(0.0, 1.0, 50)[:, None]]
    basis, width = lay_basis(line, budget=200)
    assert basis.shape == (200,)
    assert width.shape == (1,)
    with pytest.raises(InputError, match="component 2"):
        lay_basis([np.column_stack([line[0], np.zeros(50)])])

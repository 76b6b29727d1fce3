"""The minimiser: known minima, its line search, its budget, its log."""

import numpy as np
import pytest
from scipy import optimize

from handsim.learning.fit.lbfgs import minimise


def counted(function):
    calls = []

    def cost(x):
        calls.append(x.copy())
        return function(x)

    return cost, calls


def rosenbrock(x):
    return float(optimize.rosen(x)), optimize.rosen_der(x)


def quadratic(x):
    scale = 10.0 ** np.arange(len(x))
    return float(0.5 * np.sum(scale * (x - 1.0) ** 2)), scale * (x - 1.0)


@pytest.mark.parametrize("n", [2, 10])
def test_finds_the_minimum_of_a_bent_valley(n):
    found = minimise(rosenbrock, np.full(n, -1.2), 500, 0.0, 1e-9)
    np.testing.assert_allclose(found.x, 1.0, atol=1e-7)
    assert found.cost == pytest.approx(0.0, abs=1e-14)


def test_as_quick_as_scipys():
    cost, calls = counted(rosenbrock)
    start = np.full(10, -1.2)
    minimise(cost, start, 500, 0.0, 1e-6)
    theirs = optimize.minimize(rosenbrock, start, jac=True, method="L-BFGS-B",
                               options={"maxcor": 20, "gtol": 1e-6, "ftol": 0})  # fmt: skip
    assert len(calls) < 1.5 * theirs.nfev


def test_badly_scaled_quadratics():
    found = minimise(quadratic, np.zeros(5), 200, 0.0, 1e-9)
    np.testing.assert_allclose(found.x, 1.0, atol=1e-8)


def test_the_log_tells_of_every_iteration_and_cost_never_rises():
    after = []
    found = minimise(rosenbrock, np.full(4, -1.2), 12, 0.0, 0.0, lambda x: after.append(x.copy()))
    assert len(found.iterations) == len(after) == 12
    costs = [rosenbrock(np.full(4, -1.2))[0], *(one.cost for one in found.iterations)]
    assert (np.diff(costs) < 0).all()
    assert found.iterations[-1].cost == found.cost == rosenbrock(found.x)[0]
    assert found.iterations[-1].gradient_norm == pytest.approx(
        np.linalg.norm(rosenbrock(found.x)[1])
    )
    assert found.iterations[-1].change == pytest.approx(np.linalg.norm(after[-1] - after[-2]))


def test_ends_where_asked():
    start = np.full(4, -1.2)
    assert minimise(rosenbrock, start, 0, 0.0, 0.0).iterations == ()
    assert len(minimise(rosenbrock, start, 500, 1e-2, 0.0).iterations) < 60
    at_minimum = minimise(rosenbrock, np.ones(4), 50, 0.0, 1e-9)
    assert at_minimum.iterations == () and at_minimum.cost == 0


def test_steps_into_nowhere_are_drawn_back():
    """A cost that is infinite beyond a wall: -ln x + x, from far away."""

    def walled(x):
        if x[0] <= 0:
            return np.inf, np.full(1, np.nan)
        return float(x[0] - np.log(x[0])), 1.0 - 1.0 / x

    found = minimise(walled, np.array([30.0]), 100, 0.0, 1e-8)
    assert found.x[0] == pytest.approx(1.0, abs=1e-6)


def test_a_gradient_that_lies_ends_the_search():
    found = minimise(lambda x: (float(x @ x), -2.0 * x), np.ones(2), 50, 0.0, 0.0)
    assert found.iterations == ()
    np.testing.assert_array_equal(found.x, 1.0)

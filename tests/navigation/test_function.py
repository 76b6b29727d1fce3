"""Navigation functions: closed forms, finite differences, closure, evaluators."""

import pickle
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.function import NavigationFunction, _metric_of_one
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, Obstacle, SplineObstacle

GOAL = np.array([0.3, 0.4, 0.5])


def basis(n: int = 3, shape: tuple[int, ...] = (14, 12, 10)) -> TensorBasis:
    return TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), shape[:n])


def obstacle(kind: str, n: int = 3) -> Obstacle:
    bumps = np.random.default_rng(0).normal(size=basis(n).shape)
    if kind == "exponential":
        return ExponentialObstacle(TensorBSpline(basis(n), 0.3 * bumps), np.full(n, 0.2))
    return SplineObstacle(TensorBSpline(basis(n), 1.0 + 0.2 * bumps))


def metric(n: int) -> DestinationMetric:
    rng = np.random.default_rng(7)
    logs = 0.2 * rng.normal(size=(3, n, n))
    return DestinationMetric(rng.normal(size=(2, n)), logs + np.swapaxes(logs, 1, 2), 0.8)


def points(n: int = 3, count: int = 30) -> np.ndarray:
    return np.random.default_rng(1).uniform(-0.99, 1.99, (count, n))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", ["exponential", "spline"])
@pytest.mark.parametrize("k", [2, 3.5, 8])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_gradient_and_hessian_by_finite_differences(
    kind: str, k: float, n: int, turned: bool
) -> None:
    phi = NavigationFunction(obstacle(kind, n), k, metric(n) if turned else None)
    z, goal, step = points(n), GOAL[:n], 1e-6
    assert (z > phi.obstacle.lower + step).all() and (z < phi.obstacle.upper - step).all()
    _, gradient, hessian = phi.jets(z, goal, 2)
    assert np.abs(gradient).max() > 0.1 and np.abs(hessian).max() > 0.5
    for i, unit in enumerate(np.eye(n)):
        ahead, behind = (phi.jets(z + s * step * unit, goal, 1) for s in (1, -1))
        np.testing.assert_allclose((ahead[0] - behind[0]) / (2 * step), gradient[:, i], atol=2e-7)
        np.testing.assert_allclose((ahead[1] - behind[1]) / (2 * step), hessian[:, i], atol=5e-7)
    np.testing.assert_allclose(hessian, np.swapaxes(hessian, 1, 2), atol=1e-9)


@pytest.mark.parametrize("kind", ["exponential", "spline"])
def test_value_lies_between_0_at_the_goal_and_1(kind: str) -> None:
    phi = NavigationFunction(obstacle(kind), 3)
    value = phi.jets(points(count=1000), GOAL, 0)[0]
    assert value.min() > 0 and value.max() < 1
    at_goal, gradient = phi.value_and_gradient(GOAL, GOAL)
    assert at_goal == 0 and (gradient == 0).all()
    batch = phi.jets(GOAL[None], GOAL, 2)
    assert batch[0][0] == 0 and (batch[1] == 0).all()
    # The goal is a minimum: the Hessian there is 2 beta^(-1/k) I.
    ln_beta = phi.obstacle.evaluator(3)(GOAL.tolist())[0]
    np.testing.assert_allclose(batch[2][0], 2 * np.exp(-ln_beta / 3) * np.eye(3), atol=1e-12)


def test_sphere_obstacle_in_closed_form() -> None:
    """One sphere, beta = |z - o|^2 - r^2, which cubic splines represent exactly."""
    centre, radius, k = np.array([0.9, 1.1]), 0.4, 3.0
    space = basis(2)
    greville = [np.array([t[i + 1 : i + 4] for i in range(m)]) for t, m in
                zip(space.knots, space.shape, strict=True)]  # fmt: skip
    # Marsden: x^2 has the coefficient (ab + bc + ca) / 3 on inner knots a, b, c.
    squares = [(g[:, 0] * g[:, 1] + g[:, 1] * g[:, 2] + g[:, 2] * g[:, 0]) / 3 for g in greville]
    terms = [
        s - 2 * o * g.mean(1) + o**2 for s, o, g in zip(squares, centre, greville, strict=True)
    ]
    c = terms[0][:, None] + terms[1][None, :] - radius**2
    phi = NavigationFunction(SplineObstacle(TensorBSpline(space, c)), k)
    goal = GOAL[:2]
    z = points(2, 200)
    gamma = np.sum((z - goal) ** 2, axis=1)
    beta = np.sum((z - centre) ** 2, axis=1) - radius**2
    free = beta > 1e-3
    assert 100 < free.sum() < 200
    value, gradient, _ = phi.jets(z[free], goal, 1)
    np.testing.assert_allclose(value, (gamma / (gamma**k + np.abs(beta)) ** (1 / k))[free])
    # The paper's u_c of Sec. V-C.
    grad_gamma, grad_beta = 2 * (z - goal), 2 * (z - centre)
    u = beta[:, None] * grad_gamma - (gamma / k)[:, None] * grad_beta
    u = u / ((gamma**k + np.abs(beta)) ** (1 / k + 1))[:, None]
    np.testing.assert_allclose(gradient, u[free], atol=1e-10)
    # Inside the sphere the flow leaves it.
    inside = centre + 0.05 * np.eye(2)
    outwards = inside - centre
    np.testing.assert_allclose(phi.directions(inside, goal), outwards / 0.05, atol=1e-6)


def test_constant_beta_gives_straight_lines() -> None:
    flat = SplineObstacle(TensorBSpline(basis(), np.full(basis().shape, 1.7)))
    phi = NavigationFunction(flat, 2)
    towards = GOAL - points()
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    np.testing.assert_allclose(phi.directions(points(), GOAL), towards, atol=1e-12)


def test_workspace_is_closed() -> None:
    closed = obstacle("exponential")
    phi = NavigationFunction(closed, 4)
    for axis in range(3):
        for face, outwards in ((closed.lower, -1.0), (closed.upper, 1.0)):
            on_face = points()
            on_face[:, axis] = face[axis]
            np.testing.assert_allclose(phi.jets(on_face, GOAL, 0)[0], 1.0, atol=1e-9)
            flow = phi.directions(on_face, GOAL)
            assert (flow[:, axis] * outwards < -0.99).all()


def test_closing_layer_is_twice_differentiable_and_absent_inside() -> None:
    flat = ExponentialObstacle(TensorBSpline(basis(1), np.zeros(14)), np.array([0.2]))
    edge = np.array([[-0.8 - 1e-7], [-0.8 + 1e-7]])
    for part in flat.closure(edge):
        just_outside, just_inside = part.ravel()
        assert just_inside == 0
        assert just_outside == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", ["exponential", "spline"])
def test_one_point_and_many_points_agree(kind: str, turned: bool) -> None:
    phi = NavigationFunction(obstacle(kind), 2.5, metric(3) if turned else None)
    z = np.vstack([points(), np.array([[-0.95, 1.9, 0.3], [-3.0, 0.5, 4.0]])])
    value, gradient, _ = phi.jets(z, GOAL, 1)
    directions = phi.directions(z, GOAL)
    for i, one in enumerate(z):
        one_value, one_gradient = phi.value_and_gradient(one, GOAL)
        assert one_value == pytest.approx(value[i], rel=1e-9)
        np.testing.assert_allclose(one_gradient, gradient[i], rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(phi.direction(one, GOAL), directions[i], atol=1e-9)
    steep = np.linalg.norm(gradient, axis=1) > 1e-9
    unit = -gradient[steep] / np.linalg.norm(gradient[steep], axis=1, keepdims=True)
    np.testing.assert_allclose(directions[steep], unit, atol=1e-9)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", ["exponential", "spline"])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_an_evaluator_writes_what_the_function_returns(kind: str, n: int, turned: bool) -> None:
    phi = NavigationFunction(obstacle(kind, n), 2.5, metric(n) if turned else None)
    evaluator, out, goal = phi.evaluator(), np.empty(n), GOAL[:n]
    at_edge = np.array([[-0.95, 1.9, 0.3], [-3.0, 0.5, 4.0]])[:, :n]
    z = np.vstack([points(n), goal, at_edge])
    batch, directions = phi.jets(z, goal, 1), phi.directions(z, goal)
    for i, one in enumerate(z):
        value, gradient = phi.value_and_gradient(one, goal)
        assert evaluator.value_and_gradient(one, goal, out) == value
        np.testing.assert_array_equal(out, gradient)
        np.testing.assert_allclose(gradient, batch[1][i], rtol=1e-6, atol=1e-12)
        evaluator.direction(one, goal, out)
        np.testing.assert_array_equal(out, phi.direction(one, goal))
        np.testing.assert_allclose(out, directions[i], atol=1e-9)


def test_destinations_of_a_batch_each_have_their_metric() -> None:
    phi = NavigationFunction(obstacle("exponential"), 2.5, metric(3))
    z, goals = points(count=6), np.repeat(points(count=9)[6:], 2, axis=0)
    value, gradient, hessian = phi.jets(z, goals, 2)
    directions, evaluator, out = phi.directions(z, goals), phi.evaluator(), np.empty(3)
    for i, (one, goal) in enumerate(zip(z, goals, strict=True)):
        assert evaluator.value_and_gradient(one, goal, out) == pytest.approx(value[i], rel=1e-9)
        np.testing.assert_allclose(out, gradient[i], rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(phi.jets(one[None], goal, 2)[2][0], hessian[i], atol=1e-9)
        evaluator.direction(one, goal, out)
        np.testing.assert_allclose(out, directions[i], atol=1e-9)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", ["exponential", "spline"])
def test_an_evaluator_makes_no_arrays(kind: str, turned: bool) -> None:
    class Derived(np.ndarray):
        made = 0

        def __array_finalize__(self, source: object) -> None:
            Derived.made += 1

    phi = NavigationFunction(obstacle(kind), 4, metric(3) if turned else None)
    z, goal, out = (a.view(Derived) for a in (points()[0], GOAL, np.empty(3)))
    evaluator = phi.evaluator()
    evaluator.direction(z, goal, out)  # the metric of a new destination takes arrays, once
    made = Derived.made
    with_arrays = peak_bytes(lambda: phi.value_and_gradient(points()[0], GOAL))
    for run in (
        lambda: evaluator.value_and_gradient(z, goal, out),
        lambda: evaluator.direction(z, goal, out),
    ):
        # What is left are the lists of floats of one point.
        assert 0 < peak_bytes(run) < min(1200, 0.6 * with_arrays)
    assert Derived.made == made


def peak_bytes(run: Callable[[], object]) -> int:
    """Most memory that a call holds at once beyond what was held before it."""
    for _ in range(10):
        run()
    tracemalloc.start()
    try:
        run()
        tracemalloc.reset_peak()
        before, _ = tracemalloc.get_traced_memory()
        run()
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()


def test_bad_exponents_and_destinations() -> None:
    for k in (1.9, -3, np.nan, np.inf):
        with pytest.raises(InputError, match="2 or more"):
            NavigationFunction(obstacle("spline"), k)
    phi = NavigationFunction(obstacle("exponential"), 2)
    np.testing.assert_array_equal(phi.check_goal(GOAL), GOAL)
    with pytest.raises(InputError, match="outside the workspace"):
        phi.check_goal(np.array([0.0, 2.5, 0.0]))
    for bad in (GOAL[:2], np.array([0.0, np.nan, 0.0])):
        with pytest.raises(InputError, match="3 finite"):
            phi.check_goal(bad)
    negative = SplineObstacle(TensorBSpline(basis(), np.full(basis().shape, -0.5)))
    with pytest.raises(InputError, match="not positive"):
        NavigationFunction(negative, 2).check_goal(GOAL)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_the_metric_of_one_destination_is_that_of_many(n: int) -> None:
    rng = np.random.default_rng(1)
    half = rng.normal(size=(6, n, n))
    logs = 0.3 * (half + np.swapaxes(half, 1, 2))
    metric = DestinationMetric(rng.normal(size=(5, n)), logs, 0.8)
    of_one = _metric_of_one(metric)
    goals = rng.normal(size=(20, n))
    far = np.full((1, n), 50.0)  # where all shares vanish
    for goal, wanted in zip(
        np.vstack([goals, far]), metric.at(np.vstack([goals, far])), strict=True
    ):
        found = of_one(goal.tolist())
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12)
        assert of_one(goal.tolist()) is found  # the latest is kept


@pytest.mark.parametrize("curved", [True, False])
def test_it_can_be_pickled_after_it_was_evaluated(curved: bool) -> None:
    """Processes hand controllers and plans to each other at any time."""
    function = NavigationFunction(obstacle("exponential"), 4.0, metric(3) if curved else None)
    z, direction, again = np.array([0.1, 0.9, 0.4]), np.empty(3), np.empty(3)
    function.evaluator().direction(z, GOAL, direction)
    copy = pickle.loads(pickle.dumps(function))
    copy.evaluator().direction(z, GOAL, again)
    np.testing.assert_array_equal(again, direction)

"""The metric of destinations: what any metric keeps, its parameters, its gradient."""

import numpy as np
import pytest
from scipy.optimize import check_grad

from handsim.learning.direction.metric_model import Attraction, MetricModel, traceless_symmetric
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.certificate import certify
from handsim.navigation.critical_points import critical_points, grid
from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle


def random_metric(n: int = 3, seed: int = 0, scale: float = 1.0) -> DestinationMetric:
    rng = np.random.default_rng(seed)
    logs = scale * rng.normal(size=(5, n, n))
    return DestinationMetric(rng.normal(size=(4, n)), logs + np.swapaxes(logs, 1, 2), 0.8)


def bumpy(n: int, scale: float, metric: DestinationMetric | None) -> NavigationFunction:
    basis = TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), (9,) * n)
    bumps = scale * np.random.default_rng(0).normal(size=basis.shape)
    return NavigationFunction(
        ExponentialObstacle(TensorBSpline(basis, bumps), np.full(n, 0.2)), 3, metric
    )


def test_metrics_are_symmetric_and_positive_whatever_the_destination() -> None:
    goals = 3 * np.random.default_rng(1).normal(size=(200, 3))
    metrics = random_metric(scale=0.4).at(goals)
    np.testing.assert_allclose(metrics, np.swapaxes(metrics, 1, 2), atol=1e-9)
    least = np.linalg.eigvalsh(metrics)[:, 0]
    assert least.min() > 0 and np.ptp(least) > 0.1


def test_far_destinations_have_the_common_metric() -> None:
    metric = random_metric()
    eigenvalues, vectors = np.linalg.eigh(metric.logs[0])
    far = metric.at(np.full(3, 50.0))
    np.testing.assert_allclose(far, vectors @ np.diag(np.exp(eigenvalues)) @ vectors.T)


def test_answers_do_not_depend_on_those_before() -> None:
    metric = random_metric()
    goals = np.random.default_rng(2).normal(size=(4, 3))
    for one in (goals[0], goals[1], goals[:2], goals[:2].ravel()[:3], goals, goals[::-1].copy()):
        np.testing.assert_array_equal(metric.at(one), random_metric().at(one))
        assert metric.at(one).shape == (*one.shape, 3)


def test_the_pull_towards_the_destination_is_that_of_the_distance_itself() -> None:
    """(z - z_goal) . grad ln gamma_d = 2 for every metric: why one proof serves all."""
    navigation = bumpy(3, 0.0, random_metric())
    rng = np.random.default_rng(3)
    z, goal = rng.uniform(-0.7, 1.7, (50, 3)), np.array([0.3, 0.4, 0.5])
    step = 1e-6
    slopes = np.stack(
        [
            navigation.attraction(z + step * unit, goal)[0]
            - navigation.attraction(z - step * unit, goal)[0]
            for unit in np.eye(3)
        ],
        axis=1,
    ) / (2 * step)  # fmt: skip
    along = np.sum((z - goal) * slopes, axis=1) / navigation.attraction(z, goal)[0]
    np.testing.assert_allclose(along, 2.0, atol=1e-5)
    # And yet paths are not straight.
    towards = (goal - z) / np.linalg.norm(goal - z, axis=1, keepdims=True)
    assert np.sum(navigation.directions(z, goal) * towards, axis=1).min() < 0.9


@pytest.mark.parametrize("seed", range(5))
def test_a_certified_field_leads_everywhere_in_any_metric(seed: int) -> None:
    rng = np.random.default_rng(seed)
    navigation = bumpy(2, 0.12, random_metric(2, seed, 0.4))
    goals = rng.uniform(0.0, 1.0, (5, 2))
    assert certify(navigation, goals).certified
    starts = rng.uniform(-0.99, 1.99, (60, 2))
    goal = goals[seed]
    paths = follow(navigation.directions, starts, np.tile(goal, (60, 1)), np.deg2rad(0.5))
    assert all(path.arrived for path in paths)
    for path in paths:
        distance = np.linalg.norm(path.points - goal, axis=1)
        assert (np.diff(distance) < 1e-3).all()
    assert critical_points(navigation, goal, grid(navigation, 6)) == []


def test_traps_are_found_in_a_metric_too() -> None:
    """Newton's search ends at points where grad phi, by another formula, is zero."""
    navigation = bumpy(2, 1.5, random_metric(2, 1, 0.4))
    goal = np.array([0.4, 0.6])
    assert not certify(navigation, goal[None]).certified
    found = critical_points(navigation, goal, grid(navigation, 12))
    assert any(point.kind == "minimum" for point in found)
    points = np.array([point.z for point in found])
    slope = np.linalg.norm(navigation.jets(points, goal, 1)[1], axis=1)
    around = np.linalg.norm(navigation.jets(points + 0.05, goal, 1)[1], axis=1)
    assert (slope < 1e-6 * around.max()).all()


@pytest.mark.parametrize("n", [2, 3, 5])
def test_gradient_by_the_parameters(n: int) -> None:
    rng = np.random.default_rng(0)
    goals = rng.normal(size=(7, n))
    model = MetricModel(np.vstack([goals, goals[:3]]), 1.0)
    assert len(model.goals) == 7
    attraction = Attraction(model, rng.normal(size=(40, n)), goals[rng.integers(7, size=40)])
    weights = rng.normal(size=(n, 40))

    def cost(p: np.ndarray) -> float:
        return float(np.sum(attraction(p)[0] * weights))

    def slope(p: np.ndarray) -> np.ndarray:
        return attraction(p)[1](weights)

    for p in (np.zeros(model.n_parameters), 0.5 * rng.normal(size=model.n_parameters)):
        assert check_grad(cost, slope, p) < 1e-5 * np.linalg.norm(slope(p))


def test_the_model_and_its_metric_agree() -> None:
    rng = np.random.default_rng(5)
    model = MetricModel(rng.normal(size=(12, 3)), 0.7)
    p = rng.normal(size=model.n_parameters)
    metrics, _ = model.metrics(p)
    np.testing.assert_allclose(model.metric(p).at(model.goals), metrics, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.det(metrics), 1.0, rtol=1e-9)
    np.testing.assert_array_equal(model.metrics(0 * p)[0], np.tile(np.eye(3), (12, 1, 1)))


def test_many_destinations_are_stood_for_by_few() -> None:
    goals = np.random.default_rng(6).uniform(0, 1, (1000, 3))
    assert MetricModel(goals, 0.5).n_parameters <= 5 * 41
    crowded = np.vstack([goals[:1], goals[:1] + 1e-3])
    assert MetricModel(crowded, 0.5).n_parameters == 5 * 2


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_basis_of_symmetric_matrices(n: int) -> None:
    basis = traceless_symmetric(n)
    assert basis.shape == (n * (n + 1) // 2 - 1, n, n)
    np.testing.assert_array_equal(basis, np.swapaxes(basis, 1, 2))
    np.testing.assert_allclose(np.trace(basis, axis1=1, axis2=2), 0.0, atol=1e-12)
    gram = np.einsum("aij,bij->ab", basis, basis)
    np.testing.assert_allclose(gram, np.eye(len(basis)), atol=1e-12)

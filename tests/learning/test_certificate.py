"""The proof: its bounds against dense samples, planted minima, constant and closed-form beta."""

import numpy as np
import pytest

from handsim.learning.bspline import TensorBasis, TensorBSpline
from handsim.learning.certificate import certify, descent_supremum, violations
from handsim.learning.critical import critical_points
from handsim.learning.navigation import (
    ExponentialObstacle,
    NavigationFunction,
    Obstacle,
    SplineObstacle,
)


def basis(n: int = 3) -> TensorBasis:
    return TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), (8, 7, 9)[:n])


def random_chi(n: int, seed: int, scale: float = 1.0) -> TensorBSpline:
    return TensorBSpline(basis(n), scale * np.random.default_rng(seed).normal(size=basis(n).shape))


def exponential(chi: TensorBSpline, k: float = 3.0) -> NavigationFunction:
    return NavigationFunction(ExponentialObstacle(chi, np.full(chi.coefficients.ndim, 0.2)), k)


def fitted(function: object, n: int) -> np.ndarray:
    """Coefficients of the spline nearest to a function, by least squares on a grid."""
    axes = [np.linspace(a, b, 30) for a, b in zip(basis(n).lower, basis(n).upper, strict=True)]
    z = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, n)
    design = basis(n).design(z, (0,) * n)
    normal = (design.T @ design).toarray()
    return np.linalg.solve(normal, design.T @ function(z))  # type: ignore[operator]


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_supremum_is_bracketed_attained_and_above_all_samples(n: int, seed: int) -> None:
    chi = random_chi(n, seed)
    low, high = np.full(n, 0.1), np.full(n, 0.6)
    bound = descent_supremum(chi, low, high, 1e-4)
    assert bound.lower <= bound.upper <= bound.lower + 1.1e-4

    def at(z: np.ndarray) -> np.ndarray:
        gradient = chi.jets(z, 1)[1]
        return np.maximum((z - low) * gradient, (z - high) * gradient).sum(axis=1)

    z = np.random.default_rng(seed).uniform(-1, 2, (20_000, n))
    assert at(z).max() <= bound.upper + 1e-9
    assert at(bound.where[None])[0] == pytest.approx(bound.lower, abs=1e-9)


def test_supremum_in_closed_form() -> None:
    # chi = c |z|^2 / 2, goals at the origin: (z - 0) . grad chi = c |z|^2, at most 12 c in the box.
    c = fitted(lambda z: 0.5 * 0.1 * np.sum(z**2, axis=1), 3)
    bound = descent_supremum(TensorBSpline(basis(), c), np.zeros(3), np.zeros(3), 1e-6)
    assert bound.upper == pytest.approx(1.2, abs=1e-5)
    np.testing.assert_allclose(bound.where, [2, 2, 2])


def test_certified_just_below_two_and_refuted_just_above() -> None:
    chi = random_chi(3, 0)
    goals = np.array([[0.1, 0.2, 0.3], [0.5, 0.1, 0.4]])
    top = descent_supremum(chi, goals.min(0), goals.max(0), 1e-7).upper
    for factor, certified in ((1.9999, True), (2.0001, False)):
        scaled = TensorBSpline(basis(), factor / top * chi.coefficients)
        proof = certify(exponential(scaled), goals, 1e-6)
        assert proof.certified is certified
        assert proof.k_min == (2.0 if certified else None)


def wells(seed: int) -> tuple[NavigationFunction, np.ndarray, np.ndarray]:
    """A random smooth field with a well dug into beta, deep enough to hold a local minimum."""
    rng = np.random.default_rng(seed)
    goal, trap = rng.uniform(-0.3, 0.2, 2), rng.uniform(0.9, 1.3, 2)

    def chi(z: np.ndarray) -> np.ndarray:
        return 8.0 * np.exp(-0.5 * np.sum((z - trap) ** 2, axis=1) / 0.45**2)

    smooth = 0.05 * rng.normal(size=basis(2).shape).ravel()
    return exponential(TensorBSpline(basis(2), fitted(chi, 2) + smooth)), goal, trap


@pytest.mark.parametrize("seed", range(100))
def test_a_planted_minimum_is_never_certified_and_is_found(seed: int) -> None:
    navigation, goal, trap = wells(seed)
    assert not certify(navigation, goal[None]).certified
    found = critical_points(navigation, goal, trap + 0.1 * np.eye(2))
    minima = [point for point in found if point.kind == "minimum"]
    assert minima, "the well holds no minimum: the test plants nothing"
    gradient = navigation.jets(minima[0].z[None], goal, 1)[1]
    assert np.linalg.norm(gradient) < 1e-6
    assert minima[0].eigenvalues.min() > 0


def test_constant_beta_is_certified() -> None:
    flat = np.full(basis().shape, 1.7)
    for obstacle in (
        SplineObstacle(TensorBSpline(basis(), flat)),
        ExponentialObstacle(TensorBSpline(basis(), flat), np.full(3, 0.2)),
    ):
        proof = certify(NavigationFunction(obstacle, 2), np.array([[0.1, 0.2, 0.3]]))
        assert proof.certified and proof.k_min == 2.0


def test_least_exponent_of_a_spline_in_closed_form() -> None:
    # beta = 1 + 2 (x + 1), goal 0: sup of 2 x / (2 beta) over [-1, 2] is 2 / 7, at x = 2.
    gentle = TensorBSpline(basis(1), fitted(lambda z: 1 + 2 * (z[:, 0] + 1), 1))
    proof = certify(NavigationFunction(SplineObstacle(gentle), 2), np.array([[0.0]]), 1e-6)
    assert proof.supremum is not None
    assert proof.supremum.upper == pytest.approx(2 / 7, abs=1e-4)
    assert proof.certified and proof.k_min == 2.0
    # A steeper one, against a fine sample of the closed form.
    steep = TensorBSpline(basis(1), fitted(lambda z: 0.01 + (z[:, 0] + 1) ** 3, 1))
    goal = np.array([[-0.5]])
    x = np.linspace(-1, 2, 200_001)
    exact = ((x + 0.5) * 3 * (x + 1) ** 2 / (2 * (0.01 + (x + 1) ** 3))).max()
    proof = certify(NavigationFunction(SplineObstacle(steep), 2), goal, 1e-6)
    assert proof.supremum is not None
    assert proof.supremum.upper == pytest.approx(exact, abs=1e-4)


def test_exponents_below_the_least_are_refused() -> None:
    # Flat, then rising as a cube: away from the goal, beta grows faster than gamma_d^2.
    beta = TensorBSpline(basis(1), fitted(lambda z: 0.002 + 10 * np.maximum(z[:, 0], 0) ** 3, 1))
    lifted = TensorBSpline(basis(1), beta.coefficients + 0.05 - beta.coefficients.min())
    goal = np.array([[-0.9]])
    k_min = certify(NavigationFunction(SplineObstacle(lifted), 2), goal).k_min
    assert k_min is not None and k_min > 2.1
    for k, certified in ((k_min - 0.01, False), (k_min, True), (k_min + 1, True)):
        assert certify(NavigationFunction(SplineObstacle(lifted), k), goal).certified is certified


def test_what_cannot_be_certified_says_why() -> None:
    goal = np.array([[0.1, 0.2, 0.3]])
    negative = SplineObstacle(random_chi(3, 1))
    assert "not positive" in certify(NavigationFunction(negative, 2), goal).reason
    outside = certify(exponential(random_chi(3, 1, 1e-3)), np.array([[-0.95, 0.2, 0.3]]))
    assert not outside.certified and "closing layer" in outside.reason

    class Other:
        lower, upper = basis().lower, basis().upper
        evaluator = staticmethod(negative.evaluator)
        log_jets = staticmethod(negative.log_jets)

    other: Obstacle = Other()
    assert "no proof is known" in certify(NavigationFunction(other, 2), goal).reason


def test_violations_are_where_the_condition_fails() -> None:
    chi, low, high = random_chi(2, 3), np.zeros(2), np.full(2, 0.3)
    points = violations(chi, low, high, 2.0, most=50)
    assert 0 < len(points) <= 50
    gradient = chi.jets(points, 1)[1]
    at = np.maximum((points - low) * gradient, (points - high) * gradient).sum(axis=1)
    assert np.mean(at > 2.0) > 0.8  # coefficients are near values, not values
    assert len(violations(chi, low, high, 1e9)) == 0


def test_certified_fields_have_no_other_critical_point() -> None:
    chi = random_chi(2, 5)
    goal = np.array([0.2, 0.3])
    top = descent_supremum(chi, goal, goal).upper
    calm = exponential(TensorBSpline(basis(2), 1.99 / top * chi.coefficients))
    assert certify(calm, goal[None]).certified
    starts = np.random.default_rng(0).uniform(-1, 2, (300, 2))
    assert critical_points(calm, goal, starts) == []
    wild = exponential(TensorBSpline(basis(2), 12 / top * chi.coefficients))
    kinds = {point.kind for point in critical_points(wild, goal, starts)}
    assert "saddle" in kinds

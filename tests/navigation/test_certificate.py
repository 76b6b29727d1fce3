"""The proof: its bounds against dense samples, planted minima, constant and closed-form beta."""

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from handsim.navigation import certificate
from handsim.navigation._bernstein import Cells
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.certificate import (
    _descent_coefficients,
    certify,
    descent_supremum,
    violations,
)
from handsim.navigation.critical_points import critical_points
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, Obstacle, SplineObstacle


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
    design = NdBSpline.design_matrix(z, basis(n).knots, basis(n).degree)
    normal = (design.T @ design).toarray()
    return np.linalg.solve(normal, design.T @ function(z))  # type: ignore[operator]


def greville(n: int) -> list[np.ndarray]:
    """Where the coefficients of a linear function are its values, one array a dimension."""
    return [np.array([k[i + 1 : i + 4].mean() for i in range(len(k) - 4)]) for k in basis(n).knots]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("tolerance", [0.01, 0.3, 3.0])
def test_the_upper_bound_is_one_however_coarse(seed: int, tolerance: float) -> None:
    chi, low, high = random_chi(2, seed), np.zeros(2), np.array([0.5, 0.2])
    exact = descent_supremum(chi, low, high, 1e-10)
    coarse = descent_supremum(chi, low, high, tolerance)
    assert exact.upper - exact.lower <= 1e-10
    assert coarse.lower <= exact.lower + 1e-12 and exact.upper <= coarse.upper + 1e-9
    assert coarse.upper <= coarse.lower + tolerance + 1e-12


def test_without_tolerance_cells_are_split_until_they_do_not_matter() -> None:
    bound = descent_supremum(random_chi(1, 3), np.zeros(1), np.zeros(1), 0.0)
    assert bound.lower <= bound.upper < bound.lower + 1e-11


@pytest.mark.parametrize("budget", [1, 5, 10])
@pytest.mark.parametrize("seed", range(4))
def test_a_spent_budget_leaves_a_true_bound(
    seed: int, budget: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    chi, goal = random_chi(2, seed), np.full(2, 0.3)
    exact = descent_supremum(chi, goal, goal, 1e-10)
    numbers = []
    original = certificate._descent_coefficients

    def counted(cells: Cells, *box: np.ndarray) -> np.ndarray:
        numbers.append(len(cells.origin))
        return original(cells, *box)

    monkeypatch.setattr(certificate, "_descent_coefficients", counted)
    monkeypatch.setattr(certificate, "_MAX_CELLS", budget)
    bound = descent_supremum(chi, goal, goal, 1e-10)
    assert bound.lower <= exact.lower + 1e-12
    assert exact.lower + 1e-7 < bound.upper  # it is wide, and it holds
    assert max(numbers) <= budget or numbers == [20]
    # Nothing is proved that is only true where it was looked at.
    scaled = TensorBSpline(basis(2), 4.0 / (bound.upper + exact.upper) * chi.coefficients)
    proof = certify(exponential(scaled), goal[None], 1e-10)
    assert not proof.certified and proof.k_min is None


def test_a_spline_is_not_certified_once_its_budget_is_spent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wavy = TensorBSpline(basis(2), 2.0 + random_chi(2, 0, 0.3).coefficients)
    navigation = NavigationFunction(SplineObstacle(wavy), 50.0)
    goal = np.full((1, 2), 0.3)
    assert certify(navigation, goal).certified
    monkeypatch.setattr(certificate, "_MAX_CELLS", 1)
    proof = certify(navigation, goal)
    assert (proof.certified, proof.k_min, proof.supremum) == (False, None, None)
    assert "budget" in proof.reason


def test_the_upper_bound_decides() -> None:
    """Of a bracket with 2 inside nothing follows, nor of one that ends at 2."""
    chi, goals = random_chi(2, 2), np.array([[0.1, 0.2], [0.4, 0.0]])
    wide = descent_supremum(chi, goals.min(0), goals.max(0), 2.0)
    assert wide.upper > 1.05 * wide.lower > 0
    for value, certified in (
        (wide.upper * (1 - 1e-8), True),
        (0.5 * (wide.lower + wide.upper), False),
        (wide.lower * (1 + 1e-8), False),
        (wide.upper, False),
        (wide.upper * (1 + 1e-10), False),
    ):
        factor = 2.0 / value if not certified else 2.0 / wide.upper * (1 - 1e-8)
        scaled = TensorBSpline(basis(2), factor * chi.coefficients)
        proof = certify(exponential(scaled), goals, 2.0 * factor)
        assert proof.certified is certified
        assert proof.supremum is not None
        told = proof.supremum.upper if certified else proof.supremum.lower
        assert f"{told:.4f}" in proof.reason


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_the_closing_layer_lies_at_every_face(axis: int, side: str) -> None:
    width = np.array([0.1, 0.2, 0.4])
    flat = ExponentialObstacle(TensorBSpline(basis(), np.zeros(basis().shape)), width)
    edge = flat.lower + width if side == "lower" else flat.upper - width
    for outwards, certified in ((0.0, True), (1e-9, False)):
        goals = np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [0.4, 0.1, 0.0]])
        goals[1, axis] = edge[axis] + (-outwards if side == "lower" else outwards)
        proof = certify(NavigationFunction(flat, 3.0), goals)
        assert proof.certified is certified
        assert ("closing layer" in proof.reason) is not certified


def test_all_destinations_count_not_the_first_and_last() -> None:
    chi = random_chi(2, 4, 0.05)
    goals = np.array([[0.2, 0.3], [-0.5, 0.4], [1.2, 0.1], [0.1, -0.6], [0.3, 1.3], [0.25, 0.3]])
    whole = descent_supremum(chi, np.array([-0.5, -0.6]), np.array([1.2, 1.3]), 1e-6)
    found = certify(exponential(chi), goals, 1e-6).supremum
    assert found is not None and found.upper == whole.upper
    corners = [
        descent_supremum(chi, goal, goal, 1e-6).upper
        for goal in np.array([[x, y] for x in (-0.5, 1.2) for y in (-0.6, 1.3)])
    ]
    assert max(corners) == pytest.approx(whole.upper, abs=2e-6)


def test_greatest_ratios_of_polynomials() -> None:
    """Of Bernstein coefficients a over b: the greatest a over the least b, or the greatest."""
    ratio = certificate._greatest_ratio
    a, b = np.array([[3.0, 1.0], [-3.0, -4.0], [0.0, -1.0]]), np.array([[1.0, 2.0]] * 3)
    np.testing.assert_array_equal(ratio(a, b), [3.0, -1.5, 0.0])
    np.testing.assert_array_equal(ratio(a, b - 1.0), np.inf)  # least of b is 0
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(500, 4)), rng.uniform(0.01, 3.0, (500, 4))
    u = np.linspace(0, 1, 50)[:, None]
    bernstein = np.hstack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    assert ((a @ bernstein.T) / (b @ bernstein.T) <= ratio(a, b)[:, None] + 1e-12).all()


def test_beta_that_touches_zero_is_not_certified() -> None:
    touching = TensorBSpline(basis(1), greville(1)[0] + 1.0)  # z + 1, zero on the lower face
    proof = certify(NavigationFunction(SplineObstacle(touching), 5.0), np.array([[0.5]]))
    assert not proof.certified and "not positive" in proof.reason


def flat_then_steep() -> TensorBSpline:
    """Away from a goal on its left, beta grows faster than gamma_d^2."""
    beta = TensorBSpline(basis(1), fitted(lambda z: 0.002 + 10 * np.maximum(z[:, 0], 0) ** 3, 1))
    return TensorBSpline(basis(1), beta.coefficients + 0.05 - beta.coefficients.min())


def test_the_exponent_needed_is_above_the_whole_bracket() -> None:
    lifted = flat_then_steep()
    goal = np.array([[-0.9]])
    exact = certify(NavigationFunction(SplineObstacle(lifted), 9), goal, 1e-6)
    coarse = certify(NavigationFunction(SplineObstacle(lifted), 9), goal, 0.5)
    for proof in (exact, coarse):
        assert proof.supremum is not None and proof.k_min is not None
        assert proof.k_min == max(2.0, proof.supremum.outward + 1e-9)
    assert exact.supremum is not None and coarse.supremum is not None
    assert coarse.supremum.lower <= exact.supremum.lower + 1e-12
    assert exact.supremum.lower <= coarse.supremum.upper <= coarse.supremum.lower + 0.5 + 1e-12
    assert exact.supremum.upper == pytest.approx(exact.supremum.lower, abs=1.1e-6)
    assert coarse.supremum.upper > coarse.supremum.lower + 0.01
    assert coarse.supremum.lower > 2.0


def test_violations_are_the_greatest_on_cells_halved_once() -> None:
    # chi = c |z|^2 / 2, goal at the origin: c |z|^2 grows towards the corner (2, 2, 2).
    chi = TensorBSpline(basis(), fitted(lambda z: 0.05 * np.sum(z**2, axis=1), 3))
    points = violations(chi, np.zeros(3), np.zeros(3), 1.0)
    np.testing.assert_allclose(points[0], [2, 2, 2])
    value = 0.1 * np.sum(points**2, axis=1)
    assert value.min() > 0.9
    assert (np.diff(value) < 0.05).all()  # coefficients are near values
    few = violations(chi, np.zeros(3), np.zeros(3), 1.0, most=5)
    np.testing.assert_array_equal(few, points[:5])
    # Coefficients lie at thirds of half a cell: 3/5, 3/4 and 3/6 wide.
    steps = [np.diff(np.unique(points[:, i].round(9))).min() for i in range(3)]
    np.testing.assert_allclose(steps, np.array([3 / 5, 3 / 4, 3 / 6]) / 6)


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
    lifted = flat_then_steep()
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


@pytest.mark.parametrize("share", [0.01, 0.5, 0.9, 0.999])
def test_violations_are_those_of_all_cells_halved(share: float) -> None:
    """Cells in which there can be none are passed over, and no other."""
    rng = np.random.default_rng(4)
    chi = TensorBSpline(basis(), 0.3 * rng.normal(size=basis().shape))
    low, high = np.full(3, -0.5), np.full(3, 0.7)
    cells = Cells.of(chi).halved()
    coefficients = _descent_coefficients(cells, low, high)
    limit = float(np.quantile(coefficients, share))
    above = np.argwhere(coefficients > limit)
    order = np.argsort(-coefficients[tuple(above.T)], kind="stable")
    cell, place = above[order, 0], above[order, 1:]
    wanted = cells.origin[cell] + cells.size[cell] * place / 3
    assert 0 < len(wanted) < coefficients.size
    np.testing.assert_array_equal(violations(chi, low, high, limit, len(wanted)), wanted)


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


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["chi", "beta", "goal", "k", "metric"])
def test_what_is_no_number_proves_nothing(value: float, where: str) -> None:
    flat, goal, k = np.full(basis(2).shape, 0.1), np.array([[0.1, 0.2]]), 3.0
    metric = DestinationMetric(goal, np.zeros((2, 2, 2)), 1.0)
    if where in ("chi", "beta"):
        flat[2, 3] = value
    elif where == "goal":
        goal = np.array([[0.1, value]])
    elif where == "metric":
        metric = DestinationMetric(metric.centres, np.full((2, 2, 2), value), 1.0)
    chi = TensorBSpline(basis(2), flat)
    obstacle = SplineObstacle(chi) if where == "beta" else ExponentialObstacle(chi, np.full(2, 0.2))
    navigation = NavigationFunction(obstacle, k, None if where == "beta" else metric)
    if where == "k":
        object.__setattr__(navigation, "k", value)
    proof = certify(navigation, goal)
    assert not proof.certified and "not finite" in proof.reason


def test_a_spline_beta_with_a_metric_is_not_certified() -> None:
    """Its workspace is not closed, and paths that curve as the metric says leave it."""
    metric = DestinationMetric(
        np.zeros((1, 2)), np.stack([np.diag([0.0, 3.0]), np.zeros((2, 2))]), 1.0
    )
    flat = SplineObstacle(TensorBSpline(basis(2), np.full(basis(2).shape, 1.7)))
    proof = certify(NavigationFunction(flat, 3, metric), np.array([[0.1, 0.2]]))
    assert not proof.certified and "metric" in proof.reason


def rising_along_a_face(height: float, face: int) -> TensorBSpline:
    """beta that rises steeply outwards on a face of the first dimension, 0 or -1."""
    coefficients = np.ones(basis(2).shape)
    coefficients[face] = height
    return TensorBSpline(basis(2), coefficients)


@pytest.mark.parametrize("height", [1.5, 3.0, 6.0, 10.0])
@pytest.mark.parametrize("face", [0, -1])
def test_paths_of_a_spline_beta_must_not_leave_the_workspace(height: float, face: int) -> None:
    """Against a fine sample of the faces: no exponent below the least that keeps paths inside."""
    beta, goal = rising_along_a_face(height, face), np.array([[0.3, 0.2]])
    k_min = certify(NavigationFunction(SplineObstacle(beta), 2.0), goal).k_min
    assert k_min is not None
    x, outwards = (beta.basis.lower[0], -1) if face == 0 else (beta.basis.upper[0], 1)
    y = np.linspace(beta.basis.lower[1], beta.basis.upper[1], 400)
    z = np.column_stack([np.full_like(y, x), y])
    value, gradient, _ = beta.jets(z, 1)
    away = z - goal[0]
    needed = outwards * gradient[:, 0] * (away**2).sum(axis=1) / (2 * value * outwards * away[:, 0])
    assert needed.max() > 0
    assert k_min >= needed.max()
    outward = NavigationFunction(SplineObstacle(beta), max(2.0, 0.9 * needed.max()))
    if needed.max() > 2.3:
        velocity = outward.directions(z, np.tile(goal, (len(z), 1)))
        assert (outwards * velocity[:, 0] > 0).any()
    inward = NavigationFunction(SplineObstacle(beta), k_min)
    velocity = inward.directions(z, np.tile(goal, (len(z), 1)))
    assert (outwards * velocity[:, 0] <= 0).all()


@pytest.mark.parametrize("excess", [1e-9, 1e-8, 1e-6, 1e-4, 1e-3])
@pytest.mark.parametrize("seed", range(5))
def test_violations_however_small_are_not_certified(seed: int, excess: float) -> None:
    chi, goal = random_chi(2, seed), np.array([[0.1, 0.2]])
    attained = descent_supremum(chi, goal[0], goal[0], 1e-11).lower
    scaled = TensorBSpline(basis(2), (2.0 + excess) / attained * chi.coefficients)
    assert not certify(exponential(scaled), goal, 1e-11).certified
    assert not certify(exponential(scaled), goal).certified

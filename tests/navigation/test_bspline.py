"""Tensor B-splines against scipy, finite differences and the properties they must have."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.interpolate import BSpline, NdBSpline

from handsim.errors import InputError
from handsim.navigation import _spline_evaluator
from handsim.navigation._spline_evaluator import SplineEvaluator
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.knots import KnotAxis

SHAPES = {1: (9,), 2: (9, 8), 3: (7, 6, 8), 4: (6, 5, 7, 6), 5: (6, 5, 5, 6, 5)}


def random_spline(n: int, degree: int = 3, seed: int = 0) -> TensorBSpline:
    basis = TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), SHAPES[n], degree)
    return TensorBSpline(basis, np.random.default_rng(seed).normal(size=SHAPES[n]))


def points_in(spline: TensorBSpline, count: int = 40) -> np.ndarray:
    low, high = spline.basis.lower, spline.basis.upper
    return np.random.default_rng(1).uniform(low, high, (count, len(low)))


@pytest.mark.parametrize("n", SHAPES)
@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_values_and_derivatives_agree_with_scipy(n: int, degree: int) -> None:
    spline = random_spline(n, degree)
    points = points_in(spline)
    reference = NdBSpline(spline.basis.knots, spline.coefficients, degree)
    value, gradient, hessian = spline.jets(points, 2)
    unit = np.eye(n, dtype=int)
    np.testing.assert_allclose(value, reference(points), atol=1e-12)
    for i in range(n):
        np.testing.assert_allclose(gradient[:, i], reference(points, nu=unit[i]), atol=1e-11)
        for j in range(n):
            second = reference(points, nu=unit[i] + unit[j])
            np.testing.assert_allclose(hessian[:, i, j], second, atol=1e-10)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("kind", ["even", "uneven", "repeated"])
def test_pieces_on_any_knots_are_those_of_scipy(degree: int, kind: str) -> None:
    inner = np.sort(np.random.default_rng(degree).normal(size=9))
    knots = {
        "even": 0.3 + 0.7 * np.arange(9 + 2 * degree),
        "uneven": np.concatenate([inner, inner[-1] + np.arange(1.0, 2 * degree + 1)]),
        "repeated": np.concatenate(
            [[inner[0]] * degree, inner[:4], inner[3:], [inner[-1]] * degree]
        ),
    }[kind]
    axis = KnotAxis.of(knots, degree)
    assert axis.even == (kind == "even")
    every = BSpline(knots, np.eye(axis.n_basis), degree)
    middles = 0.5 * (axis.breaks[1:] + axis.breaks[:-1])
    first, values = axis.at_all(middles, 2)
    for derivative in range(3):
        reference = every(middles, nu=derivative) if derivative <= degree else 0.0 * every(middles)
        for i, begins in enumerate(first):
            found = np.zeros(axis.n_basis)
            found[begins : begins + degree + 1] = values[derivative, :, i]
            np.testing.assert_allclose(
                found, reference[i], atol=1e-9 * np.abs(reference).max() + 1e-15
            )


@pytest.mark.parametrize("n", SHAPES)
@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_one_point_and_many_points_agree(n: int, degree: int) -> None:
    spline = random_spline(n, degree)
    outside = spline.basis.upper + 0.1 * np.arange(n)
    points = np.vstack([points_in(spline, 15), spline.basis.lower, spline.basis.upper, outside])
    many = spline.jets(points, 2)
    for i, point in enumerate(points):
        for one, batch in zip(spline.jet(point, 2), many, strict=True):
            np.testing.assert_allclose(one, batch[i], atol=1e-10)


def test_one_evaluator_serves_all_points() -> None:
    spline = random_spline(3)
    evaluators = [SplineEvaluator(spline, order) for order in range(3)]
    for point in points_in(spline):
        value, gradient, hessian = spline.jet(point, 2)
        parts = [value, *gradient, *hessian.ravel()]
        for evaluate, count in zip(evaluators, (1, 4, 13), strict=True):
            np.testing.assert_allclose(evaluate(point.tolist()), parts[:count], rtol=1e-9)
            assert evaluate(point.tolist()) is evaluate(point.tolist())  # no new array


def test_uneven_cells_have_tables_of_their_own() -> None:
    basis = TensorBasis(
        (np.array([0, 0, 0, 0, 0.3, 0.35, 1.1, 2, 2, 2, 2.0]), np.arange(12) ** 1.3)
    )
    spline = TensorBSpline(basis, np.random.default_rng(4).normal(size=basis.shape))
    points = points_in(spline, 60)
    many = spline.jets(points, 1)
    for i, point in enumerate(points):
        value, gradient, _ = spline.jet(point, 1)
        assert value == pytest.approx(many[0][i])
        np.testing.assert_allclose(gradient, many[1][i], atol=1e-9)
    assert 10 < len(spline.tables[1]) <= 20  # of 4 x 5 cells


def test_tables_of_cells_are_bounded_and_left_out_of_pickles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spline = random_spline(2)
    monkeypatch.setattr(_spline_evaluator, "_MAX_TABLED", 3 * 48)
    points = points_in(spline, 60)
    empty = len(pickle.dumps(spline))
    values = spline.jets(points, 1)[0]
    for point, value in zip(points, values, strict=True):
        assert spline.jet(point, 1)[0] == pytest.approx(value)
        assert 1 <= len(spline.tables[1]) <= 3
    copy = pickle.loads(pickle.dumps(spline))
    assert len(spline.tables[1]) > 1 and len(pickle.dumps(spline)) == empty
    np.testing.assert_array_equal(copy.coefficients, spline.coefficients)
    assert copy.jet(points[0], 1)[0] == spline.jet(points[0], 1)[0]


def test_chunks_and_threads_do_not_meet_in_scratch_space() -> None:
    spline = random_spline(3)
    points = [points_in(spline, count) for count in (1, 2047, 2048, 2049, 5000)] * 6
    alone = [[spline.jet(z, 1)[:2] for z in batch[:: len(batch) // 3 + 1]] for batch in points]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda batch: spline.jets(batch, 1), points))
    for batch, one, (values, gradients, _) in zip(points, alone, together, strict=True):
        every = len(batch) // 3 + 1
        np.testing.assert_allclose(values[::every], [value for value, _ in one], atol=1e-12)
        np.testing.assert_allclose(gradients[::every], [g for _, g in one], atol=1e-10)


def test_uneven_and_clamped_knots() -> None:
    knots = np.array([0, 0, 0, 0, 0.3, 0.35, 1.1, 2, 2, 2, 2.0])
    basis = TensorBasis((knots, np.linspace(-3, 4, 12)))
    assert basis.shape == (7, 8)
    np.testing.assert_allclose(basis.lower, [0, knots_at(basis, 1, 3)])
    spline = TensorBSpline(basis, np.random.default_rng(2).normal(size=basis.shape))
    points = points_in(spline)
    reference = NdBSpline(basis.knots, spline.coefficients, 3)
    np.testing.assert_allclose(spline.jets(points, 0)[0], reference(points), atol=1e-12)
    np.testing.assert_allclose(spline.jets(points, 1)[1][:, 0], reference(points, nu=[1, 0]))


def knots_at(basis: TensorBasis, axis: int, index: int) -> float:
    return float(basis.knots[axis][index])


def test_gradient_and_hessian_by_finite_differences() -> None:
    spline = random_spline(3)
    points = 0.9 * points_in(spline)
    step = 1e-5
    for i, unit in enumerate(np.eye(3)):
        ahead, behind = (spline.jets(points + s * step * unit, 1) for s in (1, -1))
        _, gradient, hessian = spline.jets(points, 2)
        np.testing.assert_allclose(
            (ahead[0] - behind[0]) / (2 * step), gradient[:, i], rtol=1e-6, atol=1e-7
        )
        np.testing.assert_allclose(
            (ahead[1] - behind[1]) / (2 * step), hessian[:, i], rtol=1e-6, atol=1e-6
        )


def test_splines_sum_to_one_and_reproduce_lines() -> None:
    basis = TensorBasis.uniform([-1.0, 0.0], [2.0, 5.0], (8, 7))
    points = points_in(TensorBSpline(basis, np.zeros(basis.shape)))
    assert np.allclose(TensorBSpline(basis, np.ones(basis.shape)).jets(points, 0)[0], 1.0)
    # Coefficients at the Greville abscissae (means of 3 inner knots) give the identity.
    greville = np.array([basis.knots[1][i + 1 : i + 4].mean() for i in range(7)])
    line = TensorBSpline(basis, np.tile(greville, (8, 1)))
    value, gradient, hessian = line.jets(points, 2)
    np.testing.assert_allclose(value, points[:, 1], atol=1e-12)
    np.testing.assert_allclose(gradient, np.tile([0.0, 1.0], (len(points), 1)), atol=1e-12)
    np.testing.assert_allclose(hessian, 0.0, atol=1e-10)


def test_support_is_local() -> None:
    basis = TensorBasis.uniform([0.0, 0.0], [7.0, 6.0], (10, 9))
    coefficients = np.zeros(basis.shape)
    coefficients[5, 4] = 1.0  # lives on 2 < x < 6, 1 < y < 5
    spline = TensorBSpline(basis, coefficients)
    points = np.random.default_rng(3).uniform([0, 0], [7, 6], (500, 2))
    inside = (points > [2, 1]).all(1) & (points < [6, 5]).all(1)
    assert 100 < inside.sum() < 400
    assert (spline.jets(points, 0)[0][inside] > 0).all()
    assert (spline.jets(points, 0)[0][~inside] == 0).all()


def test_outside_the_domain_the_nearest_point_counts() -> None:
    spline = random_spline(2)
    np.testing.assert_array_equal(
        spline.jets(np.array([[5.0, 0.5]]), 2)[1], spline.jets(np.array([[2.0, 0.5]]), 2)[1]
    )


def test_bad_bases() -> None:
    for make, word in (
        (lambda: TensorBasis(()), "0 dimensions"),
        (lambda: TensorBasis.uniform([0.0] * 6, [1.0] * 6, (5,) * 6), "6 dimensions"),
        (lambda: TensorBasis.uniform([0.0], [1.0], (3,)), "at least 4"),
        (lambda: TensorBasis((np.array([0, 1, 2, 3, 2, 5, 6, 7.0]),)), "increasing"),
        (lambda: TensorBasis.uniform([0.0], [1.0], (8,), 0), "degree 0"),
        (lambda: TensorBSpline(TensorBasis.uniform([0.0], [1.0], (8,)), np.zeros(7)), "7 coeff"),
    ):
        with pytest.raises(InputError, match=word):
            make()

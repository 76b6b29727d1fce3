"""Bernstein coefficients of products and derivatives, against the functions themselves."""

from math import comb

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from handsim.navigation._bernstein import Cells
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.proof.polynomials import gradients, linear, quadratic, times
from handsim.navigation.proof.separation import separable, steepest


def cells_of(n: int, seed: int) -> tuple[TensorBSpline, Cells]:
    basis = TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), (6, 5, 7)[:n])
    chi = TensorBSpline(basis, np.random.default_rng(seed).normal(size=basis.shape))
    return chi, Cells.of(chi)


def value(coefficients: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Values of polynomials (..., d + 1, ...) at one point u (n,) of the unit box."""
    for x in u[::-1]:
        d = coefficients.shape[-1] - 1
        weights = np.array([comb(d, i) * x**i * (1 - x) ** (d - i) for i in range(d + 1)])
        coefficients = coefficients @ weights
    return coefficients


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_polynomials_are_what_they_stand_for(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    chi, cells = cells_of(n, seed)
    goal, half = rng.normal(size=n), rng.normal(size=(n, n))
    matrix = half @ half.T
    slopes = gradients(cells.coefficients, cells.size)
    field = times(slopes, quadratic(cells, matrix, goal), n)
    assert field.shape == (len(cells.origin), n, *(6,) * n)
    for u in rng.random((5, n)):
        z = cells.origin + cells.size * u
        away = z - goal
        gradient = chi.jets(z, 1)[1]
        np.testing.assert_allclose(value(slopes, u), gradient, atol=1e-12)
        np.testing.assert_allclose(
            value(linear(cells, half, goal, 5), u), away @ half.T, atol=1e-12
        )
        gamma = np.einsum("ni,ij,nj->n", away, matrix, away)
        np.testing.assert_allclose(
            value(quadratic(cells, matrix, goal), u)[:, 0], gamma, atol=1e-11
        )
        np.testing.assert_allclose(value(field, u), gamma[:, None] * gradient, atol=1e-10)


def test_derivatives_of_a_spline_agree_with_another_implementation() -> None:
    chi, cells = cells_of(2, 5)
    other = NdBSpline(chi.basis.knots, chi.coefficients, 3)
    slopes = gradients(cells.coefficients, cells.size)
    z = cells.origin + 0.25 * cells.size
    for i, order in enumerate(np.eye(2, dtype=int)):
        expected = other(z, nu=order)
        np.testing.assert_allclose(value(slopes[:, i], np.full(2, 0.25)), expected, atol=1e-12)


def test_vectors_on_one_side_are_separated_and_others_are_not() -> None:
    rng = np.random.default_rng(0)
    free, none = np.full((200, 3), -np.inf), np.full((200, 3), np.inf)
    side = rng.normal(size=(200, 3, 1))
    vectors = rng.normal(size=(200, 3, 20))
    onto = (vectors * side).sum(axis=1)
    one_sided = vectors * np.where(onto > 0, 1.0, -1.0)[:, None] + 0.3 * side
    assert separable(one_sided, free, none, np.zeros(200)).mean() > 0.9
    both = np.concatenate([one_sided, -one_sided[:, :, :1]], axis=2)
    assert not separable(both, free, none, np.zeros(200)).any()
    with_zero = np.concatenate([one_sided, np.zeros((200, 3, 1))], axis=2)
    assert not separable(with_zero, free, none, np.zeros(200)).any()


def test_directions_keep_to_their_bounds_and_levels() -> None:
    vectors = np.array([[[-1.0, -1.0], [0.2, 0.3]]])
    free, none = np.full((1, 2), -np.inf), np.full((1, 2), np.inf)
    zero = np.zeros((1, 2))
    assert separable(vectors, free, none, np.zeros(1))
    assert separable(vectors, np.array([[0.0, -np.inf]]), none, np.zeros(1))  # (0, 1) is left
    assert not separable(vectors, zero, np.array([[np.inf, 0.0]]), np.zeros(1))
    assert separable(vectors, free, none, np.array([0.9]))
    assert not separable(vectors, free, none, np.array([1.1]))  # no vector is longer
    assert not separable(np.full((1, 2, 3), np.nan), free, none, np.zeros(1))


def test_steepest_directions_are_eigenvectors() -> None:
    rng = np.random.default_rng(1)
    matrices = rng.normal(size=(300, 3, 3))
    matrices = matrices + np.swapaxes(matrices, 1, 2)
    values = np.linalg.eigvalsh(matrices)
    apart = values[:, 2] - values[:, 1] > 0.1 * np.abs(values).max(axis=1)
    e = steepest(matrices)
    np.testing.assert_allclose(np.linalg.norm(e, axis=1), 1.0)
    bend = np.einsum("ni,nij,nj->n", e, matrices, e)
    np.testing.assert_allclose(bend[apart], values[apart, 2], rtol=1e-2, atol=1e-2)


def test_directions_are_turned_towards_the_vector_served_worst() -> None:
    """Nineteen agree and outvote one that the mean does not serve."""
    vectors = np.tile([[1.0], [0.05]], (1, 1, 20))
    vectors[0, :, 7] = [-0.9, 0.4]
    free, none = np.full((1, 2), -np.inf), np.full((1, 2), np.inf)
    assert vectors[0].mean(axis=1) @ vectors[0, :, 7] < 0
    assert separable(vectors, free, none, np.zeros(1))

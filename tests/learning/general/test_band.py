"""Penalised least squares in bands, against dense ones."""

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from handsim.learning.general.band import BandMatrix, fitted_coefficients
from handsim.navigation.bspline import TensorBasis, TensorBSpline


@pytest.mark.parametrize("width", [0, 1, 3, 11])
def test_bands_are_solved_as_dense_matrices_are(width: int) -> None:
    rng = np.random.default_rng(width)
    band = BandMatrix(12, width)
    for _ in range(40):
        i = rng.integers(12, size=2)
        if abs(i[0] - i[1]) <= width:
            both = np.concatenate([i, i[::-1]])
            value = rng.normal()
            band.add(both, both[[1, 0, 3, 2]], np.full(4, 0.5 * value))
    band.add(np.arange(12), np.arange(12), np.full(12, 10.0))
    dense = np.zeros((12, 12))
    for i in range(12):
        for j in range(12):
            if abs(i - j) <= width:
                dense[i, j] = band.rows[i, width + j - i]
    np.testing.assert_array_equal(dense, dense.T)
    right = rng.normal(size=12)
    np.testing.assert_allclose(band.solved(right), np.linalg.solve(dense, right), rtol=1e-12)


@pytest.mark.parametrize("shape", [(9,), (7, 6), (5, 6, 5)])
def test_fits_are_those_of_dense_normal_equations(shape: tuple[int, ...]) -> None:
    rng, n = np.random.default_rng(len(shape)), len(shape)
    basis = TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), shape)
    z, values, weights = rng.uniform(-1, 2, (60, n)), rng.normal(size=60), rng.random(60)
    bend, slope = 0.03, 0.01
    found = fitted_coefficients(basis, z, values, weights, bend, slope)

    design = np.stack(
        [TensorBSpline(basis, row).jets(z, 0)[0] for row in np.eye(basis.n_coefficients)], axis=1
    )
    penalty = 1e-10 * np.eye(basis.n_coefficients)
    for axis in range(n):
        for order, weight in ((2, bend), (1, slope)):
            each = np.diff(np.eye(basis.n_coefficients).reshape(-1, *shape), order, axis=axis + 1)
            each = each.reshape(basis.n_coefficients, -1)
            penalty += weight * each @ each.T
    normal = design.T @ (weights[:, None] * design) + penalty
    expected = np.linalg.solve(normal, design.T @ (weights * values))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_enough_values_are_met() -> None:
    basis = TensorBasis.uniform(np.zeros(2), np.ones(2), (8, 8))
    axes = np.linspace(0, 1, 20)
    z = np.stack(np.meshgrid(axes, axes, indexing="ij"), -1).reshape(-1, 2)
    values = np.sin(3 * z[:, 0]) * z[:, 1] ** 2
    c = fitted_coefficients(basis, z, values, np.ones(len(z)), 1e-9, 0.0)
    near = NdBSpline(basis.knots, c.reshape(8, 8), 3)(z)
    assert np.abs(near - values).max() < 2e-3

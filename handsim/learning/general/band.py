"""Penalised least squares for the coefficients of a spline, in reproducible arithmetic.

The normal matrix of a tensor-product spline is a band: coefficients more than a few cells apart
never meet. Its Cholesky factor is a band as well. LAPACK has both, but not with the same bits
everywhere (`handsim.reproducible`).
"""

from math import prod

import numpy as np
from numpy.lib.stride_tricks import as_strided

from handsim.navigation.bspline import TensorBasis
from handsim.reproducible import dot
from handsim.types import Array, Index

_AT_ONCE = 2**21  # products of basis functions held together (16 MiB)


class BandMatrix:
    """A symmetric matrix whose entries vanish farther than ``width`` from its diagonal.

    Entry (i, j) is at [i, width + j - i].
    """

    def __init__(self, size: int, width: int) -> None:
        self.size, self.width = size, width
        self.rows = np.zeros((size, 2 * width + 1))

    def add(self, i: Index, j: Index, values: Array) -> None:
        """Add values at places, which may repeat."""
        place = i * self.rows.shape[1] + self.width + j - i
        counts = np.bincount(place.ravel(), values.ravel(), minlength=self.rows.size)
        self.rows += counts.reshape(self.rows.shape)

    def add_differences(self, shape: tuple[int, ...], stencil: Array, weight: float) -> None:
        """Add weight times the squares of a stencil applied to coefficients along each axis."""
        number = np.arange(self.size).reshape(shape)
        for axis in range(len(shape)):
            along = np.moveaxis(number, axis, 0)
            last = len(along) - len(stencil) + 1
            parts = [along[i : i + last].ravel() for i in range(len(stencil))]
            for a, i in zip(stencil, parts, strict=True):
                for b, j in zip(stencil, parts, strict=True):
                    self.rows[i, self.width + j - i] += weight * a * b

    def solved(self, right: Array) -> Array:
        """Return x of matrix x = right, the matrix being positive definite.

        It is replaced by its Cholesky factor.
        """
        width, x = self.width, np.array(right, dtype=float)
        wide = np.pad(self.rows, ((0, width), (0, 0)))
        step = wide.strides[1]
        for i in range(self.size):
            row = wide[i, width:]
            row /= np.sqrt(row[0])
            x[i] /= row[0]
            # Entry (i + 1 + a, i + 1 + b) of the matrix: rows are shifted against each other.
            corner = wide[i + 1 :, width:]
            block = as_strided(corner, (width, width), ((2 * width) * step, step))
            block -= row[1:, None] * row[None, 1:]
            end = min(width, self.size - 1 - i)
            x[i + 1 : i + 1 + end] -= row[1 : 1 + end] * x[i]
        for i in range(self.size - 1, -1, -1):
            end = min(width, self.size - 1 - i)
            row = wide[i, width:]
            x[i] = (x[i] - dot(row[1 : 1 + end], x[i + 1 : i + 1 + end])) / row[0]
        return x


def fitted_coefficients(
    basis: TensorBasis, points: Array, values: Array, weights: Array, bend: float, slope: float
) -> Array:
    """Return coefficients c (prod(m_i),) of the spline nearest to values at points.

    They minimise

        sum weights (spline - values)^2 + bend |second differences of c|^2
        + slope |first differences of c|^2 + 1e-10 |c|^2.

    Parameters
    ----------
    basis
    points : (N, n)
    values, weights : (N,)
    bend, slope
        The second spreads what is known as a membrane does: without bumps of its own.
    """
    strides = [prod(basis.shape[i + 1 :]) for i in range(len(basis.shape))]
    width = basis.degree * sum(strides)
    matrix = BandMatrix(basis.n_coefficients, width)
    right = np.zeros(basis.n_coefficients)
    n_local = len(basis.patch)
    chunk = max(_AT_ONCE // n_local**2, 1)
    for first in range(0, len(points), chunk):
        part = slice(first, first + chunk)
        where, functions = _functions(basis, points[part])
        weighted = functions * weights[part]
        shape = (n_local, n_local, len(weights[part]))
        i = np.broadcast_to(where[:, None], shape)
        j = np.broadcast_to(where[None], shape)
        matrix.add(i, j, weighted[:, None] * functions[None])
        right += np.bincount(where.ravel(), (weighted * values[part]).ravel(), minlength=len(right))
    matrix.add_differences(basis.shape, np.array([1.0, -2.0, 1.0]), bend)
    matrix.add_differences(basis.shape, np.array([-1.0, 1.0]), slope)
    matrix.rows[:, width] += 1e-10
    return matrix.solved(right)


def _functions(basis: TensorBasis, points: Array) -> tuple[Index, Array]:
    """Return which basis functions are not zero at points and their values, (local, N) each."""
    corner = np.zeros(len(points), dtype=np.int64)
    values = np.ones((1, len(points)))
    for axis, m, x in zip(basis.axes, basis.shape, points.T, strict=True):
        first, local = axis.at_all(x, 0)
        corner = corner * m + first
        values = (values[:, None] * local[0][None]).reshape(-1, len(points))
    return basis.patch + corner, values

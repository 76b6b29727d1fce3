"""Splines at fixed points as a linear function of their coefficients, there and back.

A sparse matrix would hold the same function. But products with sparse matrices are compiled, and
the compiler decides whether a product and a sum are rounded once or twice. Here each step is one
array operation (`reproducible`), dimension by dimension, which is also less work than all
products of basis functions.
"""

import numpy as np
import numpy.typing as npt

from handsim.navigation.bspline import TensorBasis
from handsim.types import Array, Index

_CHUNK = 2**16  # coefficients gathered at once (512 KiB), so that they stay in cache


class JetDesign:
    """Values and gradients of a spline at points, as a linear function of its coefficients.

    Parameters
    ----------
    basis
    points : (N, n)
    """

    def __init__(self, basis: TensorBasis, points: Array) -> None:
        self._basis, self.n_points = basis, len(points)
        self._chunk = max(_CHUNK // (basis.degree + 1) ** points.shape[1], 16)
        axes = zip(basis.axes, basis.shape, points.T, strict=True)
        corner = np.zeros(len(points), dtype=np.int64)
        self._local: list[Array] = []  # (2, degree + 1, N): basis functions and their slopes
        for axis, m, x in axes:
            first, values = axis.at_all(x, 1)
            corner = corner * m + first
            self._local.append(np.ascontiguousarray(values))
        self._corner: Index = corner

    def taken(self, which: npt.NDArray[np.int64]) -> "JetDesign":
        """Return the design of some of the points."""
        part = object.__new__(JetDesign)
        part._basis, part._chunk, part.n_points = self._basis, self._chunk, len(which)
        part._local = [values[:, :, which] for values in self._local]
        part._corner = self._corner[which]
        return part

    def __call__(self, c: Array) -> tuple[Array, Array]:
        """Return values (N,) and gradients (n, N) of the spline of coefficients (prod(m_i),)."""
        n = len(self._local)
        jets = np.empty((n + 1, self.n_points))
        for part in self._parts():
            patch = c.take(self._basis.patch + self._corner[part])
            rows = [patch]  # value, then the slopes along the dimensions summed over
            for values in self._local:
                basis, slopes = values[:, :, part]
                rows.append(_contracted(rows[0], slopes))
                rows[:-1] = [_contracted(row, basis) for row in rows[:-1]]
            for i, row in enumerate(rows):
                jets[i, part] = row[0]
        return jets[0], jets[1:]

    def pulled_back(self, by_value: Array | None, by_gradient: Array | None = None) -> Array:
        """Return a function's slope by the coefficients from those by values and gradients.

        Parameters
        ----------
        by_value : (N,), or None for 0
        by_gradient : (n, N), or None for 0

        Returns
        -------
        (prod(m_i),)
        """
        result = np.zeros(self._basis.n_coefficients)
        for part in self._parts():
            slopes = [] if by_gradient is None else [row[part][None] for row in by_gradient]
            whole = np.zeros_like(self._local[0][0, :1, part])
            if by_value is not None:
                whole = by_value[part][None]
            for values in reversed(self._local):
                basis, by_slope = values[:, :, part]
                whole = _spread(whole, basis)
                if slopes:
                    whole += _spread(slopes.pop(), by_slope)
                slopes = [_spread(row, basis) for row in slopes]
            where = (self._basis.patch + self._corner[part]).ravel()
            result += np.bincount(where, whole.ravel(), minlength=len(result))
        return result

    def _parts(self) -> list[slice]:
        return [slice(i, i + self._chunk) for i in range(0, self.n_points, self._chunk)]


def _contracted(patch: Array, weights: Array) -> Array:
    """Sum over the slowest dimension of patches (width * m, N) by weights (width, N): (m, N)."""
    rows = patch.reshape(len(weights), -1, patch.shape[1])
    result = rows[0] * weights[0]
    for row, weight in zip(rows[1:], weights[1:], strict=True):
        result += row * weight
    return result


def _spread(patch: Array, weights: Array) -> Array:
    """Transpose of `_contracted`: (m, N) to (width * m, N)."""
    return (weights[:, None] * patch).reshape(-1, patch.shape[1])

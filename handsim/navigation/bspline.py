"""Tensor-product B-splines in 1 to 5 dimensions: values and derivatives.

The obstacle is sought in the space of Eq. (9) of the paper, beta(z) = sum c_{i1..in} prod_r
B_{ir}(z_r), C^2 for cubic splines (order 4) and above. The paper stacks the coefficients into a
vector of sum(m_i) entries; there are prod(m_i), stacked here in C order.
"""

import threading
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.navigation._spline_evaluator import SplineEvaluator, derivative_index
from handsim.navigation.knots import KnotAxis
from handsim.types import Array, Index
from handsim.wording import number_of

MAX_DIMENSIONS = 5
_CHUNK = 2**17  # coefficients gathered at once (1 MiB), so that they stay in cache


@dataclass(frozen=True)
class TensorBasis:
    """The functions of a tensor-product B-spline space.

    Parameters
    ----------
    knots
        For each dimension the knots, ends repeated or not; the domain runs from knot ``degree``
        to knot ``-degree - 1``. Points outside are evaluated at the nearest point of the domain.
    degree
        Polynomial degree, the order of the paper less one; 3 or more for the C^2 of Eq. (9).

    Raises
    ------
    InputError
        If there are not 1 to 5 dimensions, or too few or decreasing knots.
    """

    knots: tuple[Array, ...]
    degree: int = 3

    def __post_init__(self) -> None:
        """Check the dimensions; the knots are checked where each axis is built."""
        if not 1 <= len(self.knots) <= MAX_DIMENSIONS:
            raise InputError(
                f"{number_of(len(self.knots), 'dimension')}; a basis has 1 to {MAX_DIMENSIONS}"
            )
        if self.degree < 1:
            raise InputError(f"degree {self.degree}; give at least 1, or 3 for two derivatives")
        object.__setattr__(self, "knots", tuple(axis.knots for axis in self.axes))

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave out of pickles what is made again on demand."""
        return TensorBasis, (self.knots, self.degree)

    @classmethod
    def uniform(
        cls, lower: npt.ArrayLike, upper: npt.ArrayLike, shape: tuple[int, ...], degree: int = 3
    ) -> "TensorBasis":
        """Lay equally spaced knots on a box, with ``shape`` basis functions per dimension."""
        low, high = np.atleast_1d(lower).astype(float), np.atleast_1d(upper).astype(float)
        if min(shape) <= degree:
            raise InputError(f"shape {shape}; degree {degree} needs at least {degree + 1} each")
        knots: list[Array] = []
        for a, b, m in zip(low, high, shape, strict=True):
            step = (b - a) / (m - degree)
            knots.append(a + step * np.arange(-degree, m + 1))
        return cls(tuple(knots), degree)

    @cached_property
    def axes(self) -> tuple[KnotAxis, ...]:
        """The dimensions, ready for evaluation."""
        return tuple(KnotAxis.of(knots, self.degree) for knots in self.knots)

    @cached_property
    def cells(self) -> tuple[tuple[list[float], list[float], float, float, int], ...]:
        """Inner and all breaks, ends and number of cells along each dimension, as plain floats."""
        every = [axis.breaks.tolist() for axis in self.axes]
        return tuple((b[1:-1], b, b[0], b[-1], len(b) - 1) for b in every)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Numbers of basis functions, one a dimension."""
        return tuple(axis.n_basis for axis in self.axes)

    @cached_property
    def patch(self) -> Index:
        """Places of the (degree + 1)**n coefficients of a cell after the first, as a column."""
        offset = np.zeros(1, dtype=np.int64)
        for m in self.shape:
            offset = (offset[:, None] * m + np.arange(self.degree + 1)).ravel()
        return offset[:, None]

    @property
    def n_coefficients(self) -> int:
        """The product of `shape`."""
        return prod(self.shape)

    @property
    def lower(self) -> Array:
        """Lower corner of the domain, (n,)."""
        return np.array([axis.breaks[0] for axis in self.axes])

    @property
    def upper(self) -> Array:
        """Upper corner of the domain, (n,)."""
        return np.array([axis.breaks[-1] for axis in self.axes])


@dataclass(frozen=True)
class TensorBSpline:
    """A function in the span of a `TensorBasis`.

    Parameters
    ----------
    basis
    coefficients
        Array of the basis' shape, or its C-order stack.
    """

    basis: TensorBasis
    coefficients: Array

    def __post_init__(self) -> None:
        """Bring the coefficients to the shape of the basis and make them read-only."""
        c = np.array(self.coefficients, dtype=float)
        if c.size != self.basis.n_coefficients:
            raise InputError(
                f"{number_of(c.size, 'coefficient')} for a basis of "
                f"{self.basis.n_coefficients}; give as many"
            )
        c = c.reshape(self.basis.shape)
        c.flags.writeable = False
        object.__setattr__(self, "coefficients", c)

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave out of pickles what is made again on demand."""
        return TensorBSpline, (self.basis, self.coefficients)

    @cached_property
    def tables(self) -> tuple[dict[int, Array], ...]:
        """Polynomials of the cells visited, for each order; see `SplineEvaluator`."""
        return {}, {}, {}

    def jet(self, point: Array, order: int) -> tuple[float, Array, Array]:
        """Return value, gradient (n,) and Hessian (n, n) at one point.

        Derivatives above ``order`` (0 to 2) are left as empty arrays.
        """
        n = len(point)
        parts = SplineEvaluator(self, order)(point.tolist())
        return (
            float(parts[0]),
            parts[1 : n + 1] if order >= 1 else np.empty(0),
            parts[n + 1 :].reshape(n, n) if order >= 2 else np.empty((0, 0)),
        )

    def jets(self, points: Array, order: int) -> tuple[Array, Array, Array]:
        """Return values (N,), gradients (N, n) and Hessians (N, n, n) at points (N, n)."""
        n_points, n = points.shape
        values = np.empty(n_points)
        gradients = np.empty((n_points, n) if order >= 1 else (n_points, 0))
        hessians = np.empty((n_points, n, n) if order >= 2 else (n_points, 0, 0))
        index = derivative_index(n)
        chunk = max(_CHUNK // (self.basis.degree + 1) ** n, 16)
        for start in range(0, n_points, chunk):
            part = slice(start, start + chunk)
            tables = self._tables(points[part], order)
            values[part] = tables[(0,) * n]
            if order >= 1:
                gradients[part] = tables[index[0]].T
            if order >= 2:
                hessians[part] = np.moveaxis(tables[index[1]], -1, 0)
        return values, gradients, hessians

    def _tables(self, points: Array, order: int) -> Array:
        """All mixed derivatives up to ``order`` in each dimension, (order + 1, ..., N).

        They lie in scratch space: the next call overwrites them.
        """
        basis, width, n_points = self.basis, self.basis.degree + 1, len(points)
        local = [axis.at_all(x, order) for axis, x in zip(basis.axes, points.T, strict=True)]
        n = len(local)
        # Numbers a point before the first and after each dimension is summed over.
        sizes = [width ** (n - done) * (order + 1) ** done for done in range(n + 1)]
        here, there, *spare = _scratch.arrays(max(sizes) * n_points)
        corner = local[0][0]
        for (first, _), m in zip(local[1:], basis.shape[1:], strict=True):
            corner = corner * m + first
        where = here[: sizes[0] * n_points].view(np.int64).reshape(-1, n_points)
        np.add(basis.patch, corner, out=where)
        patch = there[: where.size].reshape(where.shape)
        np.take(self.coefficients.ravel(), where, out=patch, mode="clip")  # "raise" would copy
        for (_, values), size in zip(local, sizes[1:], strict=True):
            patch = patch.reshape(width, -1, n_points)
            contracted = here[: size * n_points].reshape(-1, order + 1, n_points)
            total, term = (s[: patch[0].size].reshape(patch[0].shape) for s in spare)
            for derivative in range(order + 1):
                np.multiply(patch[0], values[derivative, 0], out=total)
                for i in range(1, width):
                    np.multiply(patch[i], values[derivative, i], out=term)
                    total += term
                contracted[:, derivative] = total
            patch, here, there = contracted, there, here
        return patch.reshape((order + 1,) * n + (n_points,))


class _Scratch(threading.local):
    """Arrays kept by each thread for the next chunk: fresh pages cost a third of the time."""

    def __init__(self) -> None:
        self._kept = np.empty((4, 0))

    def arrays(self, size: int) -> Array:
        """Return four arrays of at least ``size`` floats with anything in them."""
        if self._kept.shape[1] < size:
            self._kept = np.empty((4, size))
        return self._kept


_scratch = _Scratch()

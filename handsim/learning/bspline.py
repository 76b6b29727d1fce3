"""Tensor-product B-splines in 1 to 5 dimensions: values, derivatives, sparse design matrices.

The obstacle is sought in the space of Eq. (9) of the paper, beta(z) = sum c_{i1..in} prod_r
B_{ir}(z_r), C^2 for cubic splines (order 4) and above. The paper stacks the coefficients into a
vector of sum(m_i) entries; there are prod(m_i), stacked here in C order.
"""

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import factorial, prod

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.interpolate import BSpline

from handsim.errors import InputError

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]

MAX_DIMENSIONS = 5
_CHUNK = 2048  # points evaluated at once, so that their patches of coefficients stay in cache


@dataclass(frozen=True)
class _Axis:
    """One dimension: the polynomial pieces of its basis functions.

    ``pieces[cell, power, derivative, i]`` is the coefficient of (x - breaks[cell])**power in the
    given derivative of the i-th of the degree + 1 basis functions that live on the cell.
    """

    knots: Array
    degree: int
    breaks: Array
    first: Index
    pieces: Array
    even: bool
    break_list: list[float] = field(repr=False)

    @classmethod
    def of(cls, knots: npt.ArrayLike, degree: int) -> "_Axis":
        t = np.array(knots, dtype=float)
        m = len(t) - degree - 1
        if t.ndim != 1 or m < degree + 1 or (np.diff(t) < 0).any() or not np.isfinite(t).all():
            raise InputError(
                f"{t.size} knots for degree {degree}; give at least {2 * degree + 2}, increasing"
            )
        spans = np.flatnonzero(np.diff(t) > 0)
        spans = spans[(spans >= degree) & (spans < m)]
        every = BSpline(t, np.eye(m), degree)
        # Taylor coefficients at the left end of each cell.
        taylor = np.stack([every(t[spans], nu=r) / factorial(r) for r in range(degree + 1)])
        pieces = np.zeros((len(spans), degree + 1, 3, degree + 1))
        for cell, span in enumerate(spans):
            powers = taylor[:, cell, span - degree : span + 1]
            for derivative in range(3):
                pieces[cell, : len(powers), derivative] = powers
                powers = powers[1:] * np.arange(1, len(powers))[:, None]
        even = np.allclose(pieces, pieces[:1], rtol=0, atol=1e-9 * np.abs(pieces).max())
        if even:  # inner knots equally spaced: one set of pieces for all cells, to the same bit
            pieces = np.broadcast_to(pieces[0], pieces.shape)
        breaks = np.append(t[spans], t[m])
        return cls(t, degree, breaks, spans - degree, pieces, bool(even), breaks[1:-1].tolist())

    @property
    def n_basis(self) -> int:
        return len(self.knots) - self.degree - 1

    def at(self, x: float) -> tuple[int, Array]:
        """First basis function and (3, degree + 1) derivatives at one point."""
        cell = bisect_right(self.break_list, x)
        t = min(max(x, self.breaks[0]), self.breaks[-1]) - self.breaks[cell]
        pieces = self.pieces[cell]
        values = pieces[-1]
        for power in range(self.degree - 1, -1, -1):
            values = values * t + pieces[power]
        return int(self.first[cell]), values

    def at_all(self, x: Array, order: int) -> tuple[Index, Array]:
        """First basis functions (n,) and derivatives (order + 1, degree + 1, n)."""
        cell = np.searchsorted(self.breaks[1:-1], x, side="right")
        t = np.clip(x, self.breaks[0], self.breaks[-1]) - self.breaks[cell]
        pieces = np.moveaxis(self.pieces[:, :, : order + 1], 0, -1)
        pieces = pieces[..., :1] if self.even else pieces[..., cell]
        values = pieces[-1]
        for power in range(self.degree - 1, -1, -1):
            values = values * t + pieces[power]
        return self.first[cell], values


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
            raise InputError(f"{len(self.knots)} dimensions; a basis has 1 to {MAX_DIMENSIONS}")
        if self.degree < 1:
            raise InputError(f"degree {self.degree}; give at least 1, or 3 for two derivatives")
        object.__setattr__(self, "knots", tuple(axis.knots for axis in self.axes))

    @classmethod
    def uniform(
        cls, lower: npt.ArrayLike, upper: npt.ArrayLike, shape: tuple[int, ...], degree: int = 3
    ) -> "TensorBasis":
        """Lay equally spaced knots on a box, with ``shape`` basis functions per dimension."""
        low, high = np.atleast_1d(lower).astype(float), np.atleast_1d(upper).astype(float)
        if min(shape) <= degree:
            raise InputError(f"shape {shape}; degree {degree} needs at least {degree + 1} each")
        knots = []
        for a, b, m in zip(low, high, shape, strict=True):
            step = (b - a) / (m - degree)
            knots.append(a + step * np.arange(-degree, m + 1))
        return cls(tuple(knots), degree)

    @cached_property
    def axes(self) -> tuple[_Axis, ...]:
        """The dimensions, ready for evaluation."""
        return tuple(_Axis.of(knots, self.degree) for knots in self.knots)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Numbers of basis functions, one a dimension."""
        return tuple(axis.n_basis for axis in self.axes)

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

    def design(self, points: Array, derivatives: tuple[int, ...]) -> sparse.csr_array:
        """Return the matrix that maps coefficients to a derivative at points.

        Parameters
        ----------
        points : (N, n)
        derivatives
            Order of differentiation along each dimension, 0 to 2.

        Returns
        -------
        (N, prod(shape)) sparse, (degree + 1)**n entries a row
        """
        local = [axis.at_all(x, 2) for axis, x in zip(self.axes, points.T, strict=True)]
        strides = np.append(np.cumprod(self.shape[:0:-1])[::-1], 1).astype(np.int64)
        columns = np.zeros((len(points), 1), dtype=np.int64)
        values = np.ones((len(points), 1))
        for (first, basis), stride, derivative in zip(local, strides, derivatives, strict=True):
            here = (first[:, None] + np.arange(self.degree + 1)) * stride
            columns = (columns[:, :, None] + here[:, None, :]).reshape(len(points), -1)
            values = values[:, :, None] * basis[derivative].T[:, None, :]
            values = values.reshape(len(points), -1)
        # Products with these matrices are bound by memory: indices of half the size help.
        index = np.int32 if columns.size < np.iinfo(np.int32).max else np.int64
        starts = np.arange(len(points) + 1, dtype=index) * columns.shape[1]
        shape = (len(points), self.n_coefficients)
        parts = (values.ravel(), columns.ravel().astype(index), starts.astype(index))
        return sparse.csr_array(parts, shape=shape)

    def gradient_designs(self, points: Array) -> list[sparse.csr_array]:
        """Return the design matrices of the first partial derivatives, one a dimension."""
        n = len(self.axes)
        return [self.design(points, tuple(int(i == j) for j in range(n))) for i in range(n)]


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
                f"{c.size} coefficients for a basis of {self.basis.n_coefficients}; give as many"
            )
        c = c.reshape(self.basis.shape)
        c.flags.writeable = False
        object.__setattr__(self, "coefficients", c)

    def jet(self, point: Array, order: int) -> tuple[float, Array, Array]:
        """Return value, gradient (n,) and Hessian (n, n) at one point.

        Touches only the (degree + 1)**n coefficients that matter there. Derivatives above
        ``order`` (0 to 2) are left as empty arrays.
        """
        n, width = len(point), self.basis.degree + 1
        patch: Array = self.coefficients
        local = [axis.at(x) for axis, x in zip(self.basis.axes, point.tolist(), strict=True)]
        patch = patch[tuple([slice(first, first + width) for first, _ in local])]
        for _, values in local:
            patch = patch.reshape(width, -1).T @ values[: order + 1].T
        patch = patch.reshape((order + 1,) * n)
        gradient, hessian = _derivative_index(n)
        return (
            float(patch[(0,) * n]),
            patch[gradient] if order >= 1 else np.empty(0),
            patch[hessian] if order >= 2 else np.empty((0, 0)),
        )

    def jets(self, points: Array, order: int) -> tuple[Array, Array, Array]:
        """Return values (N,), gradients (N, n) and Hessians (N, n, n) at points (N, n)."""
        n_points, n = points.shape
        values = np.empty(n_points)
        gradients = np.empty((n_points, n) if order >= 1 else (n_points, 0))
        hessians = np.empty((n_points, n, n) if order >= 2 else (n_points, 0, 0))
        index = _derivative_index(n)
        for start in range(0, n_points, _CHUNK):
            part = slice(start, start + _CHUNK)
            tables = self._tables(points[part], order)
            values[part] = tables[(0,) * n]
            if order >= 1:
                gradients[part] = tables[index[0]].T
            if order >= 2:
                hessians[part] = np.moveaxis(tables[index[1]], -1, 0)
        return values, gradients, hessians

    def _tables(self, points: Array, order: int) -> Array:
        """All mixed derivatives up to ``order`` in each dimension, (order + 1, ..., N)."""
        basis, width, n_points = self.basis, self.basis.degree + 1, len(points)
        local = [axis.at_all(x, order) for axis, x in zip(basis.axes, points.T, strict=True)]
        where = np.zeros((1, n_points), dtype=np.int64)
        for (first, _), m in zip(local, basis.shape, strict=True):
            where = where * m
            where = (where[:, None] + first + np.arange(width)[None, :, None]).reshape(-1, n_points)
        # where holds, for each patch entry, sum of (first + offset) * stride by Horner's rule.
        patch = self.coefficients.ravel()[where]
        for _, values in local:
            patch = patch.reshape(width, -1, n_points)
            contracted = np.empty((patch.shape[1], order + 1, n_points))
            for derivative in range(order + 1):
                total = patch[0] * values[derivative, 0]
                for i in range(1, width):
                    total += patch[i] * values[derivative, i]
                contracted[:, derivative] = total
            patch = contracted
        return patch.reshape((order + 1,) * len(local) + (n_points,))


def _derivative_index(n: int) -> tuple[tuple[Index, ...], tuple[Index, ...]]:
    """Places of the gradient (n,) and the Hessian (n, n) in the table of mixed derivatives."""
    if n not in _INDEX:
        unit = np.eye(n, dtype=np.int64)
        pairs = np.zeros((n, n, n), dtype=np.int64)
        for i, j in product(range(n), repeat=2):
            pairs[:, i, j] = unit[i] + unit[j]
        _INDEX[n] = (tuple(unit), tuple(pairs))
    return _INDEX[n]


_INDEX: dict[int, tuple[tuple[Index, ...], tuple[Index, ...]]] = {}

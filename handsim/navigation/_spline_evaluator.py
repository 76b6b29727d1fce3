"""Splines at single points, for loops in which each microsecond counts."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import product
from struct import Struct
from typing import TYPE_CHECKING

import numpy as np

from handsim.types import Array, Index

if TYPE_CHECKING:
    from handsim.navigation.bspline import TensorBSpline

_MAX_TABLED = 2**23  # floats (64 MiB) kept of polynomials of cells; three dimensions take 0.14e6


class SplineEvaluator:
    """A spline and its derivatives at single points.

    On a knot cell the spline and each of its derivatives is a polynomial. Its coefficients are put
    into a table when the first point in the cell is asked for (some 30 microseconds). They are
    split into two groups of dimensions, so that each point takes two products of small matrices,
    written into arrays that were made beforehand.

    The next point overwrites the array that was returned; each thread needs an evaluator of its
    own.

    Parameters
    ----------
    spline
    order
        Highest derivative, 0 to 2.
    """

    def __init__(self, spline: "TensorBSpline", order: int = 1) -> None:
        self._spline, self._order = spline, order
        basis = spline.basis
        n, width = len(basis.axes), basis.degree + 1
        self._half = (n + 1) // 2
        self._cells = basis.cells
        self._powers = _cubic_powers if width == 4 else partial(_powers, width)
        self._tables = spline.tables[order]
        n_front, n_back = width**self._half, width ** (n - self._half)
        n_parts = (1, 1 + n, 1 + n + n * n)[order]
        self._front, self._back = np.empty(n_front), np.empty(n_back)
        self._set_front, self._set_back = _packer(n_front), _packer(n_back)
        self._middle = np.empty(n_parts * n_back)
        self._middle_rows = self._middle.reshape(n_parts, n_back)
        self._parts = np.empty(n_parts)

    def __call__(self, point: Sequence[float]) -> Array:
        """Return value, then gradient (n,), then Hessian (n * n,), up to the order, in one array.

        It is the same array each time.
        """
        number = 0
        powers: list[list[float]] = []
        for x, (inner, breaks, low, high, count) in zip(point, self._cells, strict=True):
            cell = bisect_right(inner, x)
            number = number * count + cell
            inside = low if x < low else high if x > high else x
            powers.append(self._powers(inside - breaks[cell]))
        table = self._tables.get(number)
        if table is None:
            table = self._table(number)
        self._set_front(self._front, 0, *_products(powers[: self._half]))
        self._set_back(self._back, 0, *_products(powers[self._half :]))
        np.dot(self._front, table, self._middle)
        np.dot(self._middle_rows, self._back, self._parts)
        return self._parts

    def _table(self, number: int) -> Array:
        """Polynomial coefficients on a cell: (front powers, parts * back powers)."""
        basis, order = self._spline.basis, self._order
        n = len(basis.axes)
        cells = np.unravel_index(number, [axis[-1] for axis in self._cells])
        firsts = [int(axis.first[cell]) for axis, cell in zip(basis.axes, cells, strict=True)]
        c = self._spline.coefficients[tuple(slice(i, i + basis.degree + 1) for i in firsts)]
        for axis, cell in zip(basis.axes, cells, strict=True):
            # (basis function, ...) -> (..., power, derivative)
            c = np.tensordot(c, axis.pieces[cell, :, : order + 1], axes=(0, 2))
        c = np.transpose(c, (*range(1, 2 * n, 2), *range(0, 2 * n, 2)))
        gradient, hessian = derivative_index(n)
        rows = [c[(0,) * n][None]]
        rows += [c[gradient]] if order >= 1 else []
        rows += [c[hessian].reshape((n * n, *c.shape[n:]))] if order >= 2 else []
        table = np.concatenate(rows).reshape(-1, len(self._front), len(self._back))
        table = np.ascontiguousarray(table.transpose(1, 0, 2)).reshape(len(self._front), -1)
        if (len(self._tables) + 1) * table.size > _MAX_TABLED:
            self._tables.clear()
        self._tables[number] = table
        return table


def _products(powers: list[list[float]]) -> list[float]:
    """All products of one entry of each, the last dimension fastest."""
    if not powers:
        return [1.0]
    row = powers[0]
    for other in powers[1:]:
        row = [a * b for a in row for b in other]
    return row


def _powers(width: int, t: float) -> list[float]:
    row = [1.0]
    for _ in range(width - 1):
        row.append(row[-1] * t)
    return row


def _cubic_powers(t: float) -> list[float]:
    square = t * t
    return [1.0, t, square, square * t]


@cache
def _packer(count: int) -> Callable[..., None]:
    """Write ``count`` floats into an array; half the time of assigning a tuple to a slice."""
    return Struct(f"{count}d").pack_into


def derivative_index(n: int) -> tuple[tuple[Index, ...], tuple[Index, ...]]:
    """Places of the gradient (n,) and the Hessian (n, n) in the table of mixed derivatives."""
    if n not in _INDEX:
        unit = np.eye(n, dtype=np.int64)
        pairs = np.zeros((n, n, n), dtype=np.int64)
        for i, j in product(range(n), repeat=2):
            pairs[:, i, j] = unit[i] + unit[j]
        _INDEX[n] = (tuple(unit), tuple(pairs))
    return _INDEX[n]


_INDEX: dict[int, tuple[tuple[Index, ...], tuple[Index, ...]]] = {}

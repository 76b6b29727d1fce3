"""Smooth curves through the subspace, and progress over time: uniform cubic B-splines.

The control points are the points of a path. The first and the last are mirrored in the ends, which
makes the curve begin and end exactly there, without curvature. It is C^2, lies in the convex hull
of its control points, and rises where they rise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from handsim.types import Array, Index

_Number = TypeVar("_Number", float, Array)


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve over a parameter s from 0 to 1, and straight on beyond both ends.

    Parameters
    ----------
    points : (m + 1, n)
        Control points, at equal steps of the parameter.
    """

    points: Array

    @property
    def n_cells(self) -> int:
        """Number m of polynomial pieces."""
        return len(self.points) - 1

    @cached_property
    def _padded(self) -> Array:
        first = 2.0 * self.points[:1] - self.points[1:2]
        last = 2.0 * self.points[-1:] - self.points[-2:-1]
        return np.concatenate([first, self.points, last])

    def at(self, s: Array) -> Array:
        """Return the points (N, n) at parameters (N,)."""
        inside = np.clip(s, 0.0, 1.0)
        four, u = self._around(inside)
        points = _weighted(four, _value_weights(u)) / 6.0
        for end, point in ((0.0, self.points[0]), (1.0, self.points[-1])):  # to the bit
            points = np.where((inside == end)[:, None], point, points)
        beyond = s - inside
        if np.any(beyond):
            points = points + beyond[:, None] * self.slope(inside)
        return points

    def slope(self, s: Array) -> Array:
        """Return the derivatives (N, n) by s at parameters (N,)."""
        four, u = self._around(np.clip(s, 0.0, 1.0))
        return _weighted(four, _slope_weights(u)) * (0.5 * self.n_cells)

    def jet(self, s: float) -> tuple[list[float], list[float]]:
        """Return point and derivative (n,) at one parameter from 0 to 1; for loops."""
        n_cells = self.n_cells
        cell, u = _cell_at(n_cells, s)
        fours = list(zip(*self._rows[cell : cell + 4], strict=True))
        values, slopes, scale = _value_weights(u), _slope_weights(u), 0.5 * n_cells
        return (
            [_weighted(four, values) / 6.0 for four in fours],
            [_weighted(four, slopes) * scale for four in fours],
        )

    @cached_property
    def _rows(self) -> list[list[float]]:
        return self._padded.tolist()

    @cached_property
    def _numbers(self) -> list[float]:
        return self._padded[:, 0].tolist()

    def scalar_jet(self, s: float) -> tuple[float, float]:
        """Return value and derivative of a curve of one number, as `jet`; ten times as fast."""
        n_cells = self.n_cells
        cell, u = _cell_at(n_cells, s)
        four = self._numbers[cell : cell + 4]
        value, slope = _weighted(four, _value_weights(u)), _weighted(four, _slope_weights(u))
        return value / 6.0, slope * (0.5 * n_cells)

    def _around(self, s: Array) -> tuple[list[Array], Array]:
        """Return the four control points (N, n) at s, and the places (N, 1) in their cells."""
        place = s * self.n_cells
        cell: Index = np.minimum(place.astype(np.int64), self.n_cells - 1)
        return [self._padded[cell + i] for i in range(4)], (place - cell)[:, None]

    def centres(self) -> Array:
        """Return points (4 m, n) whose convex hull holds p(s) + (1 - s) p'(s) for s up to 1.

        That is where the straight continuation of the curve would be at s = 1. On each cell it is
        a cubic; the points are its Bernstein coefficients.
        """
        before, here, after, next_ = (self._padded[i : i + self.n_cells] for i in range(4))
        b = np.stack(
            [
                (before + 4.0 * here + after) / 6.0,
                (2.0 * here + after) / 3.0,
                (here + 2.0 * after) / 3.0,
                (here + 4.0 * after + next_) / 6.0,
            ]
        )
        d = 3.0 * self.n_cells * np.diff(b, axis=0)
        left = 1.0 - np.arange(self.n_cells + 1)[:, None] / self.n_cells
        start, end = left[:-1], left[1:]
        b[0] += start * d[0]
        b[1] += (end * d[0] + 2.0 * start * d[1]) / 3.0
        b[2] += (2.0 * end * d[1] + start * d[2]) / 3.0
        b[3] += end * d[2]
        return b.reshape(-1, b.shape[-1])


def _cell_at(n_cells: int, s: float) -> tuple[int, float]:
    """Return the cell that a parameter is in, and the place in it, 0 to 1."""
    place = min(max(s, 0.0), 1.0) * n_cells
    cell = min(int(place), n_cells - 1)
    return cell, place - cell


def _value_weights(u: _Number) -> tuple[_Number, ...]:
    """Six times the weights of four control points at a place in their cell, 0 to 1."""
    v = 1.0 - u
    inner = (4.0 - 6.0 * u * u + 3.0 * u * u * u, 4.0 - 6.0 * v * v + 3.0 * v * v * v)
    return v * v * v, *inner, u * u * u


def _slope_weights(u: _Number) -> tuple[_Number, ...]:
    """Twice their derivatives by the place in the cell."""
    v = 1.0 - u
    return -v * v, u * (3.0 * u - 4.0), v * (4.0 - 3.0 * v), u * u


def _weighted(four: Sequence[_Number], weights: tuple[_Number | float, ...]) -> _Number:
    a, b, c, d = four
    wa, wb, wc, wd = weights
    return a * wa + b * wb + c * wc + d * wd


def interpolated(x: Array, known: Array, points: Array) -> Array:
    """Return points (m, d) at ``x`` (m,) between points (n, d) at ``known`` (n,), increasing."""
    columns: list[Array] = list(points.T)
    return np.column_stack([np.interp(x, known, column) for column in columns])

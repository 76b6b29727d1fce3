"""Splines on boxes in Bernstein form: coefficients that bracket a polynomial on a box."""

from dataclasses import dataclass
from math import comb

import numpy as np

from handsim.navigation.bspline import TensorBSpline
from handsim.reproducible import total, total_of
from handsim.types import Array, Index, Mask


@dataclass(frozen=True)
class Cells:
    """A spline on boxes, in Bernstein form.

    origin, size : (N, n); coefficients : (N, degree + 1, ..., degree + 1)
    """

    origin: Array
    size: Array
    coefficients: Array

    @classmethod
    def of(cls, spline: TensorBSpline) -> "Cells":
        """One box a knot cell."""
        n, degree = spline.coefficients.ndim, spline.basis.degree
        c = spline.coefficients
        for r, axis in enumerate(spline.basis.axes):
            to_cells = axis.bernstein
            local = axis.first[:, None] + np.arange(degree + 1)
            # Axes already done lead as pairs (cell, power); the next to do is axis 2 r.
            gathered = np.moveaxis(np.take(c, local, axis=2 * r), (2 * r, 2 * r + 1), (0, 1))
            extent = (slice(None), slice(None), slice(None), *(None,) * (gathered.ndim - 2))
            summed = total(to_cells[extent] * gathered[:, None], 2)
            c = np.moveaxis(summed, (0, 1), (2 * r, 2 * r + 1))
        c = np.transpose(c, (*range(0, 2 * n, 2), *range(1, 2 * n, 2)))
        c = c.reshape((-1, *(degree + 1,) * n))
        breaks = [axis.breaks for axis in spline.basis.axes]
        origin = np.stack(np.meshgrid(*[b[:-1] for b in breaks], indexing="ij"), -1).reshape(-1, n)
        size = np.stack(np.meshgrid(*[np.diff(b) for b in breaks], indexing="ij"), -1)
        return cls(origin, size.reshape(-1, n), c)

    def take(self, which: Mask) -> "Cells":
        return Cells(self.origin[which], self.size[which], self.coefficients[which])

    def halved(self) -> "Cells":
        """Split every box in halves along all dimensions."""
        origin, size, c = self.origin, self.size / 2, self.coefficients
        left = _left_half(c.shape[1] - 1)
        right = left[::-1, ::-1]
        for axis in range(origin.shape[1]):
            halves = [_along(half, c, axis + 1) for half in (left, right)]
            c = np.concatenate(halves)
            shift = np.zeros(origin.shape[1])
            shift[axis] = 1.0
            origin = np.concatenate([origin, origin + size * shift])
            size = np.concatenate([size, size])
        return Cells(origin, size, c)

    def farthest(self, low: Array, high: Array) -> Array:
        """Greatest distance, along each dimension, of a point of a cell from a box, (N, n)."""
        return np.maximum(np.abs(self.origin - high), np.abs(self.origin + self.size - low))

    def corner(self, cell: int, corner: int) -> Array:
        """Position of the corner that `corner_index` lists at ``corner``."""
        n = len(self.origin[0])
        bits = (corner >> np.arange(n)[::-1]) & 1
        return self.origin[cell] + bits * self.size[cell]


def corner_index(coefficients: Array) -> tuple[Index, ...]:
    """Index of the coefficients at the corners of cells, last dimension fastest."""
    degree = coefficients.shape[1] - 1
    ends = [np.array([0, degree])] * (coefficients.ndim - 1)
    return np.ix_(np.arange(len(coefficients)), *ends)


def _left_half(degree: int) -> Array:
    """De Casteljau at u = 1/2: coefficients on the left half."""
    size = degree + 1
    return np.array([[comb(j, i) / 2**j for i in range(size)] for j in range(size)])


def _along(matrix: Array, array: Array, axis: int) -> Array:
    """Return the products of a matrix (m, m) with all rows (m,) along an axis of an array."""
    result = np.empty_like(array)
    rows, products = np.moveaxis(array, axis, 0), np.moveaxis(result, axis, 0)
    for i, weights in enumerate(matrix):
        products[i] = total_of([row * weight for row, weight in zip(rows, weights, strict=True)])
    return result

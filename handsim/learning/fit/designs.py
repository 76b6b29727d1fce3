"""Splines at fixed points as a linear function of their coefficients, there and back.

A sparse matrix would hold the same function. But products with sparse matrices are compiled, and
the compiler decides whether a product and a sum are rounded once or twice. Here each step is one
array operation (`reproducible`), dimension by dimension, which is also less work than all
products of basis functions.
"""

import threading
from collections.abc import Iterator
from math import prod

import numpy as np
import numpy.typing as npt

from handsim.navigation.bspline import TensorBasis
from handsim.types import Array, Index

_CHUNK = 2**16  # coefficients gathered at once (512 KiB), so that they stay in cache
_SMALL = 2**12  # numbers of which sums are one operation, rather than one a row
_KEPT = 2**20  # places of coefficients that a design keeps (8 MiB); of more it makes them again


class JetDesign:
    """Values and gradients of a spline at points, as a linear function of its coefficients.

    Parameters
    ----------
    basis
    points : (N, n)

    Attributes
    ----------
    corners : (N,)
        Place of the first of the coefficients that matter at each point.
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
        self.corners: Index = corner
        self._where: list[tuple[slice, Index]] | None = None

    def taken(self, which: npt.NDArray[np.int64]) -> "JetDesign":
        """Return the design of some of the points."""
        part = object.__new__(JetDesign)
        part._basis, part._chunk, part.n_points = self._basis, self._chunk, len(which)
        part._local = [values[:, :, which] for values in self._local]
        part.corners = self.corners[which]
        part._where = None
        return part

    def __call__(self, c: Array) -> tuple[Array, Array]:
        """Return values (N,) and gradients (n, N) of the spline of coefficients (prod(m_i),)."""
        jets = np.empty((len(self._local) + 1, self.n_points))
        for part, where in self._parts():
            patch = _room.array(0, *where.shape)
            np.take(c, where, out=patch, mode="clip")  # "raise" would copy
            rows = patch[None]  # value, then the slopes along the dimensions summed over
            for i, values in enumerate(self._local):
                basis, slopes = values[:, :, part]
                rows = rows.reshape(len(rows), len(basis), -1, rows.shape[-1])
                summed = _room.array(1 + i % 2, len(rows) + 1, *rows.shape[2:])
                term = _room.array(3, *summed[:-1].shape)
                _contract(rows, basis, summed[:-1], term)
                _contract(rows[:1], slopes, summed[-1:], term[:1])
                rows = summed
            jets[:, part] = rows[:, 0]
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
        for part, where in self._parts():
            whole = None if by_value is None else by_value[part][None]
            slopes = None if by_gradient is None else by_gradient[:, None, part]
            for i, values in enumerate(reversed(self._local)):
                basis, by_slope = values[:, :, part]
                if slopes is None or not len(slopes):
                    assert whole is not None
                    whole = _spread(i, whole, basis)
                    continue
                whole = _spread(i, slopes[-1], by_slope, whole, basis)
                rest = slopes[:-1]
                spread = _room.array(3 + i % 2, len(rest), len(basis), *rest.shape[1:])
                np.multiply(basis[:, None], rest[:, None], out=spread)
                slopes = spread.reshape(len(rest), *whole.shape)
            assert whole is not None
            result += np.bincount(where.ravel(), whole.ravel(), minlength=len(result))
        return result

    def _parts(self) -> Iterator[tuple[slice, Index]]:
        """Yield some of the points at a time, and the places of their coefficients."""
        if self._where is None:
            found = self._places()
            if self.n_points * len(self._basis.patch) > _KEPT:
                yield from found
                return
            self._where = list(found)
        yield from self._where

    def _places(self) -> Iterator[tuple[slice, Index]]:
        for i in range(0, self.n_points, self._chunk):
            part = slice(i, i + self._chunk)
            yield part, self._basis.patch + self.corners[part]


def _contract(rows: Array, weights: Array, result: Array, term: Array) -> None:
    """Sum (r, width, m, N) by weights (width, N) into a result, with room for a term (r, m, N)."""
    np.multiply(rows[:, 0], weights[0], out=result)
    for i in range(1, len(weights)):
        np.multiply(rows[:, i], weights[i], out=term)
        result += term


def _spread(
    step: int,
    patch: Array,
    weights: Array,
    other: Array | None = None,
    by_other: Array | None = None,
) -> Array:
    """Transpose of `_contract`: (m, N) to (width * m, N), added to that of another patch."""
    result = _room.array(step % 2, len(weights), *patch.shape)
    if other is None or by_other is None:
        np.multiply(weights[:, None], patch, out=result)
    elif patch.size < _SMALL:
        np.multiply(weights[:, None], patch, out=result)
        result += by_other[:, None] * other
    else:  # row by row: what is added to is still in cache
        term = _room.array(2, *patch.shape)
        for row, weight, by_weight in zip(result, weights, by_other, strict=True):
            np.multiply(patch, weight, out=row)
            np.multiply(other, by_weight, out=term)
            np.add(row, term, out=row)
    return result.reshape(-1, patch.shape[1])


class _Room(threading.local):
    """Arrays that each thread keeps for the next call: fresh pages cost as much as the sums."""

    def __init__(self) -> None:
        self._kept: dict[int, Array] = {}

    def array(self, number: int, *shape: int) -> Array:
        """Return an array with anything in it, which the next one of its number overwrites."""
        size = prod(shape)
        if number not in self._kept or self._kept[number].size < size:
            self._kept[number] = np.empty(size)
        return self._kept[number][:size].reshape(shape)


_room = _Room()

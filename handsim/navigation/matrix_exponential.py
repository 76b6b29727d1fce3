"""Exponentials of many symmetric matrices and their derivatives, in reproducible arithmetic.

The Taylor polynomial of degree 15 of the matrices, halved until their norm is 1/2 or less, in
blocks of four powers (Paterson and Stockmeyer 1973), is squared as often as they were halved. The
derivative along D is the upper right block of exp [[S, D], [0, S]] (Higham 2008, Functions of
Matrices, Eq. 3.16), whose other blocks are those of exp S and are kept.
"""

from math import factorial

import numpy as np

from handsim.reproducible import dots
from handsim.types import Array, Mask

# Coefficients of exp's powers 0 to 15, by fours; at a norm of 1/2 the next term is below 1e-18.
_TAYLOR = np.array([1.0 / factorial(power) for power in range(16)]).reshape(4, 4)
_OF_ONE, _OF_FIRST, _OF_SQUARE, _OF_CUBE = _TAYLOR.T[:, :, None, None, None]


class Exponential:
    """exp of symmetric matrices (N, n, n).

    Attributes
    ----------
    value : (N, n, n)
        Symmetric to the bit.
    """

    def __init__(self, logs: Array) -> None:
        n = logs.shape[1]
        flat = logs.reshape(len(logs), -1)
        self._halvings = np.maximum(np.frexp(np.sqrt(dots(flat, flat)))[1] + 1, 0)
        x = np.ldexp(_stacked(logs), -self._halvings)
        square = _product(x, x)
        self._fourth = _product(square, square)
        self._powers = (x, square)
        cube = _product(square, x)
        even = _OF_ONE * np.eye(n)[:, :, None] + _OF_SQUARE * square
        blocks = even + (_OF_FIRST * x + _OF_CUBE * cube)
        value = blocks[-1]
        self._values: list[Array] = []  # before each product, with the fourth power or themselves
        for block in blocks[-2::-1]:
            self._values.append(value)
            value = _product(value, self._fourth) + block
        most = int(self._halvings.max(initial=0))
        self._squared = [self._halvings > i for i in range(most)]
        for which in self._squared:
            self._values.append(value)
            value = _where(which, _product(value, value), value)
        self.value = _symmetric(value)

    def slopes(self, directions: Array) -> Array:
        """Return the derivatives (N, n, n) of `value` along symmetric directions (N, n, n)."""
        x, square = self._powers
        by_x = np.ldexp(_stacked(directions), -self._halvings)
        by_square = _product_slope(x, by_x, x, by_x)
        by_fourth = _product_slope(square, by_square, square, by_square)
        by_cube = _product_slope(square, by_square, x, by_x)
        blocks = _OF_SQUARE * by_square + (_OF_FIRST * by_x + _OF_CUBE * by_cube)
        slope, values = blocks[-1], iter(self._values)
        for block in blocks[-2::-1]:
            slope = _product_slope(next(values), slope, self._fourth, by_fourth) + block
        for which, value in zip(self._squared, values, strict=True):
            slope = _where(which, _product_slope(value, slope, value, slope), slope)
        return _symmetric(slope)


def exponential(logs: Array) -> Array:
    """Return exp of symmetric matrices (N, n, n), symmetric to the bit."""
    return Exponential(logs).value


def _stacked(matrices: Array) -> Array:
    """Return matrices (N, n, n) as (n, n, N): steps along the last axis are what arrays do fast."""
    return np.ascontiguousarray(matrices.transpose(1, 2, 0))


def _symmetric(stacked: Array) -> Array:
    """Return matrices (n, n, N) as (N, n, n), each the mean of itself and its transpose."""
    return (0.5 * (stacked + stacked.transpose(1, 0, 2))).transpose(2, 0, 1)


def _where(which: Mask, ours: Array, theirs: Array) -> Array:
    return ours if which.all() else np.where(which, ours, theirs)


def _product(a: Array, b: Array) -> Array:
    """Return the products of matrices (n, n, N), their terms added one after another."""
    terms = a[:, :, None] * b
    result = terms[:, 0]
    for i in range(1, len(b)):
        result = result + terms[:, i]
    return result


def _product_slope(a: Array, by_a: Array, b: Array, by_b: Array) -> Array:
    """Return the derivatives of products of matrices a and b from theirs, all (n, n, N)."""
    terms = by_a[:, :, None] * b
    result = _product(a, by_b)
    for i in range(len(b)):
        result = result + terms[:, i]
    return result

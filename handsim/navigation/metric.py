"""How a destination attracts: gamma_d = (z - z_goal)' M(z_goal) (z - z_goal).

The paper takes M = I: where nothing obstructs, its flow is straight. People who reach for one thing
open the fingers before they close them and turn the wrist first for another; one obstacle for all
destinations cannot tell such movements apart, the metric of the destination can. With M symmetric
and positive definite gamma_d is zero at the destination alone and grows along every ray from it,
which is what Koditschek and Rimon (1990) ask of it. And since (z - z_goal) . grad ln gamma_d = 2
whatever M, the proof of convergence is the same for all M (`navigation.certificate`).

ln M is a smooth function of the destination,

    ln M(z_goal) = S_0 + sum_j K(z_goal, z_j) S_j,   K(a, b) = exp(-|a - b|^2 / (2 reach^2)),

with symmetric S: M is then positive definite for all values of S, and far from the destinations it
was learned at it tends to exp(S_0). (Logarithms make a vector space of the metrics: Arsigny et al.
2006, Magn. Reson. Med. 56(2):411-421.)
"""

from dataclasses import dataclass, field
from math import factorial

import numpy as np

from handsim.reproducible import dots, exp, total
from handsim.types import Array, Mask

# Coefficients of exp's powers 0 to 15, by fours; at a norm of 1/2 the next term is below 1e-18.
_TAYLOR = np.array([1.0 / factorial(power) for power in range(16)]).reshape(4, 4)
_OF_ONE, _OF_FIRST, _OF_SQUARE, _OF_CUBE = _TAYLOR.T[:, :, None, None, None]
_Answer = tuple[tuple[tuple[int, ...], bytes], Array]  # shape and bytes asked for, metrics
_Known = tuple[dict[bytes, int], Array]  # destinations as bytes to places, and their metrics


@dataclass(frozen=True)
class DestinationMetric:
    """The metric M of every destination.

    Parameters
    ----------
    centres : (m, n) [rad]
        Destinations z_j.
    logs : (1 + m, n, n)
        S_0, then the S_j; symmetric.
    reach : [rad]
        Distance over which destinations share their metric.
    """

    centres: Array
    logs: Array
    reach: float
    _latest: list[_Answer] = field(default_factory=list[_Answer], compare=False, repr=False)
    _known: list[_Known] = field(default_factory=list[_Known], compare=False, repr=False)

    def at(self, z_goal: Array) -> Array:
        """Return the metrics (..., n, n) of destinations (..., n) [rad].

        Paths are followed to the same destinations step after step, to fewer of them as paths end.
        Therefore the latest answer is kept, and the metrics of the latest set of destinations that
        had to be computed, each of which is computed once however often it is repeated.
        """
        shape = np.shape(z_goal)
        asked = (shape, np.asarray(z_goal, dtype=float).tobytes())
        for answered, metrics in self._latest[:1]:
            if answered == asked:
                return metrics
        goals = np.ascontiguousarray(np.reshape(z_goal, (-1, shape[-1])), dtype=float)
        metrics = self._found(goals).reshape(*shape, shape[-1])
        self._latest[:] = [(asked, metrics)]
        return metrics

    def _found(self, goals: Array) -> Array:
        """Return the metrics (N, n, n) of destinations (N, n), from what is known if all are."""
        keys = goals.view(f"V{goals.itemsize * goals.shape[1]}").ravel().tolist()
        for places, metrics in self._known[:1]:
            where = [places.get(key, -1) for key in keys]
            if -1 not in where:
                return metrics[where]
        different = dict(zip(keys, goals, strict=True))
        places = {key: place for place, key in enumerate(different)}
        metrics = self._computed(np.array(list(different.values())))
        self._known[:] = [(places, metrics)]
        return metrics[[places[key] for key in keys]]

    def _computed(self, goals: Array) -> Array:
        shares = gaussian_kernel(goals, self.centres, self.reach)
        logs = self.logs[0] + total(shares[:, :, None, None] * self.logs[1:], 1)
        return exponential(logs)


def gaussian_kernel(a: Array, b: Array, reach: float) -> Array:
    """Return K between points a (N, n) and b (m, n), (N, m)."""
    apart = a[:, None] - b[None]
    return exp(-0.5 * dots(apart, apart) / (reach * reach))


class Exponential:
    """exp of symmetric matrices (N, n, n), and their derivatives, in reproducible arithmetic.

    The Taylor polynomial of degree 15 of the matrices, halved until their norm is 1/2 or less, in
    blocks of four powers (Paterson and Stockmeyer 1973), is squared as often as they were halved.
    The derivative along D is the upper right block of exp [[S, D], [0, S]] (Higham 2008, Functions
    of Matrices, Eq. 3.16), whose other blocks are those of exp S and are kept.

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

"""One dimension of a spline space: its knots, and its basis functions as polynomials on cells."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import comb, factorial

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.reproducible import product
from handsim.types import Array, Index


@dataclass(frozen=True)
class KnotAxis:
    """Knots along one dimension and the polynomial pieces of the basis functions on them.

    Attributes
    ----------
    knots : (n_basis + degree + 1,)
    degree
    spans : (n_cells,)
        The knot at the left end of each cell; cells are the intervals between different knots.
    """

    knots: Array
    degree: int
    spans: Index

    @classmethod
    def of(cls, knots: npt.ArrayLike, degree: int) -> "KnotAxis":
        """Lay basis functions on knots.

        Raises
        ------
        InputError
            If there are too few knots, or they decrease or are not finite.
        """
        t = np.array(knots, dtype=float)
        m = len(t) - degree - 1
        if t.ndim != 1 or m < degree + 1 or (np.diff(t) < 0).any() or not np.isfinite(t).all():
            raise InputError(
                f"{t.size} knots for degree {degree}; give at least {2 * degree + 2}, increasing"
            )
        spans = np.flatnonzero(np.diff(t) > 0)
        return cls(t, degree, spans[(spans >= degree) & (spans < m)])

    @cached_property
    def breaks(self) -> Array:
        """Ends of the cells, (n_cells + 1,)."""
        return np.append(self.knots[self.spans], self.knots[self.n_basis])

    @cached_property
    def first(self) -> Index:
        """First of the degree + 1 basis functions that live on each cell, (n_cells,)."""
        return self.spans - self.degree

    @cached_property
    def pieces(self) -> Array:
        """Polynomials of the basis functions, (n_cells, degree + 1, 3, degree + 1).

        ``pieces[cell, power, derivative, i]`` is the coefficient of (x - breaks[cell])**power in
        the given derivative of the i-th basis function of the cell.
        """
        n = self.degree + 1
        taylor = [_at_knots(self, order) / factorial(order) for order in range(n)]
        powers = np.stack(taylor, axis=1)
        pieces = np.zeros((len(self.spans), n, 3, n))
        for derivative in range(3):
            left = powers.shape[1]
            pieces[:, :left, derivative] = powers
            powers = powers[:, 1:] * np.arange(1, left)[:, None]
        if np.abs(pieces - pieces[:1]).max() <= 1e-9 * np.abs(pieces).max():
            # Inner knots are equally spaced: one set of pieces for all cells, to the same bit.
            pieces = np.broadcast_to(pieces[0], pieces.shape)
        return pieces

    @cached_property
    def bernstein(self) -> Array:
        """Bernstein coefficients of the basis functions, (n_cells, degree + 1, degree + 1).

        ``bernstein[cell, :, i]`` are those of the i-th basis function of the cell, on the cell.
        """
        size = np.diff(self.breaks)
        # Power coefficients in t = x - break, then in u = t / size, then Bernstein.
        powers = self.pieces[:, :, 0] * _powers(size, self.degree)[:, :, None]
        return product(_power_to_bernstein(self.degree), powers)

    @property
    def even(self) -> bool:
        """Whether all cells have the same pieces."""
        return self.pieces.strides[0] == 0

    @property
    def n_basis(self) -> int:
        """Number of basis functions."""
        return len(self.knots) - self.degree - 1

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


def _at_knots(axis: KnotAxis, order: int) -> Array:
    """Return a derivative of the basis functions at the left ends of cells, (n_cells, degree + 1).

    C. de Boor (1978), "A Practical Guide to Splines", chapter X. The operations and their order are
    those of scipy.interpolate.BSpline, whose import takes longer than most commands.
    """
    t, spans, degree = axis.knots, axis.spans, axis.degree
    x = t[spans]
    values = [np.ones(len(spans))]
    for j in range(1, degree + 1):
        lower, values = values, [np.zeros(len(spans)) for _ in range(j + 1)]
        for n in range(1, j + 1):
            right, left = t[spans + n], t[spans + n - j]
            if j <= degree - order:
                weight = lower[n - 1] / (right - left)
                values[n - 1] += weight * (right - x)
                values[n] = weight * (x - left)
            else:
                weight = j * lower[n - 1] / (right - left)
                values[n - 1] -= weight
                values[n] = weight
    return np.stack(values, axis=-1)


def _powers(x: Array, degree: int) -> Array:
    """Return 1, x, ..., x^degree of numbers (N,), each the number nearest to it: (N, degree + 1).

    NumPy takes its powers from other code where the processor has AVX-512, with another last bit.
    """
    powers = range(degree + 1)
    return np.array([[float(exact_number**i) for i in powers] for exact_number in map(Fraction, x)])


def _power_to_bernstein(degree: int) -> Array:
    """u^i = sum over j >= i of C(j, i) / C(degree, i) B_j; (degree + 1, degree + 1)."""
    size = degree + 1
    return np.array([[comb(j, i) / comb(degree, i) for i in range(size)] for j in range(size)])

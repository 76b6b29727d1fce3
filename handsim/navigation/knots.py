"""One dimension of a spline space: its knots, and its basis functions as polynomials on cells."""

from dataclasses import dataclass
from math import factorial

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline

from handsim.errors import InputError
from handsim.types import Array, Index


@dataclass(frozen=True)
class KnotAxis:
    """Knots along one dimension and the polynomial pieces of the basis functions on them.

    Attributes
    ----------
    knots : (n_basis + degree + 1,)
    degree
    breaks : (n_cells + 1,)
        Ends of the cells, the intervals between different knots.
    first : (n_cells,)
        First of the degree + 1 basis functions that live on a cell.
    pieces : (n_cells, degree + 1, 3, degree + 1)
        ``pieces[cell, power, derivative, i]`` is the coefficient of (x - breaks[cell])**power in
        the given derivative of the i-th basis function of the cell.
    even
        Whether all cells have the same pieces.
    """

    knots: Array
    degree: int
    breaks: Array
    first: Index
    pieces: Array
    even: bool

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
        return cls(t, degree, breaks, spans - degree, pieces, bool(even))

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

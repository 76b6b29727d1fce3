"""How far the descent quantity can move at points when coefficients change.

The slope of a spline along a dimension is a spline of a degree less there, whose coefficients are
scaled differences of the spline's own (de Boor 2001, A Practical Guide to Splines, ch. X). At
a point it is a mean of those that reach there. So with a change d of the coefficients

    |(z - z_goal) . grad chi| moves by at most sum_j |z - z_goal|_j max |scaled differences of d|,

the greatest over the patch of the point. Where the descent condition is far from failing it need
not be looked at again until the coefficients have changed by that much.
"""

import numpy as np

from handsim.learning.fit.designs import JetDesign
from handsim.navigation.bspline import TensorBasis
from handsim.types import Array


class ChangeBounds:
    """Bounds of changes of (z - z_goal) . grad chi.

    Parameters
    ----------
    basis
        Of chi.
    design
        Of the points.
    points : (N, n) [rad]
    goals : (m, n) [rad]
    """

    def __init__(self, basis: TensorBasis, design: JetDesign, points: Array, goals: Array) -> None:
        self._shape, self._degree = basis.shape, basis.degree
        low, high = goals.min(axis=0), goals.max(axis=0)
        self._levers = np.maximum(np.abs(points - low), np.abs(points - high)).T.copy()
        n_cells = tuple(m - basis.degree for m in basis.shape)
        firsts = np.unravel_index(design.corners, basis.shape)
        self._cells = np.ravel_multi_index(firsts, n_cells)
        self._steps: list[Array] = []
        for j, (axis, m) in enumerate(zip(basis.axes, basis.shape, strict=True)):
            t = axis.knots
            steps = (t[basis.degree + 1 : basis.degree + m] - t[1:m]) / basis.degree
            self._steps.append(steps.reshape([-1 if i == j else 1 for i in range(len(n_cells))]))

    def __call__(self, change: Array) -> Array:
        """Return the bounds (N,) for a change of the coefficients (prod(m_i),)."""
        change = change.reshape(self._shape)
        result = np.zeros(len(self._cells))
        for j, (levers, steps) in enumerate(zip(self._levers, self._steps, strict=True)):
            slopes = np.abs(np.diff(change, axis=j)) / steps
            for axis in range(change.ndim):
                slopes = _greatest(slopes, axis, self._degree + (axis != j))
            result += levers * slopes.ravel().take(self._cells)
        return result


def _greatest(x: Array, axis: int, width: int) -> Array:
    """Return the greatest of ``width`` neighbours along an axis, of each run of them."""
    done = 1
    while done < width:
        further = min(done, width - done)
        before = (slice(None),) * axis
        x = np.maximum(x[(*before, slice(None, -further))], x[(*before, slice(further, None))])
        done += further
    return x

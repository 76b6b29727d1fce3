"""How far the descent quantity can move at points when coefficients change.

The slope of a spline along a dimension is a spline of a degree less there, whose coefficients are
scaled differences of the spline's own (de Boor 2001, A Practical Guide to Splines, ch. X). At
a point it is a mean of those that reach there. So with a change d of the coefficients

    |(z - z_goal) . grad chi| moves by at most sum_j |z - z_goal|_j max |scaled differences of d|,

the greatest over the patch of the point. Where the descent condition is far from failing it need
not be looked at again until the coefficients have changed by that much.
"""

from math import prod

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
        low, high = goals.min(axis=0), goals.max(axis=0)
        self._levers = np.maximum(np.abs(points - low), np.abs(points - high)).T.copy()
        self._corners, self._degree = design.corners, basis.degree
        # Neighbours along a dimension are so many places apart in the stack of coefficients.
        self._strides = [prod(basis.shape[j + 1 :]) for j in range(len(basis.shape))]
        self._scales: list[Array] = []
        for axis, m, stride in zip(basis.axes, basis.shape, self._strides, strict=True):
            t = axis.knots
            steps = (t[basis.degree + 1 : basis.degree + m] - t[1:m]) / basis.degree
            scales = np.append(1.0 / steps, 0.0)  # from the last there is no step
            places = np.arange(basis.n_coefficients - stride) // stride % m
            self._scales.append(scales[places])

    def __call__(self, change: Array) -> Array:
        """Return the bounds (N,) for a change of the coefficients (prod(m_i),)."""
        result = np.zeros(len(self._corners))
        for along, levers, scales in zip(self._strides, self._levers, self._scales, strict=True):
            slopes = np.abs(change[along:] - change[:-along]) * scales
            for stride in self._strides:
                # Runs that reach over an end of a dimension begin at no point's corner.
                slopes = _greatest(slopes, stride, self._degree + (stride != along))
            result += levers * slopes.take(self._corners)
        return result


def _greatest(x: Array, stride: int, width: int) -> Array:
    """Return the greatest of each ``width`` numbers of an array (m,), ``stride`` places apart."""
    done = 1
    while done < width:
        further = min(done, width - done)
        x = np.maximum(x[: -further * stride], x[further * stride :])
        done += further
    return x

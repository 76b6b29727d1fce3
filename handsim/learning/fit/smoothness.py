"""The penalty on rough coefficients that both learners add to their cost."""

import numpy as np

from handsim.reproducible import dot
from handsim.types import Array


def second_differences(c: Array) -> tuple[float, Array]:
    """Return the sum of squared second differences along every dimension, and its gradient by c.

    The P-spline penalty of Eilers and Marx (1996), Stat. Sci. 11(2):89-121.
    """
    value, gradient = 0.0, np.zeros_like(c)
    for axis in range(c.ndim):
        along, by_along = np.moveaxis(c, axis, 0), np.moveaxis(gradient, axis, 0)
        bend = along[2:] - 2.0 * along[1:-1] + along[:-2]
        value += dot(bend.ravel(), bend.ravel())
        by_along[2:] += 2.0 * bend
        by_along[1:-1] -= 4.0 * bend
        by_along[:-2] += 2.0 * bend
    return value, gradient

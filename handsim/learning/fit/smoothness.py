"""The penalty on rough coefficients that both learners add to their cost."""

from functools import lru_cache
from math import prod

import numpy as np

from handsim.reproducible import dot
from handsim.types import Array, Index, Mask


def second_differences(c: Array) -> tuple[float, Array]:
    """Return the sum of squared second differences along every dimension, and its gradient by c.

    The P-spline penalty of Eilers and Marx (1996), Stat. Sci. 11(2):89-121.
    """
    flat = np.ascontiguousarray(c).ravel()
    value, gradient, twice = 0.0, np.zeros(len(flat)), 2.0 * flat
    for axis in range(c.ndim):
        step, inside, order = _neighbours(c.shape, axis)
        if not len(order):
            continue
        first, middle, last = slice(None, -2 * step), slice(step, -step), slice(2 * step, None)
        bend = flat[last] - twice[middle] + flat[first]
        own = bend.take(order)
        value += dot(own, own)
        bend *= inside
        bend *= 2.0
        gradient[last] += bend
        gradient[middle] -= 2.0 * bend
        gradient[first] += bend
    return value, gradient.reshape(c.shape)


@lru_cache(maxsize=32)
def _neighbours(shape: tuple[int, ...], axis: int) -> tuple[int, Mask, Index]:
    """Return how neighbours along an axis lie to one another in the stack of an array.

    They are some places apart. Of the second differences of all places so far apart, some reach
    over an end of the axis: which do not, and where those are, the axis slowest.
    """
    step = prod(shape[axis + 1 :])
    n_along = shape[axis]
    place = np.arange(max(prod(shape) - 2 * step, 0))
    inside = place // step % n_along < n_along - 2
    whole = np.arange(prod(shape)).reshape(shape)
    order = np.moveaxis(whole, axis, 0)[: max(n_along - 2, 0)].ravel()
    return step, inside, order

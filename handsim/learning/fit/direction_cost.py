"""The cost of directions that both fits of directions minimise."""

import numpy as np

from handsim.reproducible import dots, mean, norms
from handsim.types import Array

_TINY = 1e-12  # length of a flow below which its direction is noise


def direction_cost(flow: Array, wanted: Array) -> tuple[float, Array]:
    """Return the mean of 1 - cos(angle between vectors), and its slope (N, n) by the first.

    Parameters
    ----------
    flow : (N, n)
    wanted : (N, n)
        Unit vectors.
    """
    length = np.maximum(norms(flow), _TINY)
    unit = flow / length
    cosine = dots(unit, wanted)[:, None]
    slope = (cosine * unit - wanted) / (length * len(unit))
    return float(mean(1.0 - cosine)[0]), slope

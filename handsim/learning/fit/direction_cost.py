"""The cost of directions that both fits of directions minimise."""

import numpy as np

from handsim.reproducible import mean, total
from handsim.types import Array

_TINY = 1e-12  # length of a flow below which its direction is noise


def direction_cost(flow: Array, wanted: Array) -> tuple[float, Array]:
    """Return the mean of 1 - cos(angle between vectors), and its slope (n, N) by the first.

    Parameters
    ----------
    flow : (n, N)
    wanted : (n, N)
        Unit vectors.
    """
    length = np.maximum(np.sqrt(total(flow * flow)), _TINY)
    unit = flow / length
    cosine = total(unit * wanted)
    slope = (cosine * unit - wanted) / (length * len(cosine))
    return float(mean(1.0 - cosine)), slope

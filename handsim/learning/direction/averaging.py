"""Averages of movements whose ends are near to each other.

How a movement departs from the straight segment between its ends depends partly on the ends and
partly on chance. Chance differs between movements with neighbouring ends. Therefore a recording is
replaced by the weighted mean of their departures, added to its own segment: a kernel regression
over start and destination (Nadaraya 1964, Theory Probab. Appl. 9(1):141-142). The paper does not
average.
"""

import numpy as np

from handsim.navigation.metric import gaussian_kernel
from handsim.navigation.paths import N_COMPARED, at_arc_length
from handsim.reproducible import exact_product
from handsim.types import Array

_OWN = 1.0  # added to the weight of a recording in its own mean, which then is 2
_AT_ONCE = 500  # recordings whose weights are held in memory together


def averaged(paths: list[Array], reach: float) -> list[Array]:
    """Return paths (100, n) with the same ends, averaged over paths with ends near to them.

    Parameters
    ----------
    paths
        Recorded paths (n_i, n) in the subspace [rad].
    reach : [rad]
        Standard deviation of the Gaussian weight by distance of starts and destinations; 0 averages
        nothing.
    """
    if reach <= 0.0:
        return paths
    s = np.linspace(0.0, 1.0, N_COMPARED)
    even = np.array([at_arc_length(path, s) for path in paths])
    ends = np.hstack([even[:, 0], even[:, -1]])
    straight = even[:, :1] + s[:, None] * (even[:, -1:] - even[:, :1])
    departures = (even - straight).reshape(len(even), -1)
    with_ones = np.hstack([departures, np.ones((len(even), 1))])
    result = np.empty_like(departures)
    for first in range(0, len(even), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        weights = gaussian_kernel(ends[some], ends, reach)
        rows = np.arange(len(weights))
        weights[rows, first + rows] += _OWN
        sums = exact_product(weights, with_ones)
        result[some] = sums[:, :-1] / sums[:, -1:]
    return list(straight + result.reshape(straight.shape))

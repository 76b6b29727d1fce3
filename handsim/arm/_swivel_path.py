"""The cheapest swivel along a movement: over a grid first, then smooth in between."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from handsim.types import Array, Index

_TURN_SPREAD = np.deg2rad(40.0)
"""Change of the swivel from one knot to the next that costs 1 [rad]."""


def smooth_swivel(cost: Array, swivels: Array, rows: Index, n: int) -> Array:
    """Return a swivel for each time, (n,) [rad].

    Parameters
    ----------
    cost : (k, m)
        Of each of m swivels at each of k knots.
    swivels : (m,) [rad]
        Equally spaced.
    rows : (k,)
        Rows of the knots, from 0 to n - 1.
    n
        Number of times.
    """
    best = _cheapest(cost, ((swivels - swivels[:, None]) / _TURN_SPREAD) ** 2)
    chosen = swivels[best] + _offset(cost, best) * (swivels[1] - swivels[0])
    if len(chosen) > 2:  # the steps of the grid are not to be felt
        inner = 0.25 * chosen[:-2] + 0.5 * chosen[1:-1] + 0.25 * chosen[2:]
        chosen = np.concatenate([chosen[:1], inner, chosen[-1:]])
    if len(rows) == 1:
        return np.full(n, chosen[0])
    return np.asarray(PchipInterpolator(rows, chosen)(np.arange(n)))


def _cheapest(cost: Array, change: Array) -> Index:
    """Return the column at each knot such that costs and changes sum to the least (Viterbi)."""
    before = np.zeros(cost.shape, dtype=np.int64)
    total = cost[0]
    for i in range(1, len(cost)):
        ways = total[:, None] + change
        before[i] = np.argmin(ways, axis=0)
        total = cost[i] + ways[before[i], np.arange(cost.shape[1])]
    best = np.zeros(len(cost), dtype=np.int64)
    best[-1] = int(np.argmin(total))
    for i in range(len(cost) - 1, 0, -1):
        best[i - 1] = before[i, best[i]]
    return best


def _offset(cost: Array, best: Index) -> Array:
    """Return where the parabola through a cost and its neighbours is least, in steps, (k,)."""
    knots, inner = np.arange(len(best)), np.clip(best, 1, cost.shape[1] - 2)
    left, middle, right = (cost[knots, inner + j] for j in (-1, 0, 1))
    bend = left - 2 * middle + right
    step = np.where(bend > 0, 0.5 * (left - right) / np.where(bend > 0, bend, 1.0), 0.0)
    return np.where(inner == best, np.clip(step, -0.5, 0.5), 0.0)

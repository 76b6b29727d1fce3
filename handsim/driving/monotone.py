"""Monotone regression by pooling adjacent violators.

R. E. Barlow and others (1972), "Statistical inference under order restrictions", section 1.2: of
all sequences that do not decrease, the one with the least sum of weighted squared deviations.
"""

import numpy as np

from handsim.types import Array


def isotonic(y: Array, weights: Array | None = None) -> Array:
    """Return the values (n,) that do not decrease and are nearest to ``y`` (n,).

    Parameters
    ----------
    y : (n,)
    weights : (n,), positive
        By default all the same.
    """
    given = np.ones(len(y)) if weights is None else weights
    means: list[float] = []
    sums: list[float] = []
    counts: list[int] = []
    for value, weight in zip(y.tolist(), given.tolist(), strict=True):
        mean, total, count = value, weight, 1
        while means and means[-1] >= mean:
            before = sums.pop()
            mean = (means.pop() * before + mean * total) / (before + total)
            total += before
            count += counts.pop()
        means.append(mean)
        sums.append(total)
        counts.append(count)
    return np.repeat(means, counts)


def isotonic_fit(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a function of ``x`` (n,) that does not decrease and is nearest to ``y`` (n,).

    Returns
    -------
    knots : (m,), increasing
    values : (m,)
        To be interpolated between.
    """
    knots, place = np.unique(x, return_inverse=True)
    counts = np.bincount(place).astype(float)
    return knots, isotonic(np.bincount(place, weights=y) / counts, counts)

"""Paths in the subspace: arc length, resampling, distance between paths, following a flow."""

import numpy as np

from handsim.reproducible import dots, mean, norms
from handsim.types import Array

N_COMPARED = 100
"""Points at which two paths are compared."""


def arc_length(path: Array) -> Array:
    """Return the arc length (n,) from the first point of a path (n, d)."""
    steps = norms(np.diff(path, axis=0))[:, 0]
    return np.concatenate([[0.0], np.cumsum(steps)])


def at_arc_length(path: Array, fractions: Array) -> Array:
    """Return the points (m, d) at fractions (m,) of the length of a path (n, d)."""
    length = arc_length(path)
    wanted: Array = fractions * length[-1]
    last = len(path) - 1
    before = np.clip(np.searchsorted(length, wanted, side="right") - 1, 0, max(last - 1, 0))
    after = np.minimum(before + 1, last)
    step = length[after] - length[before]
    share = ((wanted - length[before]) / np.where(step > 0.0, step, 1.0))[:, None]
    between = path[before] + share * (path[after] - path[before])
    return np.where(share >= 1.0, path[after], between)  # the end is the end, to the bit


def path_error(path: Array, reference: Array) -> float:
    """Return the root-mean-square distance of two paths, each over its own arc length [rad].

    Both are resampled at 100 points equally spaced in arc length normalised to [0, 1], as in the
    paper's Fig. 7.
    """
    fractions = np.linspace(0.0, 1.0, N_COMPARED)
    apart = at_arc_length(path, fractions) - at_arc_length(reference, fractions)
    return float(np.sqrt(mean(dots(apart, apart))))


def between_ends(path: Array, start: Array, goal: Array) -> Array:
    """Return a path (100, d) equally spaced in arc length, its ends moved to others (d,).

    The displacement of the ends is spread linearly over arc length.
    """
    s = np.linspace(0.0, 1.0, N_COMPARED)[:, None]
    even = at_arc_length(path, s[:, 0])
    return even + (1.0 - s) * (start - path[0]) + s * (goal - path[-1])

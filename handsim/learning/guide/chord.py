"""Paths as graphs over their chord, the straight segment from start to destination.

Where progress is no coordinate of its own, it is told by the place: by how far along the chord the
place lies. A path is then the departure from the chord, at right angles to it, as a function of the
covered fraction of the chord. It cannot go back along the chord, nor stop there and turn.
"""

import numpy as np

from handsim.learning.guide.curve import interpolated
from handsim.reproducible import dots
from handsim.types import Array


def graphs(paths: Array) -> Array:
    """Return the departures (N, m, n) of paths (N, m, n) at m equal fractions of their chords.

    Where a path goes back along its chord, the graph waits until it has passed that place again.
    """
    fractions = np.linspace(0.0, 1.0, paths.shape[1])
    return np.array([_graph(path, fractions) for path in paths])


def _graph(path: Array, fractions: Array) -> Array:
    chord = path[-1] - path[0]
    away = path - path[0]
    covered = dots(away, chord) / (float(dots(chord, chord)) or 1.0)
    farthest = np.maximum.accumulate(np.clip(covered, 0.0, 1.0))
    new = np.append(True, np.diff(farthest) > 0.0)
    departure = interpolated(fractions, farthest[new], across(away, chord)[new])
    departure[[0, -1]] = 0.0
    return departure


def across(vectors: Array, chord: Array) -> Array:
    """Return the parts (m, n) of vectors (m, n) at right angles to a chord (n,); all if it is 0."""
    along = dots(vectors, chord) / (float(dots(chord, chord)) or 1.0)
    return vectors - along[:, None] * chord

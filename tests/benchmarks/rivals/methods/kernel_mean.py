"""Mean of whole recorded paths, their ends moved to those asked for, by how near they were."""

from collections.abc import Sequence
from typing import Self

import numpy as np

from handsim.navigation.paths import between_ends
from handsim.types import Array

from ..protocol import Motion, Movement, Query, Rival, timed

_REACH = np.deg2rad(30.0)  # the best of some on four people, left out


class KernelMean(Rival):
    """A Gaussian kernel over both ends; paths and progress over time are averaged with it.

    Parameters
    ----------
    across
        What movements of other objects count, relative to those of the object asked for; 1 knows
        nothing of objects.
    reach : [rad]
        Width of the kernel.
    """

    argument = "a path, which ends there"

    def __init__(self, across: float = 1.0, reach: float = _REACH) -> None:
        self.across, self.reach = across, reach

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Keep the movements."""
        self.movements = list(movements)
        self.progress = np.array([each.progress for each in movements])
        return self

    def predict(self, query: Query) -> Motion:
        """Return the mean of the paths, passed with the mean of their progress."""
        weights = self._weights(query)
        moved = [between_ends(each.path, query.start, query.goal) for each in self.movements]
        path = np.average(moved, axis=0, weights=weights)
        return timed(path, query.duration, np.average(self.progress, axis=0, weights=weights))

    def _weights(self, query: Query) -> Array:
        ends = np.array([np.append(each.path[0], each.path[-1]) for each in self.movements])
        squares = np.sum((ends - np.append(query.start, query.goal)) ** 2, axis=1)
        same = np.array([each.object == query.object for each in self.movements])
        known = np.where(same, 1.0, self.across)
        log_weights = np.log(np.maximum(known, 1e-300)) - 0.5 * squares / self.reach**2
        return np.exp(log_weights - log_weights.max())

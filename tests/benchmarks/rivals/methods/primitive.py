"""Dynamic movement primitives: one trial, imitated between other ends (Ijspeert et al. 2013)."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from movement_primitives.dmp import DMP

from ..protocol import Motion, Movement, Query, Rival
from ..scoring import resampled

_N_STEPS = 200
_N_WEIGHTS = 30  # a dimension


class MovementPrimitive(Rival):
    """The primitive of the recorded trial that is nearest.

    Its forcing terms fade with time, and what is left is a damped spring to the destination.

    Parameters
    ----------
    by_object
        Take the trial of the same object with the nearest ends; else the one of all that has the
        nearest destination.
    """

    argument = "a spring, once forcing fades"

    def __init__(self, by_object: bool) -> None:
        self.by_object = by_object

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Imitate each trial, in a second."""
        self.movements = list(movements)
        self.primitives = [_imitated(each) for each in movements]
        return self

    def predict(self, query: Query) -> Motion:
        """Run the nearest primitive and stretch it to the duration."""
        dmp = self.primitives[self._nearest(query)]
        dmp.reset()
        dmp.configure(start_y=query.start, goal_y=query.goal)
        time, path = dmp.open_loop()
        return Motion(np.asarray(path), np.asarray(time) * (query.duration / time[-1]))

    def _nearest(self, query: Query) -> int:
        away = np.array([np.sum((each.path[-1] - query.goal) ** 2) for each in self.movements])
        same = np.array([each.object == query.object for each in self.movements])
        if not self.by_object or not same.any():
            return int(np.argmin(away))
        away += [np.sum((each.path[0] - query.start) ** 2) for each in self.movements]
        return int(np.argmin(np.where(same, away, np.inf)))


def _imitated(movement: Movement) -> DMP:
    even = np.linspace(0.0, 1.0, _N_STEPS)
    share = (movement.time - movement.time[0]) / movement.duration
    path = resampled(share, movement.path, even)
    dmp = DMP(path.shape[1], 1.0, dt=1.0 / (_N_STEPS - 1), n_weights_per_dim=_N_WEIGHTS)
    dmp.imitate(even, path)
    return dmp

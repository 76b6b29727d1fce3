"""What a rival is given and what it answers: movements to learn from, a query, a motion.

All are in the coordinates in which movements are compared: principal components of the hand's
joints, or the plane of a pen. A radian there is the unit of length.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from handsim.learning.movement.progress import minimum_jerk
from handsim.navigation.paths import arc_length
from handsim.types import Array

PROGRESS_TIMES = np.linspace(0.0, 1.0, 51)
"""Times, as fractions of the duration, at which progress along a path is held."""


@dataclass(frozen=True, eq=False)
class Movement:
    """A recorded movement.

    Attributes
    ----------
    object
        Name of what was reached for.
    path : (n, d) [rad], time : (n,) [s]
    """

    object: str
    path: Array
    time: Array

    @property
    def duration(self) -> float:
        """From the first to the last frame [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def progress(self) -> Array:
        """Fraction of the length covered at `PROGRESS_TIMES`, (51,)."""
        length = arc_length(self.path)
        if length[-1] == 0.0:
            return np.ones(len(PROGRESS_TIMES))
        share = (self.time - self.time[0]) / self.duration
        return np.interp(PROGRESS_TIMES, share, length / length[-1])


@dataclass(frozen=True, eq=False)
class Query:
    """What is asked for.

    Attributes
    ----------
    start, goal : (d,) [rad]
    object
        Name of what is reached for; rivals that know nothing of objects do not look at it.
    duration : [s]
    """

    start: Array
    goal: Array
    object: str
    duration: float


@dataclass(frozen=True, eq=False)
class Motion:
    """The answer: where the hand is at which time.

    Attributes
    ----------
    path : (m, d) [rad], time : (m,) [s], from 0 to the duration
    """

    path: Array
    time: Array


class Rival:
    """Base of all rivals: one call learns, another answers.

    Attributes
    ----------
    argument
        Why movements arrive, in a few words; empty where nothing is known.
    saved : [s]
        CPU time of the fit that was not spent, as its result was known from another rival.
    """

    argument = ""
    saved = 0.0

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn from movements, each ending at its destination."""
        raise NotImplementedError

    def predict(self, query: Query) -> Motion:
        """Answer one query."""
        raise NotImplementedError

    def predict_all(self, queries: Sequence[Query]) -> list[Motion]:
        """Answer many; those that are quicker all together say how."""
        return [self.predict(query) for query in queries]

    def proves(self, query: Query) -> bool:
        """Whether the answer is known to arrive before it is made, by `argument`."""
        return bool(self.argument)


def timed(path: Array, duration: float, progress: Array | None = None) -> Motion:
    """Pass a path (m, d) in a duration [s]; with minimum jerk where no progress (51,) is given."""
    time = PROGRESS_TIMES * duration
    covered = minimum_jerk(time, duration) if progress is None else progress
    length = arc_length(path)
    wanted = covered * length[-1]
    # Corners of the path have their own times beside the equally spaced ones.
    at = np.union1d(time, np.interp(length, wanted, time))
    passed = np.interp(at, time, wanted)
    columns: list[Array] = list(path.T)
    return Motion(np.column_stack([np.interp(passed, length, each) for each in columns]), at)

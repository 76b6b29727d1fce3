"""A Gaussian process over whole paths: how they depart from the straight segment."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from handsim.navigation.paths import N_COMPARED, at_arc_length
from handsim.types import Array, Mask

from ..protocol import Motion, Movement, Query, Rival, timed

_EVEN = np.linspace(0.0, 1.0, N_COMPARED)


@dataclass(frozen=True)
class Kernel:
    """Covariance of the departures of two movements, in units of their own variance.

    It is the product of Gaussian kernels over starts and destinations and of a number for
    different objects, to which a constant is added: a departure that all share.

    Attributes
    ----------
    start, goal : [rad]
        Reach of the Gaussian kernels.
    across
        For different objects, 1 for the same.
    shared, noise
        The constant, and the variance of what each movement has of its own.
    """

    start: float
    goal: float
    across: float
    shared: float = 0.3
    noise: float = 0.3

    def __call__(self, ends: Array, others: Array, same: Mask) -> Array:
        """Return covariances (N, M) of movements with ends (N, 2, d) and (M, 2, d)."""
        squares = np.sum((ends[:, None] - others[None]) ** 2, axis=3)
        reach = np.array([self.start, self.goal])
        near = np.exp(-0.5 * np.sum(squares / reach**2, axis=2))
        return near * np.where(same, 1.0, self.across) + self.shared


# Each the best of 600 by the error on trials left out of four people.
KNOWN = Kernel(np.deg2rad(70.0), np.deg2rad(45.0), 0.2)
UNKNOWN = Kernel(np.deg2rad(45.0), np.deg2rad(45.0), 1.0)


class PathProcess(Rival):
    """Mean of the process at the ends asked for; progress over time by the same process.

    Parameters
    ----------
    kernel
        `KNOWN` or `UNKNOWN`, as the object is.
    """

    argument = "a path, which ends there"

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Solve for the weights of each movement."""
        paths = np.array([at_arc_length(each.path, _EVEN) for each in movements])
        self.ends = paths[:, [0, -1]]
        self.objects = np.array([each.object for each in movements])
        progress = np.array([each.progress for each in movements])
        self.usual = progress.mean(axis=0)
        same = self.objects[:, None] == self.objects[None]
        covariance = self.kernel(self.ends, self.ends, same)
        covariance += self.kernel.noise * np.eye(len(paths))
        departures = (paths - _segments(self.ends)).reshape(len(paths), -1)
        # One solution for both: progress departs from its mean as paths from their segments.
        self.weights = np.linalg.solve(covariance, departures)
        self.progress_weights = np.linalg.solve(covariance, progress - self.usual)
        return self

    def predict(self, query: Query) -> Motion:
        """Return the mean path, passed with the mean progress."""
        ends = np.array([[query.start, query.goal]])
        covariance = self.kernel(ends, self.ends, (self.objects == query.object)[None])
        departure = (covariance @ self.weights).reshape(len(_EVEN), -1)
        progress = self.usual + (covariance @ self.progress_weights)[0]
        # A mean of progress with weights of both signs may turn back: people do not.
        progress = np.clip(np.maximum.accumulate(progress), 0.0, 1.0)
        progress[0], progress[-1] = 0.0, 1.0
        return timed(_segments(ends)[0] + departure, query.duration, progress)


def _segments(ends: Array) -> Array:
    """Return straight segments (N, 100, d) between ends (N, 2, d)."""
    s = _EVEN[:, None]
    return (1.0 - s) * ends[:, :1] + s * ends[:, 1:]

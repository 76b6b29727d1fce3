"""Scores of a motion beside the recorded one, and what is proven of it."""

from dataclasses import dataclass

import numpy as np

from handsim.navigation.flow import ARRIVAL
from handsim.navigation.paths import path_error
from handsim.types import Array

from .data import Space, Trial
from .protocol import Motion, Movement


@dataclass(frozen=True)
class Score:
    """How near a motion is to the recorded one.

    Attributes
    ----------
    error, straight
        Path error of the motion and of the straight segment, as `handsim evaluate` has it [rad].
    rms
        Root of the mean squared deviation over time and all that was recorded (22 joints), in the
        unit of the set.
    floor
        The same of the recorded movement itself, projected: what the components leave out.
    speed_correlation
        Of the speeds over time, norms over all that was recorded; NaN where one does not vary.
    arrived
        Whether the motion ends within 4 deg of the destination.
    proven
        Whether it is known to, without trying.
    """

    error: float
    straight: float
    rms: float
    floor: float
    speed_correlation: float
    arrived: bool
    proven: bool


def score(
    motion: Motion, trial: Trial, movement: Movement, space: Space, per_rad: float, proven: bool
) -> Score:
    """Compare a motion with a trial, whose projection is ``movement``."""
    made = space.lift(resampled(motion.time, motion.path, trial.time - trial.time[0]))
    projected = space.lift(movement.path)
    return Score(
        error=path_error(motion.path, movement.path),
        straight=path_error(movement.path[[0, -1]], movement.path),
        rms=per_rad * _rms(made - trial.q),
        floor=per_rad * _rms(projected - trial.q),
        speed_correlation=correlation(speeds(trial.time, trial.q), speeds(trial.time, made)),
        arrived=arrives(motion, movement.path[-1]),
        proven=proven,
    )


def _rms(deviation: Array) -> float:
    return float(np.sqrt(np.mean(deviation**2)))


def arrives(motion: Motion, goal: Array) -> bool:
    """Whether a motion ends within 4 deg of a destination."""
    return bool(np.linalg.norm(motion.path[-1] - goal) <= ARRIVAL)


def resampled(times: Array, path: Array, wanted: Array) -> Array:
    """Return the points of a path (n, d) passed at times (n,), at other times (m,)."""
    columns: list[Array] = list(path.T)
    return np.column_stack([np.interp(wanted, times, column) for column in columns])


def speeds(time: Array, q: Array) -> Array:
    """Return the speeds (n,) of what was recorded (n, m)."""
    velocities: Array = np.gradient(q, time, axis=0)
    return np.linalg.norm(velocities, axis=1)


def correlation(a: Array, b: Array) -> float:
    """Return Pearson's correlation, NaN where one of both does not vary."""
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / scale if scale > 1e-12 else float("nan")

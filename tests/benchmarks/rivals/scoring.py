"""Scores of a motion beside the recorded one, and what is proven of it."""

from dataclasses import dataclass

import numpy as np

from handsim.navigation.flow import ARRIVAL
from handsim.navigation.paths import path_error
from handsim.types import Array

from .data import Space, Trial
from .protocol import Motion, Movement

_EVEN = np.linspace(0.0, 1.0, 101)  # times at which movements are compared
_COARSE = np.linspace(0.0, 1.0, 51)  # times between which mean speeds are


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
        Of speeds along both paths over time; NaN where one of them does not move.
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
    share = (trial.time - trial.time[0]) / movement.duration
    recorded = resampled(share, trial.q, _EVEN)
    passed = motion.time / movement.duration
    made = space.lift(resampled(passed, motion.path, _EVEN))
    projected = space.lift(space.project(recorded))
    return Score(
        error=path_error(motion.path, movement.path),
        straight=path_error(movement.path[[0, -1]], movement.path),
        rms=per_rad * float(np.sqrt(np.mean((made - recorded) ** 2))),
        floor=per_rad * float(np.sqrt(np.mean((projected - recorded) ** 2))),
        speed_correlation=correlation(speeds(share, movement.path), speeds(passed, motion.path)),
        arrived=arrives(motion, movement.path[-1]),
        proven=proven,
    )


def arrives(motion: Motion, goal: Array) -> bool:
    """Whether a motion ends within 4 deg of a destination."""
    return bool(np.linalg.norm(motion.path[-1] - goal) <= ARRIVAL)


def resampled(share: Array, path: Array, wanted: Array) -> Array:
    """Return the points of a path (n, d) passed at times (n,), at other times (m,)."""
    columns: list[Array] = list(path.T)
    return np.column_stack([np.interp(wanted, share, column) for column in columns])


def speeds(share: Array, path: Array) -> Array:
    """Return mean speeds (50,) in equal parts of the duration."""
    return np.linalg.norm(np.diff(resampled(share, path, _COARSE), axis=0), axis=1)


def correlation(a: Array, b: Array) -> float:
    """Return Pearson's correlation, NaN where one of both does not vary."""
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / scale if scale > 1e-12 else float("nan")

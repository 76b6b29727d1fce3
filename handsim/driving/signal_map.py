"""From a signal to progress: a monotone map.

`fitted_map` makes it of recordings, each of which holds the signal at equally spaced progress.
Monotone regression makes that a signal that never goes back; its inverse says how far the person
had come when the signal left a value. The map is the two-thirds quantile of that over the
recordings. Why not the mean: where a hand closes after it has arrived, a distance says no more than
"here". A mean would stop half way; the quantile leads to the end, and `SignalMap.clock` gives the
speed at which people closed theirs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.driving.monotone import isotonic
from handsim.errors import InputError
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.learning.movement.progress import N_PROGRESS, minimum_jerk
from handsim.types import Array

QUANTILE = 2 / 3
_N_LEVELS = 201
_SLACK = (0.05, 0.5)  # least and greatest, as fractions of the range of levels
_SHORTEST_STEP = 1e-4  # of the clock, so that it never stands still [s]


@dataclass(frozen=True, eq=False)
class SignalMap:
    """What a signal says about progress.

    Attributes
    ----------
    channel
    rising
        Whether the signal grows along the movement.
    relative
        Whether it is taken as a share of its value at the start.
    levels : (m,), increasing
        Values of the signal, or shares; negative if it falls.
    progress : (m,), 0 to 1, not decreasing
        At these levels.
    clock : (101,) [s], increasing from 0
        Mean time at which people came to equally spaced progress.
    slack
        By how much the level has to go back before progress does.
    explained
        Share of the variance of progress, in recordings left out; None where the map was given.
    n_recordings
        From which it was found.
    """

    channel: str
    rising: bool
    relative: bool
    levels: Array
    progress: Array
    clock: Array
    slack: float
    explained: float | None
    n_recordings: int

    def level(self, value: float, start: float) -> float:
        """Return the level of a value, given that at the start of the movement."""
        share = value if not self.relative else value / start if start > 0 else 1.0
        return share if self.rising else -share

    def ahead(self, level: float) -> float:
        """Return the progress up to which a level leads."""
        return float(np.interp(level, self.levels, self.progress))

    def behind(self, level: float) -> float:
        """Return the progress down to which a level lets it go back; at rest that is 0."""
        at_rest = self.levels[int(np.searchsorted(self.progress, 0.0, side="right")) - 1]
        return self.ahead(level + min(self.slack, max(level - float(at_rest), 0.0)))

    def later(self, progress: float, seconds: float) -> float:
        """Return progress some time later, or earlier if negative, at people's mean speed."""
        now = float(np.interp(progress, SIGNAL_PROGRESS, self.clock))
        return float(np.interp(now + seconds, self.clock, SIGNAL_PROGRESS))


def fitted_map(
    demonstrations: Sequence[Demonstration],
    channel: str,
    *,
    rising: bool,
    relative: bool,
    explained: float | None = None,
) -> SignalMap:
    """Return the map of a signal, found from recordings that all hold it."""
    levels = levels_of(demonstrations, channel, rising=rising, relative=relative)
    knots, progress = _map_of(levels)
    slack = _slack_of(levels, knots)
    clock = mean_clock(demonstrations)
    return SignalMap(
        channel, rising, relative, knots, progress, clock, slack, explained, len(demonstrations)
    )


def map_between(
    demonstrations: Sequence[Demonstration], rest: float, grasp: float, channel: str = "value"
) -> SignalMap:
    """Return the map of a signal whose values at rest and at the grasp are known, linear between.

    Raises
    ------
    InputError
        If they are no two different finite numbers.
    """
    if not (np.isfinite([rest, grasp]).all() and rest != grasp):
        raise InputError(f"range from {rest:g} to {grasp:g}; give two different finite numbers")
    rising = grasp > rest
    levels = np.array([rest, grasp] if rising else [-rest, -grasp])
    return SignalMap(
        channel, rising, False, levels, np.array([0.0, 1.0]), mean_clock(demonstrations),
        _SLACK[0] * abs(grasp - rest), None, 0,
    )  # fmt: skip


def times_at_progress(demonstration: Demonstration) -> Array:
    """Return the times (101,) [s] at which a person came to equally spaced progress."""
    progress = demonstration.progress
    if progress is None:  # a file of an earlier version
        progress = minimum_jerk(np.linspace(0.0, 1.0, N_PROGRESS), 1.0)
    time = np.linspace(0.0, demonstration.duration, len(progress))
    new = np.append(True, np.diff(progress) > 0)
    return np.interp(SIGNAL_PROGRESS, progress[new], time[new])


def mean_clock(demonstrations: Sequence[Demonstration]) -> Array:
    """Return the mean time (101,) [s] at which people came to equally spaced progress."""
    times = [times_at_progress(d) for d in demonstrations]
    steps = np.maximum(np.diff(np.mean(times, axis=0)), _SHORTEST_STEP)
    return np.append(0.0, np.cumsum(steps))


def levels_of(
    demonstrations: Sequence[Demonstration], channel: str, *, rising: bool, relative: bool
) -> Array:
    """Return the levels (n, 101) of a signal at equally spaced progress."""
    signals = np.array([d.signals[channel] for d in demonstrations])
    shares = signals / signals[:, :1] if relative else signals
    return shares if rising else -shares


def _map_of(levels: Array) -> tuple[Array, Array]:
    """Return levels (m,) and the progress at them, from those of recordings (n, 101)."""
    monotone = [isotonic(each) for each in levels]
    low = min(float(each[0]) for each in monotone)
    high = max(float(each[-1]) for each in monotone)
    knots = np.linspace(low, high, _N_LEVELS)
    reached = np.array([_reached(each, knots) for each in monotone])
    return knots, np.quantile(reached, QUANTILE, axis=0)


def _reached(monotone: Array, levels: Array) -> Array:
    """Return how far one recording had come when its signal left each level.

    Nowhere, as long as the signal is what it was at the start.
    """
    last = np.searchsorted(monotone, levels, side="right") - 1
    here = np.clip(last, 0, len(monotone) - 2)
    step = np.maximum(monotone[here + 1] - monotone[here], np.finfo(float).tiny)
    share = np.where(last > here, 1.0, np.minimum((levels - monotone[here]) / step, 1.0))
    reached = (here + share) / (len(monotone) - 1)
    return np.where(levels > monotone[0], reached, 0.0)


def _slack_of(levels: Array, knots: Array) -> float:
    """Return by how much two thirds of the recorded signals go back at most, within bounds."""
    back = np.max(np.maximum.accumulate(levels, axis=1) - levels, axis=1)
    least, greatest = (fraction * float(knots[-1] - knots[0]) for fraction in _SLACK)
    return float(np.clip(np.quantile(back, QUANTILE), least, greatest))

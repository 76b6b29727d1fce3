"""From a signal to progress: a monotone map, found from recordings.

Each recording holds the signal at equally spaced progress. Monotone regression makes it a signal
that never goes back; its inverse says how far the person had come when the signal left a value.
The map is the two-thirds quantile of that over the recordings. Why not the mean: where a hand
closes after it has arrived, a distance says no more than "here". A mean would stop half way; the
quantile leads to the end, and `SignalMap.clock` gives the speed at which people closed theirs.
Rising or falling, and whether a falling signal counts as it is or as a share of what it was at the
start, is what says more about progress in recordings left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.driving.monotone import isotonic, isotonic_fit
from handsim.errors import InputError, UnknownNameError
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.types import Array

LEAST_EXPLAINED = 0.1
"""Share of the variance of progress that a signal has to explain in recordings left out."""
QUANTILE = 2 / 3
_N_LEVELS = 201
_MOST_FOLDS = 10
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


def calibrate_signal(demonstrations: Sequence[Demonstration], channel: str) -> SignalMap:
    """Find what a signal says about progress.

    Parameters
    ----------
    demonstrations
        Those that hold the channel are used.
    channel

    Raises
    ------
    UnknownNameError
        If none holds the channel.
    InputError
        If the signal tells nothing about progress.
    """
    used = [d for d in demonstrations if channel in d.signals]
    if not used:
        raise _no_channel(channel, demonstrations)
    signals = np.array([d.signals[channel] for d in used])
    ways = [(False, False), (True, False)]
    if (signals[:, 0] > 0).all():
        ways.insert(1, (False, True))
    explained = [_explained(_levels(signals, *way)) for way in ways]
    best = int(np.argmax(explained))
    if explained[best] < LEAST_EXPLAINED:
        raise InputError(
            f"channel {channel} says too little about progress: {100 * explained[best]:.0f} % of "
            f"its variance in {len(used)} recordings, at least {100 * LEAST_EXPLAINED:.0f} % are "
            "needed; name another with --channel, or give its values at rest and at the grasp "
            "with --range"
        )
    rising, relative = ways[best]
    levels = _levels(signals, rising, relative)
    knots, progress = _map_of(levels)
    return SignalMap(
        channel, rising, relative, knots, progress, mean_clock(used), _slack_of(levels, knots),
        explained[best], len(used),
    )  # fmt: skip


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


def mean_clock(demonstrations: Sequence[Demonstration]) -> Array:
    """Return the mean time (101,) [s] at which people came to equally spaced progress."""
    times: list[Array] = []
    for d in demonstrations:
        time = np.linspace(0.0, d.duration, len(d.progress))
        new = np.append(True, np.diff(d.progress) > 0)
        times.append(np.interp(SIGNAL_PROGRESS, d.progress[new], time[new]))
    steps = np.maximum(np.diff(np.mean(times, axis=0)), _SHORTEST_STEP)
    return np.append(0.0, np.cumsum(steps))


def _levels(signals: Array, rising: bool, relative: bool) -> Array:
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
    return np.where(levels > monotone[0], SIGNAL_PROGRESS[np.maximum(last, 0)], 0.0)


def _slack_of(levels: Array, knots: Array) -> float:
    """Return by how much two thirds of the recorded signals go back at most, within bounds."""
    back = np.max(np.maximum.accumulate(levels, axis=1) - levels, axis=1)
    least, greatest = (fraction * float(knots[-1] - knots[0]) for fraction in _SLACK)
    return float(np.clip(np.quantile(back, QUANTILE), least, greatest))


def _explained(levels: Array) -> float:
    """Return the share of the variance of progress that levels explain in recordings left out.

    Of a single recording, in itself.
    """
    n = len(levels)
    fold = np.arange(n) % min(n, _MOST_FOLDS)
    missed = 0.0
    for left_out in range(int(fold.max()) + 1):
        known = levels[fold != left_out] if n > 1 else levels
        told = levels[fold == left_out]
        knots, values = isotonic_fit(known.ravel(), np.tile(SIGNAL_PROGRESS, len(known)))
        missed += float(np.sum((np.interp(told, knots, values) - SIGNAL_PROGRESS) ** 2))
    return 1.0 - missed / (n * len(SIGNAL_PROGRESS) * float(np.var(SIGNAL_PROGRESS)))


def _no_channel(channel: str, demonstrations: Sequence[Demonstration]) -> InputError:
    known = tuple(dict.fromkeys(name for d in demonstrations for name in d.signals))
    if known:
        return UnknownNameError("channel of the recordings", channel, known)
    return InputError(
        f"channel {channel}: the recordings that the controller was learned from hold no channels; "
        "give the values at rest and at the grasp with --range, or learn from recordings with it"
    )

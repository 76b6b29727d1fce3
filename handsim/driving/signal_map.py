"""From a signal to the phase of a movement: a monotone map.

The phase is the fraction of the movement's time that has gone by when people are where the hand
is; the controller's timing makes progress along the path of it. `fitted_map` makes the map of
recordings. Monotone regression makes each recorded signal one that never goes back; its inverse
says how far the person was when the signal left a value. The map is the 0.8 quantile of that over
the recordings. Why not the mean: where a hand closes after it has arrived, a distance says no more
than "here". A mean would stop half way; the quantile leads to the end, and the pace of people
(`handsim.driving.pace`) says how fast.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.driving.monotone import isotonic
from handsim.driving.pace import Pace, fitted_pace, steady_pace
from handsim.errors import InputError
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.learning.movement.progress import N_PROGRESS, minimum_jerk
from handsim.types import Array

PHASES = np.linspace(0.0, 1.0, 101)
"""Phases at which signals and progress are compared."""
QUANTILE = 0.8
_MARKS = np.linspace(0.1, 0.9, 9)  # median phases at whose levels the pace is told
_N_LEVELS = 201
_SLACK = (0.05, 0.5)  # least and greatest, as fractions of the range of levels


@dataclass(frozen=True, eq=False)
class SignalMap:
    """What a signal says about the phase of a movement.

    Attributes
    ----------
    channel
    rising
        Whether the signal grows along the movement.
    relative
        Whether it is taken as a share of its value at the start.
    levels : (m,), increasing
        Values of the signal, or shares; negative if it falls.
    phase : (m,), 0 to 1, not decreasing
        At these levels.
    curve : (101,), 0 to 1, not decreasing
        Mean progress of people at equally spaced phases.
    pace
    slack
        By how much the level has to go back before the phase does.
    explained
        Share of the variance of progress, in recordings left out; None where the map was given.
    n_recordings
        From which it was found.
    """

    channel: str
    rising: bool
    relative: bool
    levels: Array
    phase: Array
    curve: Array
    pace: Pace
    slack: float
    explained: float | None
    n_recordings: int

    def level(self, value: float, start: float) -> float:
        """Return the level of a value, given that at the start of the movement."""
        share = value if not self.relative else value / start if start > 0 else 1.0
        return share if self.rising else -share

    def ahead(self, level: float) -> float:
        """Return the phase up to which a level leads."""
        return float(np.interp(level, self.levels, self.phase))

    def behind(self, level: float) -> float:
        """Return the phase down to which a level lets it go back; at rest that is 0."""
        at_rest = self.levels[int(np.searchsorted(self.phase, 0.0, side="right")) - 1]
        return self.ahead(level + min(self.slack, max(level - float(at_rest), 0.0)))


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
    durations = np.array([d.duration for d in demonstrations])
    phases = np.array([times_at_progress(d) for d in demonstrations]) / durations[:, None]
    over_time = [np.interp(PHASES, x, y) for x, y in zip(phases, levels, strict=True)]
    monotone = np.array([isotonic(each) for each in over_time])
    knots = np.linspace(monotone[:, 0].min(), monotone[:, -1].max(), _N_LEVELS)
    reached = np.array([_reached(each, knots) for each in monotone])
    middle = np.median(reached, axis=0)
    marks = knots[np.minimum(np.searchsorted(middle, _MARKS), _N_LEVELS - 1)]
    return SignalMap(
        channel=channel,
        rising=rising,
        relative=relative,
        levels=knots,
        phase=np.quantile(reached, QUANTILE, axis=0),
        curve=mean_progress(demonstrations),
        pace=fitted_pace(monotone, durations, marks),
        slack=_slack_of(levels, knots),
        explained=explained,
        n_recordings=len(demonstrations),
    )


def map_between(
    demonstrations: Sequence[Demonstration], rest: float, grasp: float, channel: str = "value"
) -> SignalMap:
    """Return the map of a signal whose values at rest and at the grasp are known.

    Progress is linear between them, for people's mean timing.

    Raises
    ------
    InputError
        If they are no two different finite numbers.
    """
    if not (np.isfinite([rest, grasp]).all() and rest != grasp):
        raise InputError(f"range from {rest:g} to {grasp:g}; give two different finite numbers")
    rising = grasp > rest
    curve = mean_progress(demonstrations)
    new = np.append(True, np.diff(curve) > 0)
    return SignalMap(
        channel=channel,
        rising=rising,
        relative=False,
        levels=np.linspace(*((rest, grasp) if rising else (-rest, -grasp)), _N_LEVELS),
        phase=np.interp(np.linspace(0.0, 1.0, _N_LEVELS), curve[new], PHASES[new]),
        curve=curve,
        pace=steady_pace(np.array([d.duration for d in demonstrations])),
        slack=_SLACK[0] * abs(grasp - rest),
        explained=None,
        n_recordings=0,
    )


def progress_of(demonstration: Demonstration) -> Array:
    """Return the progress (51,) of a recording; minimum jerk for files of earlier versions."""
    if demonstration.progress is None:
        return minimum_jerk(np.linspace(0.0, 1.0, N_PROGRESS), 1.0)
    return demonstration.progress


def times_at_progress(demonstration: Demonstration) -> Array:
    """Return the times (101,) [s] at which a person came to equally spaced progress."""
    progress = progress_of(demonstration)
    time = np.linspace(0.0, demonstration.duration, len(progress))
    new = np.append(True, np.diff(progress) > 0)
    return np.interp(SIGNAL_PROGRESS, progress[new], time[new])


def mean_progress(demonstrations: Sequence[Demonstration]) -> Array:
    """Return the mean progress (101,) of people at equally spaced phases."""
    even = np.linspace(0.0, 1.0, N_PROGRESS)
    return np.mean([np.interp(PHASES, even, progress_of(d)) for d in demonstrations], axis=0)


def levels_of(
    demonstrations: Sequence[Demonstration], channel: str, *, rising: bool, relative: bool
) -> Array:
    """Return the levels (n, 101) of a signal at equally spaced progress."""
    signals = np.array([d.signals[channel] for d in demonstrations])
    shares = signals / signals[:, :1] if relative else signals
    return shares if rising else -shares


def _reached(monotone: Array, levels: Array) -> Array:
    """Return how far one recording was when its signal left each level.

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
    return float(np.clip(np.quantile(back, 2 / 3), least, greatest))

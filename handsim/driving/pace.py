"""How long a movement will take, by how soon its signal came to some levels.

Who comes soon half way arrives soon. For each of some levels a line is fitted to the recordings:
logarithm of the duration over that of the time at which the signal came to it.
"""

from dataclasses import dataclass

import numpy as np

from handsim.reproducible import exp, log, mean
from handsim.types import Array

_RIDGE = 0.02  # added to the variance of the logarithms, where few recordings scatter little
_SOONEST = 0.02  # added to all times, since a signal may begin beyond a level [s]


@dataclass(frozen=True, eq=False)
class Pace:
    """What the time at which a signal comes to a level says about the duration.

    Attributes
    ----------
    duration
        Geometric mean of the recordings [s].
    levels : (m,), not decreasing
    usual : (m,)
        Mean logarithm of the times at which people came to them, plus 0.02 s.
    gains : (m,)
        By how much the logarithm of the duration grows with it.
    least, greatest : (m,) [s]
        Times recorded.
    """

    duration: float
    levels: Array
    usual: Array
    gains: Array
    least: Array
    greatest: Array

    def after(self, mark: int, seconds: float) -> float | None:
        """Return the likely duration [s] of a movement that came to a level after some time [s].

        None if nobody took so long: the person has waited before they began.
        """
        if seconds > self.greatest[mark]:
            return None
        time = max(seconds, float(self.least[mark])) + _SOONEST
        away = log(np.array([time])) - self.usual[mark]
        return self.duration * float(exp(self.gains[mark] * away)[0])


def fitted_pace(signals: Array, durations: Array, levels: Array) -> Pace:
    """Return the pace of recordings.

    Parameters
    ----------
    signals : (n, 101)
        Levels of the signal at equal steps of time, not decreasing.
    durations : (n,) [s]
    levels : (m,), not decreasing
    """
    n_times = signals.shape[1]
    first = np.array([np.searchsorted(each, levels, side="left") for each in signals])
    times = np.minimum(first, n_times - 1) / (n_times - 1) * durations[:, None]
    x, y = log(times + _SOONEST), log(durations)
    usual, overall = mean(x), float(mean(y))
    away = x - usual
    gains = mean(away * (y - overall)[:, None]) / (mean(away**2) + _RIDGE)
    duration = float(exp(np.array([overall]))[0])
    return Pace(duration, levels, usual, gains, times.min(axis=0), times.max(axis=0))


def steady_pace(durations: Array) -> Pace:
    """Return the pace of a signal that says nothing about durations (n,) [s]."""
    none = np.empty(0)
    duration = float(exp(mean(log(durations))[None])[0])
    return Pace(duration, none, none, none, none, none)

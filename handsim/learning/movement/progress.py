"""Progress over time: the fraction of a path's length that is covered at each time.

People move along a path with a bell-shaped speed. The minimum-jerk profile (Flash and Hogan 1985,
J. Neurosci. 5(7):1688-1703) covers s(t) = 10 x^3 - 15 x^4 + 6 x^5, x = t / duration. Learned curves
say how one person approaches one object: with a longer slow phase at its end, or in two parts.
The paper leaves the time law open: its u = -grad phi, Eq. (1), gives directions, and its speeds are
bounded since phi falls by at most 1 along a path.
"""

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.learning.guide.curve import Curve
from handsim.types import Array

MAX_DURATION = 600.0
"""Longest movement that is made [s]."""
N_PROGRESS = 51
"""Points kept of the progress of a recording, at equal steps of time."""
_Number = TypeVar("_Number", float, Array)
# s' / (1 - s) grows without bound at the end of a movement; it is held once this fraction of the
# length is covered, at 15 / duration for minimum jerk.
_HOLD = 0.95


def minimum_jerk(time: npt.ArrayLike, duration: float) -> Array:
    """Return the fraction of the length covered at times [s]."""
    x = np.clip(np.asarray(time, dtype=float) / duration, 0.0, 1.0)
    return _covered(x)


def _covered(x: _Number) -> _Number:
    """Return 10 x^3 - 15 x^4 + 6 x^5."""
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


def check_duration(duration: float) -> float:
    """Return a duration [s] that is positive and at most `MAX_DURATION`.

    Raises
    ------
    InputError
        If it is not.
    """
    if not 0 < duration <= MAX_DURATION:
        raise InputError(
            f"duration {duration:g} s; give a positive number of seconds, up to {MAX_DURATION:g}"
        )
    return float(duration)


@dataclass(frozen=True, eq=False)
class ProgressLaw:
    """The covered fraction of the length over time.

    Parameters
    ----------
    duration : [s]
    curve : (m,)
        Control points of the covered fraction at equal steps of time, rising from 0 to 1; None for
        minimum jerk.

    Raises
    ------
    InputError
        If the duration makes no sense.
    """

    duration: float
    curve: Array | None = None
    _spline: Curve | None = field(init=False, repr=False)
    _last: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the duration; find when so much is covered that the rate is held."""
        check_duration(self.duration)
        spline = None if self.curve is None else Curve(self.curve[:, None])
        object.__setattr__(self, "_spline", spline)
        late = np.linspace(0.0, 1.0, 1001)
        covered = self.covered(late * self.duration)
        object.__setattr__(self, "_last", float(late[np.searchsorted(covered, _HOLD)]))

    def covered(self, time: npt.ArrayLike) -> Array:
        """Return the fractions (m,) covered at times (m,) [s]."""
        if self._spline is None:
            return minimum_jerk(time, self.duration)
        x = np.clip(np.atleast_1d(np.asarray(time, dtype=float)) / self.duration, 0.0, 1.0)
        return self._spline.at(x)[:, 0]

    def at(self, time: float) -> tuple[float, float]:
        """Return the fraction covered at a time [s], and its rate [1/s]; it rests at its end."""
        if time >= self.duration:
            return 1.0, 0.0
        return self._at(max(time / self.duration, 0.0))

    def closing(self, time: float) -> float:
        """Return s' / (1 - s) at a time [s], held near the end, in 1/s."""
        covered, rate = self._at(min(max(time / self.duration, 0.0), self._last))
        return rate / (1.0 - covered)

    def at_and_closing(self, time: float) -> tuple[float, float, float]:
        """Return what `at` and `closing` do; for loops."""
        covered, rate = self.at(time)
        if time / self.duration <= self._last:
            return covered, rate, rate / (1.0 - covered)
        return covered, rate, self.closing(time)

    def _at(self, x: float) -> tuple[float, float]:
        if self._spline is None:
            return _covered(x), 30.0 * x**2 * (1.0 - x) ** 2 / self.duration
        covered, slope = self._spline.scalar_jet(x)
        return covered, max(slope, 0.0) / self.duration

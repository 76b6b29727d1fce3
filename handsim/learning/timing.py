"""The natural time law: which part of a path is covered at which time.

People move their hands along a path with a bell-shaped speed. The minimum-jerk profile (Flash and
Hogan 1985, J. Neurosci. 5(7):1688-1703) covers the fraction s(t) = 10 x^3 - 15 x^4 + 6 x^5 of the
length, x = t / duration. The paper leaves the time law open: its u = -grad phi, Eq. (1), gives
directions, and its speeds are bounded since phi falls by at most 1 along a path.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.navigation.paths import arc_length
from handsim.types import Array

MAX_DURATION = 600.0
"""Longest movement that is made [s]."""
_Number = TypeVar("_Number", float, Array)
# Fraction of the duration after which the rate s' / (1 - s), which grows as 3 / (duration - t),
# is held: what is left then is 1 % of the length.
_HOLD = 0.9


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


@dataclass(frozen=True)
class NaturalTiming:
    """Velocities for a closed loop that should arrive at a given time with a bell-shaped speed.

    The direction is the flow's at the measured posture, so that a push is answered as the
    navigation function answers it. The speed is (length left) * s'(t) / (1 - s(t)), which follows
    the minimum-jerk profile on the nominal path and catches up elsewhere.

    Attributes
    ----------
    direction
        Maps (z, z_goal) to the unit vector of the flow.
    z_goal : (n,) [rad]
    duration : [s]
    distance, left : (m,) [rad]
        Length left along the nominal path as a function of the distance to the destination.
    """

    direction: Callable[[Array, Array], Array]
    z_goal: Array
    duration: float
    distance: Array
    left: Array

    @classmethod
    def along(
        cls,
        path: Array,
        z_goal: Array,
        duration: float,
        direction: Callable[[Array, Array], Array],
    ) -> "NaturalTiming":
        """Build the timing from the nominal path (m, n) to the destination (n,)."""
        length = arc_length(path)
        left = (length[-1] - length)[::-1]
        distance = np.linalg.norm(path - z_goal, axis=1)[::-1]
        # Where the path turns away from the destination the farther point tells the length left.
        farthest = np.maximum.accumulate(distance)
        new = np.append(True, farthest[1:] > farthest[:-1])
        return cls(direction, z_goal, check_duration(duration), farthest[new], left[new])

    def velocity(self, z: Array, time: float) -> Array:
        """Return the velocity (n,) [rad/s] at a measured posture (n,) and time [s]."""
        away = z - self.z_goal
        distance: float = float(away @ away) ** 0.5
        left = float(np.interp(distance, self.distance, self.left))
        left += max(distance - float(self.distance[-1]), 0.0)
        return self.direction(z, self.z_goal) * (left * self._rate(time))

    def speeds(self, z: Array, time: float) -> Array:
        """Return the speeds (N,) [rad/s] of `velocity` at postures (N, n), to the bit."""
        away = z - self.z_goal
        squares = (away[:, None, :] @ away[:, :, None]).ravel().tolist()
        distance = np.array([square**0.5 for square in squares])
        left = np.interp(distance, self.distance, self.left)
        return (left + np.maximum(distance - self.distance[-1], 0.0)) * self._rate(time)

    def _rate(self, time: float) -> float:
        """Return s'(t) / (1 - s(t)) [1/s], held from 0.9 of the duration on."""
        x = min(max(time / self.duration, 0.0), _HOLD)
        return 30.0 * x**2 * (1.0 - x) ** 2 / ((1.0 - _covered(x)) * self.duration)

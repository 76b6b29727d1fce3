"""Velocities for a closed loop that should arrive at a given time.

The direction is the flow's at the measured posture, so that a push is answered as the navigation
function answers it; the speed follows a law of progress over time.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from handsim.learning.guide.field import GuidedField
from handsim.learning.movement.progress import ProgressLaw
from handsim.navigation.paths import arc_length
from handsim.types import Array


class Timing(Protocol):
    """Velocities at measured postures over time."""

    def velocities(self, z: Array, time: float) -> Array:
        """Return velocities (N, n) [rad/s] at measured postures (N, n) and a time [s]."""
        ...


@dataclass(frozen=True)
class FieldTiming:
    """Velocities along a flow in the subspace.

    The speed is (length left) * s'(t) / (1 - s(t)), which follows the law of progress on the
    nominal path and catches up elsewhere.

    Attributes
    ----------
    direction
        Maps (z, z_goal) to the unit vector of the flow.
    z_goal : (n,) [rad]
    law
        Progress over time.
    distance, left : (m,) [rad]
        Length left along the nominal path as a function of the distance to the destination.
    """

    direction: Callable[[Array, Array], Array]
    z_goal: Array
    law: ProgressLaw
    distance: Array
    left: Array

    @classmethod
    def along(
        cls,
        path: Array,
        z_goal: Array,
        law: ProgressLaw,
        direction: Callable[[Array, Array], Array],
    ) -> "FieldTiming":
        """Build the timing from the nominal path (m, n) to the destination (n,)."""
        length = arc_length(path)
        left = (length[-1] - length)[::-1]
        distance = np.linalg.norm(path - z_goal, axis=1)[::-1]
        # Where the path turns away from the destination the farther point tells the length left.
        farthest = np.maximum.accumulate(distance)
        new = np.append(True, farthest[1:] > farthest[:-1])
        return cls(direction, z_goal, law, farthest[new], left[new])

    def velocities(self, z: Array, time: float) -> Array:
        """Return velocities (N, n) [rad/s] at measured postures (N, n) and a time [s].

        Each is computed by itself, so that it does not depend on how many there are.
        """
        rows = [self.direction(here, self.z_goal) * self.speed(here, time) for here in z]
        return np.array(rows).reshape(z.shape)

    def speed(self, z: Array, time: float) -> float:
        """Return the speed [rad/s] at a measured posture (n,) and time [s]."""
        away = z - self.z_goal
        distance: float = float(away @ away) ** 0.5
        left = float(np.interp(distance, self.distance, self.left))
        left += max(distance - float(self.distance[-1]), 0.0)
        return left * self.law.closing(time)


@dataclass(frozen=True, eq=False)
class GuidedTiming:
    """Velocities along a guide, whose progress follows a law over time.

    Attributes
    ----------
    field
        The guide and the navigation function that leads along it.
    law
        Progress over time.
    """

    field: GuidedField
    law: ProgressLaw

    def velocities(self, z: Array, time: float) -> Array:
        """Return velocities (N, n) [rad/s] at measured postures (N, n) and a time [s]."""
        return self.field.velocity(z, *self.law.at_and_closing(time))

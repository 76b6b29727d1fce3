"""Coordinates in which reaches of any place, direction and length are alike.

The origin is the destination, z is up, x is the level direction from start to destination, and the
unit is the distance between both. Gravity stays: a reach downwards is not one upwards. Only where a
reach goes more steeply up or down than any that was learned, the rest is made up for by a turn.
"""

from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.types import Array

LEAST_DISTANCE = 0.005
"""Shortest reach that has a direction [m]."""


@dataclass(frozen=True, eq=False)
class ReachFrame:
    """The frame of one reach.

    Attributes
    ----------
    goal : (3,) [m]
        Its origin in the world.
    axes : (3, 3)
        Its axes in the world, as columns.
    distance
        Its unit [m].
    """

    goal: Array
    axes: Array
    distance: float

    @classmethod
    def of(
        cls, start: Array, goal: Array, rises: tuple[float, float] = (-np.pi / 2, np.pi / 2)
    ) -> "ReachFrame":
        """Return the frame of a reach from a start to a destination, (3,) [m] each.

        Parameters
        ----------
        start, goal
        rises
            Least and greatest angle of the way above the level that keeps its own up [rad].

        Raises
        ------
        InputError
            If both are less than `LEAST_DISTANCE` apart.
        """
        way = goal - start
        distance = float(np.linalg.norm(way))
        if not distance >= LEAST_DISTANCE:
            raise InputError(
                f"a reach of {1000 * distance:g} mm has no direction; give at least "
                f"{1000 * LEAST_DISTANCE:g} mm"
            )
        level = float(np.hypot(way[0], way[1]))
        ahead = way[:2] / level if level > 1e-6 * distance else np.array([1.0, 0.0])
        rise = float(np.arctan2(way[2], level))
        turn = rise - float(np.clip(rise, *rises))
        x = np.array([*(np.cos(turn) * ahead), np.sin(turn)])
        z = np.array([*(-np.sin(turn) * ahead), np.cos(turn)])
        y = np.array([-ahead[1], ahead[0], 0.0])
        return cls(np.asarray(goal, dtype=float), np.column_stack([x, y, z]), distance)

    def inside(self, places: Array) -> Array:
        """Return places (..., 3) [m] of the world in the frame."""
        return (places - self.goal) @ self.axes / self.distance

    def outside(self, places: Array) -> Array:
        """Return places (..., 3) of the frame in the world [m]."""
        return self.distance * places @ self.axes.T + self.goal


def rise_of(path: Array) -> float:
    """Return the angle of the way from start to end of a path (n, 3) above the level [rad]."""
    way = path[-1] - path[0]
    return float(np.arctan2(way[2], np.hypot(way[0], way[1])))

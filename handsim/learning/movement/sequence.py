"""Postures over time, made of a path and a time law."""

from typing import Literal, NamedTuple

import numpy as np

from handsim.learning.guide.curve import interpolated
from handsim.navigation.flow import FlowPath
from handsim.navigation.function import NavigationFunction
from handsim.navigation.paths import arc_length
from handsim.types import Array

TimeLaw = Literal["learned", "minimum-jerk", "gradient"]
TIME_LAWS: tuple[TimeLaw, ...] = ("learned", "minimum-jerk", "gradient")


class PostureSequence(NamedTuple):
    """Postures over time, and whether they reach the destination.

    Attributes
    ----------
    time : (n,) [s]
    q : (n, 22) [rad], within the joint ranges
    arrived
        Whether the path comes within 4 deg of the destination, and the hand too, whose joints may
        not leave their ranges.
    reason
        ``arrived``, ``stuck``, ``too long``, or ``clipped`` where the ranges keep the hand away.
    goal_distance
        Euclidean distance over the joints of the last posture from the destination [rad].
    """

    time: Array
    q: Array
    arrived: bool
    reason: str
    goal_distance: float = 0.0


def frame_times(duration: float, rate: float) -> Array:
    """Return frames from 0 to the first at or after the duration [s]."""
    return np.arange(int(np.ceil(duration * rate - 1e-9)) + 1) / rate


def by_gradient(
    navigation: NavigationFunction, path: FlowPath, z_goal: Array, duration: float, rate: float
) -> tuple[Array, Array]:
    """Return times (m,) and points (m, n) of a path that is passed at the speed of the paper.

    u = -grad phi, Eq. (1), so that dt = ds / |grad phi|. All times are then scaled by one
    factor to end at ``duration``. The speed falls to zero at the destination, which is reached
    after infinite time: a path that arrives ends one step before it.
    """
    points = path.points[:-1] if path.arrived and len(path.points) > 2 else path.points
    speed = np.linalg.norm(navigation.jets(points, z_goal, 1)[1], axis=1)
    # A flat phi (far behind an obstacle) would take hours; its slowest tenth of speed is kept.
    speed = np.maximum(speed, 1e-3 * speed.max())
    slowness = 0.5 * (1.0 / speed[1:] + 1.0 / speed[:-1])
    time = np.append(0.0, np.cumsum(np.diff(arc_length(points)) * slowness))
    time *= duration / max(time[-1], np.finfo(float).tiny)
    even = frame_times(duration, rate)
    return even, interpolated(even, time, points)

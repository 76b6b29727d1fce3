"""Integrate a flow through the subspace until it arrives, or is stuck: the paths of Eq. (1)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handsim.reproducible import norms
from handsim.types import Array, Index, Mask

ARRIVAL = np.deg2rad(4.0)
"""Distance from the destination within which a path has arrived [rad]."""


STEP = np.deg2rad(1.0)
"""Arc length of one integration step [rad]; halving it moves paths by under 0.1 deg."""


@dataclass(frozen=True)
class FlowPath:
    """The path of a flow from one start.

    Attributes
    ----------
    points : (n, d) [rad]
        From the start to the end; the last is the destination itself if the path arrived.
    arrived
        Whether it came within 4 deg of the destination.
    reason
        ``arrived``, ``stuck`` (it turns on the spot at a critical point) or ``too long``.
    """

    points: Array
    arrived: bool
    reason: str


def follow(
    directions: Callable[[Array, Array], Array],
    starts: Array,
    goals: Array,
    step: float = STEP,
    longest: float = 8.0,
) -> list[FlowPath]:
    """Follow a field of unit directions from many starts at once.

    Heun's rule at constant arc length, shorter near the destination. The two directions of a step
    are averaged, so that a path that runs into a critical point shrinks its steps there instead
    of leaping to and fro.

    Parameters
    ----------
    directions
        Maps points (N, d) and destinations (N, d) to unit vectors (N, d).
    starts, goals : (N, d) [rad]
    step : [rad]
    longest
        Length after which a path is given up, as a multiple of the workspace-sized distance
        max(|start - goal|, 90 deg).
    """
    points = np.array(starts, dtype=float)
    goals = np.broadcast_to(goals, points.shape)
    distance = norms(points - goals)[:, 0]
    n_steps = int(longest * max(float(distance.max()), np.pi / 2) / step)
    history = np.empty((n_steps + 1, *points.shape))
    history[0] = points
    ended = np.full(len(points), -1)
    reasons = np.full(len(points), "too long", dtype=object)
    active = np.arange(len(points))
    for i in range(n_steps):
        near = distance[active] < min(step, ARRIVAL)
        stuck = _stuck(history, i, active, step)
        for which, reason in ((near, "arrived"), (stuck & ~near, "stuck")):
            ended[active[which]] = i
            reasons[active[which]] = reason
        active = active[~(near | stuck)]
        if not active.size:
            break
        here, there = points[active], goals[active]
        length = np.minimum(step, 0.5 * distance[active])[:, None]
        first = directions(here, there)
        second = directions(here + length * first, there)
        points[active] = here + 0.5 * length * (first + second)
        distance[active] = norms(points[active] - there)[:, 0]
        history[i + 1] = points
    return [
        _flow_path(history[: (end if end >= 0 else n_steps) + 1, j], goals[j], str(reasons[j]))
        for j, end in enumerate(ended)
    ]


def _stuck(history: Array, i: int, active: Index, step: float, window: int = 50) -> Mask:
    """Whether a path moved less than a tenth of its steps over the last ``window`` steps."""
    if i < window:
        return np.zeros(len(active), dtype=bool)
    moved = norms(history[i, active] - history[i - window, active])[:, 0]
    return moved < 0.1 * window * step


def _flow_path(points: Array, goal: Array, reason: str) -> FlowPath:
    arrived = bool(norms(points[-1] - goal)[0] <= ARRIVAL)
    if arrived:
        points = np.vstack([points, goal])
    return FlowPath(points, arrived, "arrived" if arrived else reason)

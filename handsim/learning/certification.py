"""Certify a controller; where that fails, find the minima in which its flow ends."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from handsim.learning.controller import GraspController
from handsim.learning.direction.descent import box_corners
from handsim.learning.guide.likeness import Grasped
from handsim.navigation import certificate
from handsim.navigation.critical_points import critical_points, grid
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import NavigationFunction
from handsim.result import Result
from handsim.types import Array, Progress

_MAX_LISTED = 100  # minima listed by `certify`, so that its answer stays readable
_AT_ONCE = 600  # paths followed at a time: each keeps all its points until the last has ended


def not_arriving(
    navigation: NavigationFunction, z_goal: Array, starts: Array
) -> tuple[Array, list[FlowPath]]:
    """Return the starts (m, n) whose paths do not arrive, and those paths."""
    return next(_lost_paths(navigation, z_goal[None], starts))


def _lost_paths(
    navigation: NavigationFunction, goals: Array, starts: Array
) -> Iterator[tuple[Array, list[FlowPath]]]:
    """Yield for each destination (n,) what `not_arriving` does, a few destinations at a time."""
    n_starts = len(starts)
    n_goals = max(1, _AT_ONCE // n_starts)
    for first in range(0, len(goals), n_goals):
        part = goals[first : first + n_goals]
        repeated = np.tile(starts, (len(part), 1))
        paths = follow(navigation.directions, repeated, np.repeat(part, n_starts, axis=0))
        for i in range(len(part)):
            own = paths[i * n_starts : (i + 1) * n_starts]
            lost = [j for j, path in enumerate(own) if not path.arrived]
            yield starts[lost], [own[j] for j in lost]


@dataclass(frozen=True)
class Certification(Result):
    """Whether all paths of a controller are proven to arrive; if not, what traps them.

    Attributes
    ----------
    k
        Exponent of the navigation function.
    k_min
        Least exponent with which the proof succeeds, None if none.
    certified
        Whether every start is proven to reach every recorded destination by what the controller
        follows: with a guide the field of each query, else the flow of beta.
    guided
        Whether the controller leads along a guide.
    covers
        ``recorded``, ``planned`` and ``inner``: whether the proof holds for the recorded
        destinations, for the planned ones (None if there are none), and for all in the workspace
        off its closing layer.
    reason
        What the proof of beta's flow says.
    supremum
        Proven bound of the descent quantity, None where there is none.
    n_minima, n_saddles, n_maxima
        Critical points found over all destinations, the destinations themselves among the minima.
    other_minima
        Name of the destination and place [deg] of the traps found, at most 100.
    starts, arrivals
        Starts on a grid times destinations, and those whose paths arrive.
    lost_starts
        The starts whose paths do not, as ``other_minima``.
    """

    k: float
    k_min: float | None
    certified: bool
    guided: bool
    covers: dict[str, bool | None]
    reason: str
    supremum: float | None
    n_minima: int
    n_saddles: int
    n_maxima: int
    other_minima: tuple[dict[str, Any], ...]
    starts: int
    arrivals: int
    lost_starts: tuple[dict[str, Any], ...]


def covered(controller: GraspController, goals: Array | None) -> bool | None:
    """Whether every start is proven to reach all destinations (m, n) [rad]; None for None.

    With a guide, the field of a query from the mean recorded start is built for each and its proof
    is checked; else the proof is that of beta's flow, for the smallest box around them.
    """
    if goals is None or not len(goals):
        return None
    if controller.guide is None:
        return certificate.certify(controller.navigation, goals).certified
    low, high = controller.reach
    start = np.mean([d.z_start for d in controller.demonstrations], axis=0)
    inside = bool(((goals > low) & (goals < high)).all())
    return inside and all(proves(controller, start, goal) for goal in goals)


def proves(
    controller: GraspController, z_start: Array, z_goal: Array, grasped: Grasped | None = None
) -> bool:
    """Whether every start is proven to reach a destination by what a query follows.

    Parameters as in `GraspController.field`; a destination that is refused raises as there.
    """
    field = controller.field(z_start, z_goal, grasped)
    if field is None:
        return certificate.certify(controller.navigation, z_goal[None]).certified
    return field.proven


def certify(
    controller: GraspController,
    per_dimension: int = 5,
    progress: Progress | None = None,
    planned: Array | None = None,
) -> Certification:
    """Certify a controller; where the flow of beta is not proven, look for what traps it.

    Parameters
    ----------
    controller
    per_dimension
        Starts along each dimension of the grid.
    progress
        Called with the fraction done.
    planned : (m, n) [rad]
        Destinations of plans.
    """
    navigation = controller.navigation
    goals = np.array([d.z_goal for d in controller.demonstrations])
    proof = certificate.certify(navigation, goals)
    covers = {
        "recorded": covered(controller, goals),
        "planned": covered(controller, planned),
        "inner": covered(controller, box_corners(_inset(*navigation.inner))),
    }
    starts = grid(navigation, per_dimension)
    followed = _lost_paths(navigation, goals, starts)
    counts = {"minimum": 0, "saddle": 0, "maximum": 0, "degenerate": 0}
    traps: list[dict[str, Any]] = []
    lost_starts: list[dict[str, Any]] = []
    for i, demonstration in enumerate(controller.demonstrations):
        if progress:
            progress(i / len(goals))
        goal = demonstration.z_goal
        lost, paths = next(followed)
        lost_starts += [_place(demonstration.name, z) for z in lost]
        counts["minimum"] += 1
        if proof.certified:  # there is nothing to be found
            continue
        ends = np.array([path.points[-1] for path in paths]).reshape(-1, starts.shape[1])
        for found in critical_points(navigation, goal, np.vstack([starts, ends])):
            counts[found.kind] += 1
            if found.kind == "minimum":
                traps.append(_place(demonstration.name, found.z))
    n_runs = len(starts) * len(goals)
    return Certification(
        k=navigation.k,
        k_min=proof.k_min,
        certified=bool(covers["recorded"]),
        guided=controller.guide is not None,
        covers=covers,
        reason=proof.reason,
        supremum=None if proof.supremum is None else proof.supremum.outward,
        n_minima=counts["minimum"],
        n_saddles=counts["saddle"],
        n_maxima=counts["maximum"],
        other_minima=tuple(traps[:_MAX_LISTED]),
        starts=n_runs,
        arrivals=n_runs - len(lost_starts),
        lost_starts=tuple(lost_starts[:_MAX_LISTED]),
    )


def _inset(low: Array, high: Array) -> Array:
    """Return opposite corners (2, n) of a box, a hair inside: no destination lies on its faces."""
    inset = 1e-6 * (high - low)
    return np.array([low + inset, high - inset])


def _place(name: str, z: Array) -> dict[str, Any]:
    return {"destination": name, "z_deg": [round(float(x), 2) for x in np.rad2deg(z)]}

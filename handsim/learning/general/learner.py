"""Navigation functions of any data: lists of paths of 1 to 5 dimensions, in any unit."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Self

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.learning.base import Estimator, check_paths
from handsim.learning.fit.level import levelled
from handsim.learning.general.candidates import (
    MOST_DIMENSIONS,
    best_proved,
    straight,
    towards_many,
    towards_one,
)
from handsim.learning.general.convergence import Convergence, convergence
from handsim.learning.general.evaluation import NavigationScores, scored
from handsim.learning.general.refinement import Tried
from handsim.navigation.bspline import MAX_DIMENSIONS
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import NavigationFunction, check_exponent
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import arc_length, between_ends
from handsim.types import Array, Progress

_MEAN_LENGTH = 2.5
"""To which the mean length of the paths is scaled [rad]; an arrival, 4 deg, is 2.8 % of it."""
_SAME_GOAL = 1e-6  # of the mean length: ends nearer than this are one destination
_MOST_TO_ONE = 100  # paths that a field to one destination is made of; of more, every few


class NavigationLearner(Estimator):
    """Learner of a navigation function from paths of any kind.

    The paths may have 1 to 5 dimensions and any unit, the same along all dimensions. Inside, they
    are moved and scaled such that their box is centred at 0 and their mean length is 2.5 rad, so
    that nothing depends on the unit. A path has arrived within 2.8 % of that length.

    Several fields are made and the best is kept that is *proved* to lead to its destinations
    (`navigation.proof`). Where none would be, the best is shrunk towards straight lines until it
    is. Of more than 100 paths to one destination every few are used.

    Parameters
    ----------
    k
        Exponent of the navigation function; it changes phi, not paths.
    certified
        Keep a proved field only. Otherwise the best, proved or not.
    n_refinements
        Rounds of roll-outs for each of the best first drafts.
    seed
        Of the displaced points beside the paths.

    Attributes
    ----------
    navigation_
        The navigation function, in scaled coordinates.
    goals_ : (m, d)
        Destinations, in the unit of the paths.
    certificate_
        What is proved of them.
    origin_
        How the field that was kept was made.
    scale_ : [rad per unit]
    centre_ : (d,)
        Scaled coordinates are (z - centre_) * scale_.
    seconds_

    Examples
    --------
    >>> s = np.linspace(0, 1, 50)[:, None]
    >>> arc = np.hstack([1 - s, np.sin(np.pi * s)])
    >>> paths = [100 * arc, 100 * arc + [0, 10] * (1 - s)]
    >>> learner = NavigationLearner(n_refinements=1).fit(paths)
    >>> learner.certificate_.certified, learner.path([90, 0]).arrived
    (True, True)
    """

    navigation_: NavigationFunction
    goals_: Array
    certificate_: Convergence
    origin_: str
    scale_: float
    centre_: Array
    seconds_: float

    def __init__(
        self, k: float = 4.0, certified: bool = True, n_refinements: int = 4, seed: int = 0
    ) -> None:
        self.k = k
        self.certified = certified
        self.n_refinements = n_refinements
        self.seed = seed

    def fit(
        self,
        paths: Sequence[Array],
        goals: npt.ArrayLike | None = None,
        *,
        progress: Progress | None = None,
    ) -> Self:
        """Learn from paths.

        Parameters
        ----------
        paths
            (n_i, d), each from its start to its destination.
        goals : (d,) or (paths, d)
            Destinations where they are not the ends of the paths; the ends are moved there, and
            the rest of each path along with them, less and less towards its start.
        progress
            Called with the fraction done.

        Raises
        ------
        InputError
            If there are no paths, they have more than 5 dimensions or do not move along one of
            them, goals do not match, or a parameter is out of its range.
        """
        began = perf_counter()
        self.check_parameters({"n_refinements": 0, "seed": 0})
        check_exponent(self.k)
        checked = _checked(paths, goals)
        lengths = [float(arc_length(path)[-1]) for path in checked]
        if not max(lengths) > 0.0:
            raise InputError("the paths do not move; give paths of more than one point")
        points = np.vstack(checked)
        self.scale_ = _MEAN_LENGTH * len(lengths) / sum(lengths)
        self.centre_ = 0.5 * (points.min(axis=0) + points.max(axis=0))
        inside = [self._scaled(path) for path in checked]
        different = _different(np.array([path[-1] for path in inside]))
        self.goals_ = self._unscaled(different)
        kept = self._learned(_with_goals(inside, different), different, progress)
        self.origin_ = kept.origin
        self.navigation_ = _with_level(kept.navigation, inside)
        self.certificate_ = convergence(self.navigation_, list(different))
        self.seconds_ = perf_counter() - began
        return self

    def _learned(self, paths: list[Array], goals: Array, progress: Progress | None) -> Tried:
        """Make fields and choose among them."""
        if len(goals) == 1 and goals.shape[1] <= MOST_DIMENSIONS:
            used = paths[:: -(-len(paths) // _MOST_TO_ONE)]
            batches = towards_one(used, self.k, self.n_refinements, self.seed)
        else:
            used, batches = paths, towards_many(paths, self.k, self.seed)
        fields: list[Tried] = []
        for i, batch in enumerate(batches):
            fields += batch
            if progress:
                progress(1.0 - 0.5 ** (i + 1))
        if not self.certified:
            return max(fields, key=lambda each: each.merit)
        found = best_proved(
            fields, used, lambda navigation: convergence(navigation, list(goals)).certified
        )
        return found or straight(used, self.k)

    def velocity(self, z: npt.ArrayLike, z_goal: npt.ArrayLike | None = None) -> Array:
        """Return the direction of motion at points, as unit vectors; 0 at the destination.

        Paths have no times, so that the speed is up to who follows the field: at any positive speed
        the path is the same. Outside the workspace the field of its nearest point is taken.

        Parameters
        ----------
        z : (d,) or (N, d)
            In the unit of the paths.
        z_goal : (d,)
            Destination; may be left out where only one was learned.

        Returns
        -------
        (d,) or (N, d)

        Raises
        ------
        InputError
            If shapes do not match, or the destination is missing or outside the workspace.
        """
        goal = self._goal(z_goal)
        points = self._points(z)
        flat = self._scaled(points.reshape(-1, len(self.centre_)))
        return self.navigation_.directions(flat, goal).reshape(points.shape)

    def path(self, start: npt.ArrayLike, goal: npt.ArrayLike | None = None) -> FlowPath:
        """Return the path from a start (d,), in the unit of the paths.

        Parameters
        ----------
        start : (d,)
        goal : (d,)
            As in `velocity`.
        """
        target = self._goal(goal)
        begin = self._points(start)
        if begin.ndim != 1:
            raise InputError(f"start of shape {begin.shape}; give one point ({len(begin.T)},)")
        found = follow(self.navigation_.directions, self._scaled(begin)[None], target[None])[0]
        return replace(found, points=self._unscaled(found.points))

    def evaluate(self, paths: Sequence[Array]) -> NavigationScores:
        """Compare the field with paths, followed from their starts.

        They lead to their own ends, or to the destination learned where there is only one.

        Parameters
        ----------
        paths
            (n_i, d), in the unit of those learned from.
        """
        navigation, checked = self.navigation_, check_paths(paths)
        for path in checked:
            self._points(path)
        scaled = [self._scaled(path) for path in checked]
        one = self._scaled(self.goals_[0])
        goals = [one if len(self.goals_) == 1 else self._goal(path[-1]) for path in checked]
        return scored(navigation, scaled, goals, self.scale_, self.certificate_.certified)

    def _scaled(self, z: Array) -> Array:
        return (z - self.centre_) * self.scale_

    def _unscaled(self, z: Array) -> Array:
        return z / self.scale_ + self.centre_

    def _points(self, z: npt.ArrayLike) -> Array:
        n = self.navigation_.n_dimensions
        points = np.asarray(z, dtype=float)
        if points.ndim not in (1, 2) or points.shape[-1] != n or not np.isfinite(points).all():
            raise InputError(
                f"points of shape {points.shape}; give finite ones, ({n},) or (N, {n})"
            )
        return points

    def _goal(self, z_goal: npt.ArrayLike | None) -> Array:
        """Return a destination in scaled coordinates."""
        navigation = self.navigation_
        if z_goal is None:
            if len(self.goals_) > 1:
                raise InputError(
                    f"{len(self.goals_)} destinations were learned; say which, as in goals_[0]"
                )
            return self._scaled(self.goals_[0])
        goal = np.asarray(z_goal, dtype=float)
        if goal.shape != self.centre_.shape or not np.isfinite(goal).all():
            raise InputError(
                f"destination of shape {goal.shape}; give finite numbers, {self.centre_.shape}"
            )
        low, high = (self._unscaled(corner) for corner in navigation.inner)
        if not ((goal > low) & (goal < high)).all():
            i = int(np.argmin(np.minimum(goal - low, high - goal)))
            raise InputError(
                f"destination {goal[i]:g} along dimension {i + 1} is outside the workspace of "
                f"{low[i]:g} to {high[i]:g}; choose one nearer to the paths"
            )
        return self._scaled(goal)


def _checked(paths: Sequence[Array], goals: npt.ArrayLike | None) -> list[Array]:
    """Return paths that end at their destinations."""
    checked = check_paths(paths)
    n = checked[0].shape[1]
    if not 1 <= n <= MAX_DIMENSIONS:
        raise InputError(f"paths of {n} dimensions; give 1 to {MAX_DIMENSIONS}")
    if goals is None:
        return checked
    ends = np.asarray(goals, dtype=float)
    if ends.shape not in ((n,), (len(checked), n)) or not np.isfinite(ends).all():
        raise InputError(f"goals of shape {ends.shape}; give ({n},) or ({len(checked)}, {n})")
    ends = np.broadcast_to(ends, (len(checked), n))
    return [between_ends(path, path[0], end) for path, end in zip(checked, ends, strict=True)]


def _different(goals: Array) -> Array:
    """Return destinations without those next to an earlier one."""
    kept: list[Array] = []
    for goal in goals:
        if all(np.abs(goal - other).max() > _SAME_GOAL * _MEAN_LENGTH for other in kept):
            kept.append(goal)
    return np.array(kept)


def _with_goals(paths: list[Array], goals: Array) -> list[Array]:
    """Return paths that end at the nearest of destinations to the bit."""
    result: list[Array] = []
    for path in paths:
        nearest = int(np.argmin(np.abs(goals - path[-1]).max(axis=1)))
        result.append(np.vstack([path[:-1], goals[nearest]]))
    return result


def _with_level(navigation: NavigationFunction, paths: list[Array]) -> NavigationFunction:
    """Set the free constant of chi."""
    obstacle = navigation.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    starts = np.array([path[0] for path in paths])
    goals = np.array([path[-1] for path in paths])
    chi = levelled(obstacle.chi, navigation, starts, goals)
    return replace(navigation, obstacle=ExponentialObstacle(chi, obstacle.width))

"""A controller of the palm's transport, of the same kind as the hand's.

Recorded paths of the palm are brought into the frame of their reach (`reach_frame`), in which all
lead to one destination. There an obstacle is learned by the direction learner, held to the descent
condition, so that every start is proved to arrive. A table and other things enter as real
obstacles of the same beta (`walls`). Progress over time is the mean of the recordings'.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from handsim.digests import content_digest
from handsim.errors import InputError
from handsim.learning._stored_navigation import content_of_navigation
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.movement.progress import ProgressLaw
from handsim.learning.transport.reach_frame import ReachFrame, rise_of
from handsim.learning.transport.walls import Wall, WalledObstacle, keep_off
from handsim.navigation.certificate import Certificate, certify
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import FlowEvaluator, NavigationFunction
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.types import Array, Progress, Side

N_CONTROL = 16
"""Control points of a time law."""
_N_PROGRESS = 51
_STEP = float(np.deg2rad(1.0))
_GOAL = np.zeros(3)
MIRROR = np.array([1.0, -1.0, 1.0])
"""The y axis of a reach points to the left: what a right hand does to it, a left one undoes."""
SCALE = 2.5
"""Length of a straight reach in the coordinates of the field [rad], for which the learners are
made."""


@dataclass(frozen=True, eq=False)
class Transport:
    """What was learned of a person's reaches.

    Two are equal, and have the same hash, if they do the same: if their digests agree.

    Attributes
    ----------
    navigation
        In the frame of a reach, times `SCALE`; its destination is 0.
    certificate
        By descent: every start in the workspace arrives.
    rises : [rad]
        Least and greatest angle above the level of the reaches learned from.
    progress : (16,)
        Control points of the covered share of the length over time.
    duration
        Median of the recordings [s].
    n_reaches
        Number of reaches learned from.
    mirrored
        Whether it is for a left hand: the mirror image of a right hand's, which is learned.
    """

    navigation: NavigationFunction
    certificate: Certificate
    rises: tuple[float, float]
    progress: Array
    duration: float
    n_reaches: int = 0
    mirrored: bool = False

    def for_side(self, side: Side) -> "Transport":
        """Return the transport of a right or a left hand."""
        return self if self.mirrored == (side == "left") else self._of_other_side

    @cached_property
    def _of_other_side(self) -> "Transport":
        return replace(self, mirrored=not self.mirrored)

    @cached_property
    def digest(self) -> str:
        """Digits that are the same for transports that do the same."""
        content = content_of_navigation(self.navigation)
        law = (self.progress, self.duration)
        return content_digest(*content, self.rises, *law, self.mirrored)

    def __eq__(self, other: object) -> bool:
        """Whether both do the same."""
        return isinstance(other, Transport) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash what the transport does."""
        return hash(self.digest)

    def reach(
        self,
        start: Array,
        goal: Array,
        walls: Sequence[Wall] = (),
        duration: float | None = None,
    ) -> "PalmReach":
        """Return the reach of the palm from a start to a destination.

        Parameters
        ----------
        start, goal : (3,) [m]
        walls
            Real obstacles, in the world [m].
        duration
            [s]; by default the recordings' median.

        Raises
        ------
        InputError
            If both are less than 5 mm apart, or the duration makes no sense.
        """
        law = ProgressLaw(self.duration if duration is None else duration, self.progress)
        frame = ReachFrame.of(start, goal, self.rises)
        if self.mirrored:
            frame = replace(frame, axes=frame.axes * MIRROR)
        near = [wall.moved(frame.axes, frame.goal, frame.distance / SCALE) for wall in walls]
        kept, field = keep_off(_GOAL, near), self.navigation
        if kept:
            field = NavigationFunction(WalledObstacle(field.obstacle, kept), field.k)
        begin = SCALE * frame.inside(start)
        found = follow(_one_by_one(field), begin[None], _GOAL[None], _STEP)[0]
        points = frame.outside(found.points / SCALE)
        points[0] = start
        if found.arrived:
            points[-1] = goal
        path = FlowPath(points, found.arrived, found.reason)
        proved = self.certificate.certified and all(wall.keeps_descent for wall in kept)
        return PalmReach(path, law, proved, len(kept), field, frame)


def _one_by_one(field: NavigationFunction) -> Callable[[Array, Array], Array]:
    """Return `NavigationFunction.directions` for a single point, several times as fast."""
    # The metric of the one destination, not the evaluator's own, which depends on the processor.
    metric: list[list[float]] = field.metrics(_GOAL).tolist()
    flow = FlowEvaluator(field.obstacle.evaluator(field.k), field.k, lambda _: metric)

    def directions(z: Array, z_goal: Array) -> Array:
        direction = np.empty((1, 3))
        flow.direction(z[0], z_goal[0], direction[0])
        return direction

    return directions


@dataclass(frozen=True, eq=False)
class PalmReach:
    """One reach of the palm.

    Attributes
    ----------
    path
        From the start to the destination [m].
    law
        Covered share of its length over time.
    proved
        Whether every start in the workspace is proved to arrive, walls included.
    n_walls
        Number of walls that are kept off. One that the destination lies in is not.
    field, frame
        The navigation function, and how its coordinates come from the world.
    """

    path: FlowPath
    law: ProgressLaw
    proved: bool
    n_walls: int
    field: NavigationFunction
    frame: ReachFrame

    def at(self, times: Array) -> Array:
        """Return where the palm is at times (n,) [s] after the start, (n, 3) [m]."""
        return at_arc_length(self.path.points, self.law.covered(times))

    def velocity(self, place: Array, time: float) -> Array:
        """Return the velocity (3,) [m/s] at a measured place (3,) [m] and a time [s].

        Its direction is the flow's there, so that a push is answered as the navigation function
        answers it; its speed makes up the distance that is left in the time that is left.
        """
        z = SCALE * self.frame.inside(place)
        direction = self.field.directions(z[None], _GOAL[None])[0] @ self.frame.axes.T
        left = float(np.linalg.norm(place - self.path.points[-1]))
        return left * self.law.closing(time) * direction


def learn_transport(
    paths: Sequence[Array],
    times: Sequence[Array],
    *,
    seed: int = 0,
    progress: Progress | None = None,
) -> Transport:
    """Learn from recorded paths of the palm.

    Parameters
    ----------
    paths
        (n_i, 3) [m], z up, each from the start of a reach to its end.
    times
        (n_i,) [s]
    seed
        As of `DirectionLearner`.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        If there are none, shapes do not match, or a path does not move.
    """
    if not paths or len(paths) != len(times):
        raise InputError(f"{len(paths)} paths and {len(times)} rows of times; give as many of both")
    for path, time in zip(paths, times, strict=True):
        if path.ndim != 2 or path.shape != (len(time), 3) or len(time) < 3:
            raise InputError(
                f"a path of shape {path.shape} with {len(time)} times; give (n, 3) and (n,), n > 2"
            )
        if not (np.isfinite(path).all() and np.isfinite(time).all()):
            raise InputError("a path of the palm has gaps; bridge them or leave the reach out")
        if not (np.diff(time) > 0).all():
            raise InputError("times of a path do not rise; give seconds in order")
    inside = [SCALE * ReachFrame.of(path[0], path[-1]).inside(path) for path in paths]
    learner = DirectionLearner(certified=True, seed=seed).fit(inside, progress=progress)
    rises = [rise_of(path) for path in paths]
    return certified_transport(
        learner.navigation_,
        (min(rises), max(rises)),
        _mean_progress(paths, times),
        float(np.median([time[-1] - time[0] for time in times])),
        len(paths),
    )


def certified_transport(
    navigation: NavigationFunction,
    rises: tuple[float, float],
    progress: Array,
    duration: float,
    n_reaches: int,
) -> Transport:
    """Return a transport with the proof that every start arrives, where there is one."""
    certificate = certify(navigation, _GOAL[None])
    return Transport(navigation, certificate, rises, progress, duration, n_reaches)


def _mean_progress(paths: Sequence[Array], times: Sequence[Array]) -> Array:
    """Return the mean covered share at equal steps of time, as control points (16,)."""
    steps = np.linspace(0.0, 1.0, _N_PROGRESS)
    covered = []
    for path, time in zip(paths, times, strict=True):
        length = arc_length(path)
        share = (time - time[0]) / (time[-1] - time[0])
        covered.append(np.interp(steps, share, length / length[-1]))
    mean = np.maximum.accumulate(np.mean(covered, axis=0))
    mean[0], mean[-1] = 0.0, 1.0
    return np.interp(np.linspace(0.0, 1.0, N_CONTROL), steps, mean)

"""The grasp controller: subspace, navigation function, and what was recorded."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from handsim.digests import content_digest
from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import read_archive, write_archive
from handsim.joints import N_JOINTS, clip_to_range
from handsim.learning._stored_controller import (
    check_content,
    stored_demonstrations,
    stored_options,
)
from handsim.learning.demonstration import Demonstration
from handsim.learning.subspace import PostureSubspace
from handsim.learning.timing import NaturalTiming, check_duration, minimum_jerk
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import ARRIVAL, FlowPath, follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, SplineObstacle
from handsim.navigation.paths import arc_length
from handsim.types import Array

TimeLaw = Literal["natural", "gradient"]

SCHEMA = 3  # 1: without a metric of destinations; 2: with few of the options; both still read


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


@dataclass(frozen=True, eq=False)
class GraspController:
    """Closed-loop controller of a hand in its principal subspace.

    Two controllers are equal, and have the same hash, if they do the same: if their digests agree.

    Attributes
    ----------
    subspace
    navigation
    demonstrations
        One for each recording it was learned from.
    method
        Name of the learner: ``direction`` or ``pde``, or for a learner of another package the
        module and name of its class.
    certified
        Whether it was learned with the descent condition as a constraint.
    options
        All options and the seed of the learner (`options`). Files of earlier versions do not hold
        them all; those that are missing had their default values.
    accepted
        Kinds of anomalies of the recordings that whoever learned it said are right all the same
        (`handsim.recordings.plausibility.KINDS`).
    """

    subspace: PostureSubspace
    navigation: NavigationFunction
    demonstrations: tuple[Demonstration, ...]
    method: str = "direction"
    certified: bool = False
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    accepted: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        """Whether both do the same."""
        return isinstance(other, GraspController) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash what the controller does."""
        return hash(self.digest)

    def demonstration(self, name: str) -> Demonstration:
        """Return what was learned of a recording, by a name.

        Parameters
        ----------
        name
            Of a recording or a task, or else of an object. Of several recordings the first.

        Raises
        ------
        UnknownNameError
            If no recording, task or object has that name; the message offers the nearest.
        """
        of_names = [(d.name, d.task) for d in self.demonstrations]
        of_objects = [(d.object,) for d in self.demonstrations]
        for known in (of_names, of_objects):
            for demonstration, names in zip(self.demonstrations, known, strict=True):
                if name in names:
                    return demonstration
        every = [each for known in (of_names, of_objects) for names in known for each in names]
        kind = "task, recording or object"
        raise UnknownNameError(kind, name, tuple(dict.fromkeys(every)))

    def velocity(self, z: Array, z_goal: Array) -> Array:
        """Return u = -grad phi (n,) at one point, Eq. (1) of the paper."""
        return -self.navigation.value_and_gradient(z, z_goal)[1]

    def direction(self, z: Array, z_goal: Array) -> Array:
        """Return the unit vector (n,) of u at one point; it stays exact where phi is flat."""
        return self.navigation.direction(z, z_goal)

    def path(self, z_start: Array, z_goal: Array) -> FlowPath:
        """Follow the flow from a start to a destination, both (n,) [rad].

        Raises
        ------
        InputError
            If the destination cannot be one (see `NavigationFunction.check_goal`).
        """
        goal = self.navigation.check_goal(z_goal)
        start = np.asarray(z_start, dtype=float)
        if start.shape != goal.shape or not np.isfinite(start).all():
            raise InputError(f"start of shape {start.shape}; give {len(goal)} finite coordinates")

        def directions(z: Array, z_goal: Array) -> Array:
            return self.navigation.direction(z[0], z_goal[0])[None]

        return follow(directions, start[None], goal[None])[0]

    def timing(self, z_start: Array, z_goal: Array, duration: float) -> NaturalTiming:
        """Return the natural time law of a closed loop that starts at ``z_start``."""
        path = self.path(z_start, z_goal)
        return NaturalTiming.along(
            path.points, np.asarray(z_goal, dtype=float), duration, self.direction
        )

    def postures(
        self,
        q_start: Array,
        q_goal: Array | None = None,
        *,
        z_goal: Array | None = None,
        time_law: TimeLaw = "natural",
        duration: float | None = None,
        rate: float = 100.0,
    ) -> PostureSequence:
        """Integrate the controller from a posture to a destination and lift it to 22 joints.

        Parameters
        ----------
        q_start : (22,) [rad]
        q_goal : (22,) [rad], or z_goal : (n_components,) [rad]
            The destination, whole or in the subspace.
        time_law
            ``natural``: bell-shaped speed; ``gradient``: u = -grad phi, the paper's, with its time
            scaled as a whole. (phi falls by at most 1 along a path, which bounds the speeds
            it can have; people's need a time scale of their own.)
        duration : [s]
            By default the median of the recordings.
        rate : [Hz]

        Raises
        ------
        InputError
            If not exactly one destination is given, it cannot be one, or shapes, duration or
            rate make no sense.
        """
        if (q_goal is None) == (z_goal is None):
            raise InputError("give one destination, as a posture or in the subspace")
        if not (np.isfinite(rate) and rate > 0):
            raise InputError(f"rate {rate:g} Hz; give a positive number")
        goal = np.asarray(z_goal, float) if q_goal is None else self._projected(q_goal)
        path = self.path(self._projected(q_start), goal)
        seconds = self.median_duration if duration is None else check_duration(duration)
        if time_law == "natural":
            time, z = _timed_naturally(path.points, seconds, rate)
        elif time_law == "gradient":
            time, z = self._timed_by_gradient(path, goal, seconds, rate)
        else:
            raise UnknownNameError("time law", time_law, ("natural", "gradient"))
        q = clip_to_range(self.subspace.inverse_transform(z))
        distance = float(np.linalg.norm(q[-1] - self.subspace.inverse_transform(goal)))
        clipped = path.arrived and distance > ARRIVAL
        reason = "clipped" if clipped else path.reason
        return PostureSequence(time, q, path.arrived and not clipped, reason, distance)

    def _projected(self, q: Array) -> Array:
        if np.shape(q) != (N_JOINTS,) or not np.isfinite(q).all():
            raise InputError(f"posture of shape {np.shape(q)}; give {N_JOINTS} finite angles")
        return self.subspace.transform(q)

    @property
    def median_duration(self) -> float:
        """Median duration of the recordings [s]."""
        return float(np.median([d.duration for d in self.demonstrations]))

    def _timed_by_gradient(
        self, path: FlowPath, goal: Array, duration: float, rate: float
    ) -> tuple[Array, Array]:
        """Return times and points (m, n) of a path that is passed at the speed of the paper.

        u = -grad phi, Eq. (1), so that dt = ds / |grad phi|. All times are then scaled by one
        factor to end at ``duration``. The speed falls to zero at the destination, which is reached
        after infinite time: a path that arrives ends one step before it.
        """
        points = path.points[:-1] if path.arrived and len(path.points) > 2 else path.points
        speed = np.linalg.norm(self.navigation.jets(points, goal, 1)[1], axis=1)
        # A flat phi (far behind an obstacle) would take hours; its slowest tenth of speed is kept.
        speed = np.maximum(speed, 1e-3 * speed.max())
        slowness = 0.5 * (1.0 / speed[1:] + 1.0 / speed[:-1])
        time = np.append(0.0, np.cumsum(np.diff(arc_length(points)) * slowness))
        time *= duration / max(time[-1], np.finfo(float).tiny)
        even = _frame_times(duration, rate)
        return even, _interpolated(even, time, points)

    @cached_property
    def digest(self) -> str:
        """Digits that are the same for controllers that do the same, whatever made them.

        Numbers count as `digests.rounded` leaves them: what the last bits of another machine are
        does not matter, nor does how the controller came to be (method, options).
        """
        metadata, arrays = self._content()
        behaviour = ("obstacle", "degree", "k", "demonstrations", "metric_reach")
        settings = {name: metadata[name] for name in behaviour if name in metadata}
        return content_digest(settings, arrays)

    def save(self, path: Path) -> None:
        """Write the controller to an ``.npz`` without pickles."""
        metadata, arrays = self._content()
        write_archive(Path(path), "controller", SCHEMA, metadata, arrays)

    @classmethod
    def load(cls, path: Path) -> "GraspController":
        """Read a controller.

        Raises
        ------
        FileError
            If the file is missing, damaged, of another kind or of a newer schema.
        """
        metadata, arrays = read_archive(Path(path), "controller", SCHEMA)
        try:
            check_content(metadata, arrays)
            return cls(
                subspace=PostureSubspace.from_arrays(arrays),
                navigation=_navigation_of(metadata, arrays),
                demonstrations=stored_demonstrations(metadata, arrays),
                method=metadata["method"],
                certified=bool(metadata["certified"]),
                options=stored_options(metadata),
                accepted=tuple(map(str, metadata.get("accepted", ()))),
            )
        except InputError as error:
            raise FileError(f"{path}: {error}") from error
        except (KeyError, ValueError, TypeError, IndexError) as error:
            raise FileError(
                f"{path}: not a whole controller ({type(error).__name__}: {error}); learn it again"
            ) from error

    def _content(self) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        obstacle = self.navigation.obstacle
        exponential = isinstance(obstacle, ExponentialObstacle)
        if exponential:
            spline = obstacle.chi
        elif isinstance(obstacle, SplineObstacle):
            spline = obstacle.beta
        else:
            raise InputError(f"an obstacle of type {type(obstacle).__name__} cannot be saved")
        records = [asdict(d) for d in self.demonstrations]
        vectors = ("q_start", "q_goal", "z_start", "z_goal")
        arrays = self.subspace.to_arrays()
        arrays.update(
            {name: np.array([record.pop(name) for record in records]) for name in vectors}
        )
        arrays.update({f"knots_{i}": knots for i, knots in enumerate(spline.basis.knots)})
        arrays["coefficients"] = spline.coefficients
        if exponential:
            arrays["closing_width"] = obstacle.width
        metadata: dict[str, Any] = {
            "obstacle": "exponential" if exponential else "spline",
            "degree": spline.basis.degree,
            "k": self.navigation.k,
            "method": self.method,
            "certified": self.certified,
            "options": dict(self.options),
            "demonstrations": records,
        }
        if self.accepted:
            metadata["accepted"] = list(self.accepted)
        metric = self.navigation.metric
        if metric:
            metadata["metric_reach"] = metric.reach
            arrays |= {"metric_centres": metric.centres, "metric_logs": metric.logs}
        return metadata, arrays


def _timed_naturally(points: Array, duration: float, rate: float) -> tuple[Array, Array]:
    time = _frame_times(duration, rate)
    length = arc_length(points)
    covered = minimum_jerk(time, duration) * length[-1]
    return time, _interpolated(covered, length, points)


def _interpolated(x: Array, known: Array, points: Array) -> Array:
    """Return points (m, n) at ``x`` (m,) between points (N, n) at ``known`` (N,), increasing."""
    columns: list[Array] = list(points.T)
    return np.column_stack([np.interp(x, known, column) for column in columns])


def _frame_times(duration: float, rate: float) -> Array:
    """Frames from 0 to the first at or after the duration."""
    return np.arange(int(np.ceil(duration * rate - 1e-9)) + 1) / rate


def _navigation_of(
    metadata: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]
) -> NavigationFunction:
    n = len(arrays["subspace_components"])
    basis = TensorBasis(tuple(arrays[f"knots_{i}"] for i in range(n)), int(metadata["degree"]))
    spline = TensorBSpline(basis, arrays["coefficients"])
    if metadata["obstacle"] == "exponential":
        obstacle = ExponentialObstacle(spline, arrays["closing_width"])
    else:
        obstacle = SplineObstacle(spline)
    metric = None
    if "metric_reach" in metadata:
        reach = float(metadata["metric_reach"])
        metric = DestinationMetric(arrays["metric_centres"], arrays["metric_logs"], reach)
    return NavigationFunction(obstacle, float(metadata["k"]), metric)

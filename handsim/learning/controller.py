"""The grasp controller: subspace, navigation function, and what was recorded."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from handsim.digests import content_digest
from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import read_archive, write_archive
from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.learning._stored_controller import content_of, restored
from handsim.learning.demonstration import Demonstration, named
from handsim.learning.guide.choice import LeftOut
from handsim.learning.guide.chord_field import ChordField
from handsim.learning.guide.field import GuidedField
from handsim.learning.guide.likeness import Grasped
from handsim.learning.guide.predictor import GuideSettings, PathPredictor
from handsim.learning.movement.progress import ProgressLaw, check_duration
from handsim.learning.movement.sequence import (
    TIME_LAWS,
    PostureSequence,
    TimeLaw,
    by_gradient,
    frame_times,
)
from handsim.learning.movement.timing import FieldTiming, GuidedTiming, Timing
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.flow import ARRIVAL, FlowPath, follow
from handsim.navigation.function import NavigationFunction, inside_box
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import at_arc_length
from handsim.types import Array
from handsim.wording import number_of

SCHEMA = 4
"""Of files: 1 without a metric of destinations, 2 with few of the options, 3 without paths."""


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
    guide
        How the path of each query is predicted from the recordings; None if the flow of
        ``navigation`` is followed instead, which knows of the destination alone.
    left_out
        What leaving out each recording said of progress as a coordinate; None where it was not
        asked, as in files of earlier versions.
    ranges : (2, 22) [rad]
        Least and greatest joint angles of the person.
    """

    subspace: PostureSubspace
    navigation: NavigationFunction
    demonstrations: tuple[Demonstration, ...]
    method: str = "direction"
    certified: bool = False
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])
    accepted: tuple[str, ...] = ()
    guide: GuideSettings | None = None
    left_out: LeftOut | None = None
    ranges: Array = field(default_factory=lambda: np.array([LOWER, UPPER]))

    def __eq__(self, other: object) -> bool:
        """Whether both do the same."""
        return isinstance(other, GraspController) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash what the controller does."""
        return hash(self.digest)

    def demonstration(self, name: str) -> Demonstration:
        """Return what was learned of a recording, by a name; see `named`."""
        return named(self.demonstrations, name)

    def velocity(self, z: Array, z_goal: Array) -> Array:
        """Return u = -grad phi (n,) at one point, Eq. (1) of the paper."""
        return -self.navigation.value_and_gradient(z, z_goal)[1]

    def direction(self, z: Array, z_goal: Array) -> Array:
        """Return the unit vector (n,) of u at one point; it stays exact where phi is flat."""
        return self.navigation.direction(z, z_goal)

    @cached_property
    def predictor(self) -> PathPredictor | None:
        """What predicts paths and timings; None where a file of an earlier version has no paths."""
        if any(d.path is None for d in self.demonstrations):
            return None
        return PathPredictor.of(self.demonstrations, self.guide or GuideSettings())

    def field(
        self, z_start: Array, z_goal: Array, grasped: Grasped | None = None
    ) -> GuidedField | None:
        """Return the navigation function of a query; None for a controller without a guide.

        Parameters
        ----------
        z_start, z_goal : (n,) [rad]
        grasped
            The object, by its name or its numbers; None if nothing is known of it. An unknown name
            tells nothing.

        Raises
        ------
        InputError
            As `path`.
        """
        start, goal = self._ends(z_start, z_goal)
        obstacle = self.navigation.obstacle
        if self.guide is None or not isinstance(obstacle, ExponentialObstacle):
            return None
        assert self.predictor is not None  # files with a guide hold the paths
        path = self.predictor.path(start, goal, grasped)
        k, box = self.navigation.k, (obstacle.lower, obstacle.upper, obstacle.width)
        kind = GuidedField if self.guide.progress else ChordField
        return kind.leading(path, *box, k, self.guide.pull)

    def path(self, z_start: Array, z_goal: Array, grasped: Grasped | None = None) -> FlowPath:
        """Follow the flow of a query (see `field`) from its start to its destination.

        Raises
        ------
        InputError
            If the destination cannot be one (see `check_goal`), or numbers of an object are given
            that the recordings do not have.
        """
        guided = self.field(z_start, z_goal, grasped)
        return self._along_field(z_start, z_goal) if guided is None else guided.path(z_start)

    def _along_field(self, z_start: Array, z_goal: Array) -> FlowPath:
        """Follow the flow of ``navigation``."""
        start, goal = self._ends(z_start, z_goal)

        def directions(z: Array, z_goal: Array) -> Array:
            return self.navigation.direction(z[0], z_goal[0])[None]

        return follow(directions, start[None], goal[None])[0]

    def check_object(self, name: str) -> None:
        """Raise UnknownNameError if no recording is about an object of that name."""
        known = tuple(dict.fromkeys(d.object for d in self.demonstrations))
        if name not in known:
            raise UnknownNameError("object", name, known)

    @property
    def reach(self) -> tuple[Array, Array]:
        """Lower and upper corner (n,) [rad] of the box of possible destinations.

        With a guide it is half as large again on each side as the workspace: the proof holds
        wherever the destination lies, but nothing is known far from all recordings.
        """
        low, high = self.navigation.inner
        beyond = 0.0 if self.guide is None else 0.5 * (high - low)
        return low - beyond, high + beyond

    def check_goal(self, z_goal: Array) -> Array:
        """Return a destination as an array (n,) [rad], if the controller can go there.

        Raises
        ------
        InputError
            If it has the wrong size or lies outside `reach`, or if without a guide
            `NavigationFunction.check_goal` refuses it.
        """
        if self.guide is None:
            return self.navigation.check_goal(z_goal)
        return inside_box(z_goal, *self.reach)

    def _ends(self, z_start: Array, z_goal: Array) -> tuple[Array, Array]:
        goal = self.check_goal(z_goal)
        start = np.asarray(z_start, dtype=float)
        if start.shape != goal.shape or not np.isfinite(start).all():
            raise InputError(
                f"start of shape {start.shape}; give {number_of(len(goal), 'finite coordinate')}"
            )
        return start, goal

    def timing(
        self, z_start: Array, z_goal: Array, duration: float, grasped: Grasped | None = None
    ) -> Timing:
        """Return the velocities of a closed loop that starts at ``z_start``, (n,) [rad].

        Parameters
        ----------
        z_start, z_goal, grasped
            As in `path`.
        duration : [s]
        """
        guided = self.field(z_start, z_goal, grasped)
        law = self.progress(z_start, z_goal, duration, grasped)
        if guided is not None:
            return GuidedTiming(guided, law)
        path, goal = self._along_field(z_start, z_goal), np.asarray(z_goal, dtype=float)
        flow, direction = self.navigation.evaluator(), np.empty(len(goal))

        def direction_at(z: Array, z_goal: Array) -> Array:
            flow.direction(z, z_goal, direction)
            return direction

        return FieldTiming.along(path.points, goal, law, direction_at)

    def progress(
        self, z_start: Array, z_goal: Array, duration: float, grasped: Grasped | None = None
    ) -> ProgressLaw:
        """Return the progress over time that the person would likely make; see `timing`."""
        seconds = check_duration(duration)
        if self.predictor is None:
            return ProgressLaw(seconds)
        ends = (np.asarray(z_start, dtype=float), np.asarray(z_goal, dtype=float))
        return ProgressLaw(seconds, self.predictor.covered(*ends, seconds, grasped))

    def postures(
        self,
        q_start: Array,
        q_goal: Array | None = None,
        *,
        z_goal: Array | None = None,
        grasped: Grasped | None = None,
        time_law: TimeLaw = "learned",
        duration: float | None = None,
        rate: float = 100.0,
    ) -> PostureSequence:
        """Make the controller's movement from a posture to a destination, in all 22 joints.

        Parameters
        ----------
        q_start : (22,) [rad]
        q_goal : (22,) [rad], or z_goal : (n_components,) [rad]
            The destination, whole or in the subspace.
        grasped
            The object: its name, or its numbers as in ``experiments.csv``; None if not known.
        time_law
            ``learned``: progress as the person would likely make it; ``minimum-jerk``: bell-shaped
            speed; ``gradient``: u = -grad phi, the paper's, along the flow of ``navigation``, with
            its time scaled as a whole. (phi falls by at most 1 along a path, which bounds the
            speeds it can have; people's need a time scale of their own.)
        duration : [s]
            By default the median of the recordings.
        rate : [Hz]

        Raises
        ------
        InputError
            If not exactly one destination is given, it cannot be one, or shapes, duration or
            rate make no sense.
        UnknownNameError
            If there is no such time law.
        """
        if (q_goal is None) == (z_goal is None):
            raise InputError("give one destination, as a posture or in the subspace")
        if not (np.isfinite(rate) and rate > 0):
            raise InputError(f"rate {rate:g} Hz; give a positive number")
        if time_law not in TIME_LAWS:
            raise UnknownNameError("time law", time_law, TIME_LAWS)
        goal = np.asarray(z_goal, float) if q_goal is None else self._projected(q_goal)
        start = self._projected(q_start)
        seconds = self.median_duration if duration is None else check_duration(duration)
        if time_law == "gradient":
            path = self._along_field(start, goal)
            time, z = by_gradient(self.navigation, path, goal, seconds, rate)
        else:
            path = self.path(start, goal, grasped)
            law = ProgressLaw(seconds)
            if time_law == "learned":
                law = self.progress(start, goal, seconds, grasped)
            time = frame_times(seconds, rate)
            z = at_arc_length(path.points, law.covered(time))
        return self._sequence(time, z, path, goal)

    def _sequence(self, time: Array, z: Array, path: FlowPath, goal: Array) -> PostureSequence:
        q = self.clipped(self.subspace.inverse_transform(z))
        distance = float(np.linalg.norm(q[-1] - self.subspace.inverse_transform(goal)))
        clipped = path.arrived and distance > ARRIVAL
        reason = "clipped" if clipped else path.reason
        return PostureSequence(time, q, path.arrived and not clipped, reason, distance)

    def clipped(self, q: Array) -> Array:
        """Clip postures (..., 22) [rad] to the person's ranges of motion."""
        return np.clip(q, *self.ranges)

    def _projected(self, q: Array) -> Array:
        if np.shape(q) != (N_JOINTS,) or not np.isfinite(q).all():
            raise InputError(f"posture of shape {np.shape(q)}; give {N_JOINTS} finite angles")
        return self.subspace.transform(q)

    @property
    def median_duration(self) -> float:
        """Median duration of the recordings [s]."""
        return float(np.median([d.duration for d in self.demonstrations]))

    @cached_property
    def digest(self) -> str:
        """Digits that are the same for controllers that do the same, whatever made them.

        Numbers count as `digests.rounded` leaves them: what the last bits of another machine are
        does not matter, nor does how the controller came to be (method, options).
        """
        metadata, arrays = content_of(self)
        behaviour = ("obstacle", "degree", "k", "demonstrations", "metric_reach", "guide")
        settings = {name: metadata[name] for name in behaviour if name in metadata}
        arrays.pop("signals", None)  # only a person's signal makes use of them
        return content_digest(settings, arrays)

    def save(self, path: Path) -> None:
        """Write the controller to an ``.npz`` without pickles."""
        metadata, arrays = content_of(self)
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
            return cls(**restored(metadata, arrays))
        except InputError as error:
            raise FileError(f"{path}: {error}") from error
        except (KeyError, ValueError, TypeError, IndexError) as error:
            raise FileError(
                f"{path}: not a whole controller ({type(error).__name__}: {error}); learn it again"
            ) from error

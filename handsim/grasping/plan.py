"""How one task is to be grasped: palm pose, start and destination, and the timing of it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.learning.movement.progress import minimum_jerk
from handsim.learning.subspace import PostureSubspace
from handsim.learning.transport.walls import Plane
from handsim.tasks.task import Step, Task
from handsim.tasks.turns import composed
from handsim.types import Array

if TYPE_CHECKING:
    from handsim.learning.transport.transport import PalmReach, Transport

_SCALAR_LAST, _SCALAR_FIRST = [1, 2, 3, 0], [3, 0, 1, 2]
"""Quaternions as SciPy has them, and as they are here: SciPy takes twice as long to exchange them,
and fits make tens of thousands of poses."""
TABLE = Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]), width=0.05)
"""The table as an obstacle to a learned transport [m]."""


@dataclass(frozen=True)
class Pose:
    """A position [m] and an orientation (w, x, y, z) of one frame in another."""

    pos: Array
    quat: Array

    @cached_property
    def rotation(self) -> Rotation:
        """The orientation."""
        return Rotation.from_quat(self.quat[_SCALAR_LAST])

    def moved(self, offset: Array, turn: Rotation | None = None) -> "Pose":
        """Return the pose displaced by ``offset`` and turned in place, both in the outer frame."""
        rotation = self.rotation if turn is None else turn * self.rotation
        return Pose(self.pos + offset, rotation.as_quat()[_SCALAR_FIRST])

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Chain two poses: ``inner`` is given in this one's frame."""
        rotation = self.rotation * inner.rotation
        return Pose(self.pos + self.rotation.apply(inner.pos), rotation.as_quat(scalar_first=True))


@dataclass(frozen=True)
class Schedule:
    """Durations of the phases of a grasp [s].

    People's reaches to graspable objects take about a second, and the hand comes to the object
    while the fingers still close (M. Jeannerod 1984, J. Mot. Behav. 16(3):235-254).

    Attributes
    ----------
    reach
        From rest until the fingers have closed.
    squeeze
        Ramp of the squeeze layer.
    steps
        Durations of the task's movements, one after the other.
    hold
        What follows; a little longer than the rule asks for.
    """

    steps: tuple[float, ...]
    hold: float
    reach: float = 1.2
    squeeze: float = 0.5

    @property
    def squeeze_start(self) -> float:
        """When the squeeze begins [s]."""
        return self.reach

    @property
    def action_start(self) -> float:
        """When the task's first movement begins [s]."""
        return self.reach + self.squeeze

    @property
    def hold_start(self) -> float:
        """When the last movement has ended [s]."""
        return self.action_start + sum(self.steps)

    @property
    def end(self) -> float:
        """When the run ends [s]."""
        return self.hold_start + self.hold


def schedule_for(task: Task) -> Schedule:
    """Return the timing of a task."""
    return Schedule(steps=tuple(step.seconds for step in task.steps), hold=task.rule.hold + 0.1)


@dataclass(frozen=True)
class GraspPlan:
    """Where palm and fingers go to grasp an object.

    Attributes
    ----------
    palm
        Pose of the palm at the grasp, in the object frame.
    retreat : (3,)
        From the palm at the grasp back to where the reach begins, object frame [m].
    q_start, q_goal : (22,) [rad]
        Postures at the start and at the grasp.
    squeeze
        Factor on the flexion with which the hand closes after the reach.
    grip
        What thumb and fingers press on their sides then [N].
    arrive
        Fraction of the reach at which the palm is in place.
    z_goal : (n_components,) [rad]
        Destination in the subspace of the controller that it is a plan for, which is followed to
        the bit; ``q_goal`` is then its posture, within the joint ranges. None where no controller
        was planned for: a script plays ``q_goal``, a controller goes to its projection.
    transport
        What was learned of how palms come to things; None: along a straight line with minimum jerk.
        It is no part of a stored plan.
    """

    palm: Pose
    retreat: Array
    q_start: Array
    q_goal: Array
    squeeze: float = 1.0
    grip: float = 3.0
    arrive: float = 0.85
    z_goal: Array | None = None
    transport: "Transport | None" = None

    @property
    def stored(self) -> dict[str, object]:
        """What a stored plan holds, by name: all but the transport."""
        return {name: value for name, value in vars(self).items() if name != "transport"}

    def goal_in(self, subspace: PostureSubspace) -> Array:
        """Return the destination in a subspace: ``z_goal``, or the projection of ``q_goal``."""
        return subspace.transform(self.q_goal) if self.z_goal is None else self.z_goal


@lru_cache(maxsize=64)
def _reach_of(transport: "Transport", start: bytes, goal: bytes, duration: float) -> "PalmReach":
    """Return a reach from start to goal, (3,) [m] each: a plan's runs have it in common."""
    ends = np.frombuffer(start), np.frombuffer(goal)
    return transport.reach(*ends, (TABLE,), duration)


@dataclass(frozen=True)
class PalmPath:
    """Commanded movement of the palm through a whole task.

    The reach comes in along the retreat, or from its end as was learned; after the squeeze each
    step of the task moves the palm rigidly about the grasp point.
    """

    plan: GraspPlan
    task: Task
    schedule: Schedule
    object_pose: Pose

    def poses(self, times: Array) -> tuple[Array, Array]:
        """Return the palm's positions (n, 3) [m] and orientations (n, 4) in the world at times."""
        grasp = self.object_pose @ self.plan.palm
        if self.plan.transport is None:
            back = 1.0 - ramp(times, 0.0, self._duration)
            retreat = self.object_pose.rotation.apply(self.plan.retreat)
            coming = grasp.pos + back[:, None] * retreat
        else:
            coming = self.learned_reach.at(times)
        shift, turn = self._carried(times)
        pos = shift + turn.apply(coming)
        return pos, composed(turn, grasp.rotation).as_quat(scalar_first=True)

    @cached_property
    def learned_reach(self) -> "PalmReach":
        """How the palm comes in by the plan's transport, with the table as an obstacle.

        Raises
        ------
        InputError
            If the flow does not arrive, which a certified one does, or is not to be followed.
        """
        assert self.plan.transport is not None
        goal = (self.object_pose @ self.plan.palm).pos
        start = goal + self.object_pose.rotation.apply(self.plan.retreat)
        reach = _reach_of(self.plan.transport, start.tobytes(), goal.tobytes(), self._duration)
        if not reach.path.arrived:
            raise InputError(
                f"the learned transport does not bring the palm to {self.task.name} "
                f"({reach.path.reason}); let it go straight"
            )
        return reach

    @property
    def _duration(self) -> float:
        """Until the palm is in place [s]."""
        return self.plan.arrive * self.schedule.reach

    def at(self, time: float) -> Pose:
        """Return the palm's pose in the world at ``time`` [s]."""
        pos, quat = self.poses(np.array([time]))
        return Pose(pos[0], quat[0])

    def flexions(self, times: Array) -> Array:
        """Return the flexion that the task's steps add to single fingers, (n, 22) [rad]."""
        flexion = np.zeros((len(times), N_JOINTS))
        for step, start in self._steps():
            added = np.deg2rad(step.angle_deg) * ramp(times, start, step.seconds)
            for finger in step.flex:
                flexion[:, JOINT_INDEX[f"{finger}_mcp"]] += added
        return flexion

    def _carried(self, times: Array) -> tuple[Array, Rotation]:
        """Return the rigid motion of palm and object since the squeeze: shift (n, 3) and turn."""
        shift, turn, turned = np.zeros((len(times), 3)), Rotation.identity(len(times)), False
        grasp_point = self.object_pose.pos + self.object_pose.rotation.apply(self.task.grasp.point)
        for step, start in self._steps():
            part = ramp(times, start, step.seconds)[:, None]
            turns = bool(step.angle_deg) and not step.flex
            point = shift + (turn.apply(grasp_point) if turned else grasp_point)
            aside = shift - point
            if turns:
                axis = np.tile(step.axis, (len(times), 1))
                added = Rotation.from_rotvec(part * np.deg2rad(step.angle_deg) * axis)
                aside, turn, turned = added.apply(aside), composed(added, turn), True
            elif turned:  # as by a turn of nothing, which is normalised
                turn = Rotation.from_quat(turn.as_quat())
            shift = point + part * np.array(step.shift) + aside
        return shift, turn

    def _steps(self) -> Iterator[tuple[Step, float]]:
        start = self.schedule.action_start
        for step in self.task.steps:
            yield step, start
            start += step.seconds


def ramp(times: npt.ArrayLike, start: float, duration: float) -> Array:
    """Return a smooth 0 to 1 between ``start`` and ``start + duration`` [s] (minimum jerk)."""
    return minimum_jerk(np.asarray(times, dtype=float) - start, duration)

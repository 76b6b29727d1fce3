"""All of a run's commands that are known before it begins: the palm's path, the squeeze, noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.arm.reaching_arm import ArmPosture, ReachingArm
from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.squeeze import closing
from handsim.grasping.plan import GraspPlan, PalmPath, Pose, Schedule, ramp
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.glove import RATE, DataGlove
from handsim.hand.kinematics import Kinematics
from handsim.joints import N_JOINTS
from handsim.physics import GRAVITY
from handsim.tasks.task import Task
from handsim.types import MEDIAN_HAND, Array, HandSize, Mask

SHAKE_FREQUENCY = 2.0
"""Frequency at which the hand is shaken during the hold [Hz]."""
LOST = 0.02
"""An object that has risen less than this while the palm rose twice as far is lost [m]."""


@dataclass(frozen=True)
class Commands:
    """Commands of a run that do not depend on readings, and the disturbances it will meet.

    There is a row for each reading of the glove. Those of several runs (`together`) have the runs
    as second axis.

    Attributes
    ----------
    schedule
        Durations of the phases.
    times : (n,) [s]
        When the glove is read.
    palm_pos, palm_quat : (n, ..., 3) [m], (n, ..., 4)
        Where the palm is to be.
    closing : (22,) [rad]
        How the fingers that grasp close, to squeeze.
    closed : (n,)
        How far the squeeze has come, 0 to 1.
    flexion : (n, 22) [rad]
        Movements of single fingers in the action.
    arrival
        Row of the last reading of the reach.
    action
        Row of the first reading of the action.
    lifted
        Whether the task lifts its object.
    lift : (n, ...) [m]
        How far the palm has risen since the action began; minus infinity before.
    load : (n, ..., 3) [m/s^2]
        Force on each kilogram with which the palm carries: against gravity, and to accelerate.
    weight : (n, ...) [N]
        What the hand is to carry, upwards.
    disturbance : (n, ..., 22) [rad]
        The glove's noise and bias.
    lost : (n, ...)
        Readings that do not come; the one before is taken.
    reach
        Angles of the arm along the palm's path; None where no arm carries the hand.
    """

    schedule: Schedule
    times: Array
    palm_pos: Array
    palm_quat: Array
    closing: Array
    closed: Array
    flexion: Array
    arrival: int
    action: int
    lifted: bool
    lift: Array
    load: Array
    weight: Array
    disturbance: Array
    lost: Mask
    reach: ArmPosture | None = None

    @classmethod
    def of(
        cls, plan: GraspPlan, task: Task, schedule: Schedule, size: HandSize = MEDIAN_HAND
    ) -> "Commands":
        """Return the commands of a run that nothing disturbs, for a hand of some size."""
        times, path = read_at(schedule), expected_path(plan, task, schedule)
        palm_pos, palm_quat = path.poses(times)
        action = round(schedule.action_start * RATE)
        lift = palm_pos[:, 2] - palm_pos[action, 2]
        lift[: action + 1] = -np.inf
        return cls(
            schedule,
            times,
            palm_pos,
            palm_quat,
            closing=closing(
                plan.q_goal,
                plan.palm.rotation.inv().apply(task.grasp.opposition),
                task.grasp.fingers,
                plan.squeeze,
                _kinematics(size),
            ),
            closed=ramp(times, schedule.squeeze_start, schedule.squeeze),
            flexion=path.flexions(times),
            arrival=int(np.searchsorted(times, schedule.reach, side="right")) - 1,
            action=action,
            lifted=task.rule.lifted,
            lift=lift,
            load=_load(palm_pos),
            weight=task.object.mass * _load(palm_pos)[:, 2],
            disturbance=np.zeros((len(times), N_JOINTS)),
            lost=np.zeros(len(times), dtype=bool),
        )

    def reached(self, arm: ReachingArm, q: Array) -> "Commands":
        """Return the commands for an arm that would like the wrist of a posture (22,) [rad]."""
        return replace(self, reach=arm.posture(self.palm_pos, self.palm_quat, q[WRIST_COLUMNS]))

    def disturbed(self, conditions: Conditions, glove: DataGlove) -> "Commands":
        """Return the commands with shaking and the glove's noise; both come from the seed."""
        generator = np.random.default_rng(conditions.seed)
        shaking = _shaking(self.times, conditions.shake, self.schedule, generator)
        disturbance = glove.disturbance(self.disturbance.shape, generator)
        sides = generator.choice([-1.0, 1.0], N_JOINTS)
        drift = self.times[:, None] * conditions.drift * sides
        palm_pos = self.palm_pos + shaking
        return replace(
            self,
            palm_pos=palm_pos,
            load=_load(palm_pos),
            disturbance=disturbance + conditions.bias * sides + drift,
            lost=generator.uniform(size=len(self.times)) < conditions.lost,
        )

    def row(self, time: float) -> int:
        """Return the row of the first reading at or after a time [s]."""
        return int(np.searchsorted(self.times, time - 1e-9))

    @classmethod
    def together(cls, commands: Sequence["Commands"]) -> "Commands":
        """Return the commands of several runs of one schedule, with the runs as second axis."""
        names = ("palm_pos", "palm_quat", "lift", "load", "weight", "disturbance", "lost")
        stacked = {name: np.stack([getattr(each, name) for each in commands], 1) for name in names}
        return replace(commands[0], **stacked)

    def due_to_rise(self, required: float) -> Mask:
        """Return the readings (n, ...) at which an object that has not risen by `LOST` is lost.

        ``required`` is the rise that the task asks for [m]; objects that need not rise by `LOST`
        are never lost.
        """
        return (self.lift >= 2 * LOST) & (required >= LOST)


@cache
def _kinematics(size: HandSize) -> Kinematics:
    """Return the bodies of a hand of some size, which take longer to find than to place."""
    return Kinematics(size)


def read_at(schedule: Schedule) -> Array:
    """Return the times at which the glove is read, (n,) [s]."""
    return np.arange(round(schedule.end * RATE) + 1) / RATE


def expected_path(plan: GraspPlan, task: Task, schedule: Schedule) -> PalmPath:
    """Return the palm's path to an object that stands as the task says."""
    return PalmPath(plan, task, schedule, expected_object(task))


def expected_object(task: Task) -> Pose:
    """Return the pose in the world of an object that stands as the task says."""
    expected = Rotation.from_euler("z", np.deg2rad(task.yaw_deg))
    return Pose(np.array([*task.place, 0.0]), expected.as_quat(scalar_first=True))


def _load(palm_pos: Array) -> Array:
    """Return the acceleration of a path (n, 3) [m], with that against gravity, (n, 3) [m/s^2]."""
    acceleration = np.zeros_like(palm_pos)
    acceleration[1:-1] = np.diff(palm_pos, 2, axis=0) * RATE**2
    acceleration[:, 2] += GRAVITY
    return acceleration


def _shaking(
    times: Array, acceleration: float, schedule: Schedule, generator: np.random.Generator
) -> Array:
    """Return horizontal shifts of the hand during the hold, in a random direction, (n, 3) [m].

    ``acceleration`` is their amplitude [m/s^2].
    """
    angle = generator.uniform(0.0, 2 * np.pi)
    omega = 2 * np.pi * SHAKE_FREQUENCY
    since = times - schedule.hold_start
    swing = ramp(since, 0.0, 0.5) * acceleration / omega**2 * np.sin(omega * since)
    return swing[:, None] * np.array([np.cos(angle), np.sin(angle), 0.0])

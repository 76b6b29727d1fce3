"""What is laid down of a run before it begins: times, the palm's way, added flexion, noise."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, PalmPath, Pose, Schedule, ramp
from handsim.grasping.rollout.glove import RATE, DataGlove
from handsim.grasping.rollout.squeeze import squeeze_offset
from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.tasks.task import Task
from handsim.types import Array

SHAKE_FREQUENCY = 2.0
"""Of the base's shaking during the hold [Hz]."""
LOST = 0.02
"""Rise [m] that an object must show while the palm rises twice as far."""


@dataclass(frozen=True)
class Commands:
    """A run as it is commanded, apart from what the driver makes of readings.

    There is a row for each reading of the glove.

    Attributes
    ----------
    schedule
    times : (n,) [s]
    palm_pos, palm_quat : (n, 3) [m], (n, 4)
        Where the palm is to be.
    added : (n, 22) [rad]
        Flexion on top of the driver's targets: squeeze, and movements of single fingers.
    arrival
        Row of the last reading of the reach.
    lift : (n,) [m]
        How far the palm has been lifted since the action began, minus infinity before it.
    disturbance : (n, 22) [rad]
        The glove's noise.
    """

    schedule: Schedule
    times: Array
    palm_pos: Array
    palm_quat: Array
    added: Array
    arrival: int
    lift: Array
    disturbance: Array

    @classmethod
    def of(cls, plan: GraspPlan, task: Task, schedule: Schedule) -> "Commands":
        """Lay down a run with nothing that disturbs it."""
        times = np.arange(round(schedule.end * RATE) + 1) / RATE
        expected = Rotation.from_euler("z", np.deg2rad(task.yaw_deg))
        there = Pose(np.zeros(3), expected.as_quat(scalar_first=True))
        path = PalmPath(plan, task, schedule, there)
        palm_pos, palm_quat = path.poses(times)
        strength = ramp(times, schedule.squeeze_start, schedule.squeeze)
        squeeze = squeeze_offset(plan.squeeze, task.grasp.fingers)
        action = round(schedule.action_start * RATE)
        lift = palm_pos[:, 2] - palm_pos[action, 2]
        lift[: action + 1] = -np.inf
        return cls(
            schedule,
            times,
            palm_pos,
            palm_quat,
            added=strength[:, None] * squeeze + path.flexions(times),
            arrival=int(np.searchsorted(times, schedule.reach, side="right")) - 1,
            lift=lift,
            disturbance=np.zeros((len(times), N_JOINTS)),
        )

    def disturbed(self, conditions: Conditions, glove: DataGlove) -> "Commands":
        """Return the commands with shaking and the glove's noise; both come from the seed."""
        generator = np.random.default_rng(conditions.seed)
        shaking = _shaking(self.times, conditions.shake, self.schedule, generator)
        disturbance = glove.disturbance(self.disturbance.shape, generator)
        return replace(self, palm_pos=self.palm_pos + shaking, disturbance=disturbance)

    def commanded(self, targets: Array, rows: int | slice) -> Array:
        """Return what the actuators are told, (..., 22) [rad], where the driver gives targets."""
        return np.minimum(np.maximum(targets + self.added[rows], LOWER), UPPER)


def _shaking(
    times: Array, acceleration: float, schedule: Schedule, generator: np.random.Generator
) -> Array:
    """Return a horizontal shake of the hand in the hold, in a random direction, (n, 3) [m].

    ``acceleration`` is its amplitude [m/s^2].
    """
    angle = generator.uniform(0.0, 2 * np.pi)
    omega = 2 * np.pi * SHAKE_FREQUENCY
    since = times - schedule.hold_start
    swing = ramp(since, 0.0, 0.5) * acceleration / omega**2 * np.sin(omega * since)
    return swing[:, None] * np.array([np.cos(angle), np.sin(angle), 0.0])

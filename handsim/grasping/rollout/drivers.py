"""What drives the 22 joints during a reach: a script, or the learned controller."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from handsim.grasping.plan import GraspPlan, Schedule, ramp
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.timing import NaturalTiming
from handsim.types import Array


class Driver(Protocol):
    """Gives joint targets from the glove's readings, 100 times a second."""

    @property
    def name(self) -> str:
        """What the driver is called in a rollout."""
        ...

    @property
    def reach(self) -> float:
        """When the reach ends [s]: from then on the targets stay, whatever is read."""
        ...

    def targets(self, time: float, reading: Array) -> Array:
        """Return joint targets for a reading (22,), or for several (n, 22), at ``time`` [s].

        Targets are (22,) [rad], or (n, 22) where they differ between readings. Readings together
        give the same bits as each by itself, here as in `coordinates`.
        """
        ...

    def coordinates(self, reading: Array) -> Array:
        """Return readings (..., 22) as the driver sees them, (..., n_components).

        A script sees nothing: n_components is 0.
        """
        ...

    def arrived(self, reading: Array) -> bool:
        """Whether the reading is at the destination."""
        ...


@dataclass(frozen=True)
class ScriptedDriver:
    """Plays a rest posture, a pre-shape and a closed posture one after the other.

    The aperture of people's hands is largest at about two thirds of the reach (Jeannerod 1984).

    Attributes
    ----------
    q_start, q_open, q_close : (22,) [rad]
        Postures at rest, at the largest aperture and at the end.
    reach
        Duration [s].
    peak_aperture_at
        Fraction of the reach at which the hand is most open.
    """

    q_start: Array
    q_open: Array
    q_close: Array
    reach: float
    peak_aperture_at: float = 0.62
    name: str = "demonstrator"

    def targets(self, time: float, reading: Array) -> Array:
        """Return the scripted posture; a script does not look at the reading."""
        opening = ramp(time, 0.0, self.peak_aperture_at * self.reach)
        closing = ramp(
            time, self.peak_aperture_at * self.reach, (1 - self.peak_aperture_at) * self.reach
        )
        posture = self.q_start + opening * (self.q_open - self.q_start)
        return posture + closing * (self.q_close - posture)

    def coordinates(self, reading: Array) -> Array:
        """Return nothing: a script has no subspace."""
        return np.empty((*reading.shape[:-1], 0))

    def arrived(self, reading: Array) -> bool:
        """Return True: a script always plays to its end."""
        return True


@dataclass(frozen=True)
class LearnedDriver:
    """Closes the loop through the learned controller.

    The reading is projected onto the subspace, the navigation function says where to move, and
    the actuators' targets lead the projected posture by what they need to move at that speed.

    Attributes
    ----------
    controller
        The learned controller.
    z_goal : (n_components,) [rad]
        Destination.
    timing
        Speed along the path.
    lead : (22,) [s]
        Ratio of damping to stiffness of each position actuator: a target that leads a moving
        joint by velocity times lead keeps it at that velocity.
    reach
        When the destination itself becomes the target [s].
    """

    controller: GraspController
    z_goal: Array
    timing: NaturalTiming
    lead: Array
    reach: float
    name: str = "controller"

    def targets(self, time: float, reading: Array) -> Array:
        """Return the projected reading, led by the velocity that the controller asks for."""
        subspace = self.controller.subspace
        if time >= self.reach:
            return clip_to_range(subspace.inverse_transform(self.z_goal))
        if reading.ndim > 1:
            return self._targets_of_many(time, reading)
        z = subspace.transform(reading)
        velocity = self.timing.velocity(z, time)
        posture = subspace.inverse_transform(z)
        return clip_to_range(posture + (velocity @ subspace.components_) * self.lead)

    def _targets_of_many(self, time: float, readings: Array) -> Array:
        # Stacks of vectors, so that there are as many products of a vector with a matrix: a
        # product of two matrices would round otherwise, and so would `directions`.
        subspace, flow = self.controller.subspace, self.controller.navigation.evaluator()
        z = subspace.transform(readings[:, None])
        direction = np.empty_like(z[:, 0])
        for here, there in zip(z[:, 0], direction, strict=True):
            flow.direction(here, self.z_goal, there)
        velocity = direction * self.timing.speeds(z[:, 0], time)[:, None]
        lead = (velocity[:, None] @ subspace.components_)[:, 0] * self.lead
        return clip_to_range(subspace.inverse_transform(z)[:, 0] + lead)

    def coordinates(self, reading: Array) -> Array:
        """Return readings in the subspace, (..., n_components) [rad]."""
        return self.controller.subspace.transform(reading[..., None, :])[..., 0, :]

    def arrived(self, reading: Array) -> bool:
        """Whether the reading lies within 15 deg of the destination, contact included."""
        distance = np.linalg.norm(self.coordinates(reading) - self.z_goal)
        return bool(distance < np.deg2rad(15.0))


def learned_driver(
    controller: GraspController, plan: GraspPlan, lead: Array, schedule: Schedule
) -> LearnedDriver:
    """Return the driver that takes a controller from a plan's start to its destination.

    Raises
    ------
    InputError
        If the controller cannot have that destination.
    """
    z_start, z_goal = controller.subspace.transform(np.stack([plan.q_start, plan.q_goal]))
    if plan.z_goal is not None:
        z_goal = plan.z_goal
    timing = controller.timing(z_start, z_goal, schedule.reach)
    return LearnedDriver(controller, z_goal, timing, lead, schedule.reach)

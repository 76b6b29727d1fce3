"""Drivers that go where a policy says: by velocities in the subspace, or by joint targets."""

import numpy as np

from handsim.environments.entries import SPEED, ActionKind, targets_of
from handsim.grasping.plan import GraspPlan, Schedule, ramp
from handsim.grasping.rollout.drivers import timed_driver
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.types import Array


class AskedVelocity:
    """Timing of a closed loop in which somebody else says the velocity.

    Attributes
    ----------
    value : (n, n_components) [rad/s]
        Of each run.
    """

    value: Array = np.zeros((1, 1))

    def velocities(self, z: Array, time: float) -> Array:
        """Return the velocities that are asked for, whatever the points z (n, n_components) are."""
        return self.value


class SteeredDriver:
    """Goes on through the whole run as a policy says; what is asked of a driver else is the plan's.

    Parameters
    ----------
    controller, plan
    lead : (22,) [s]
        As of `LearnedDriver`.
    schedule
        Of the task.

    Attributes
    ----------
    name
        Of the driver in a rollout.
    reach
        Never over [s]: a policy is asked at every reading.
    """

    name = "policy"

    def __init__(
        self, controller: GraspController, plan: GraspPlan, lead: Array, schedule: Schedule
    ) -> None:
        self.reach = schedule.end + 1.0
        self._schedule = schedule
        self._asked = AskedVelocity()
        self._led = timed_driver(controller, plan, self._asked, lead, schedule)
        (low, high), z_start = controller.reach, self._led.z_start
        # Rows, since NumPy is faster with arrays of one shape.
        self._low = np.minimum(low, z_start)[None]
        self._high = np.maximum(high, z_start)[None]

    @property
    def destination(self) -> Array:
        """Posture of the planned destination (22,) [rad]."""
        return self._led.destination

    def start(self, n: int) -> Array:
        """Return the start of the planned movement, (n, n_components) [rad]."""
        return self._led.start(n)

    def coordinates(self, readings: Array) -> Array:
        """Return readings in the subspace, (n, n_components) [rad]."""
        return self._led.coordinates(readings)

    def arrived(self, reading: Array) -> bool:
        """Whether a reading is at the planned destination, as for the controller."""
        return self._led.arrived(reading)

    def reaching(self, time: float) -> bool:
        """Whether the reach is going on at a time [s]."""
        return time <= self._schedule.reach


class VelocityDriver(SteeredDriver):
    """Moves the hand in the subspace with the velocity that it is given.

    In the reach it does what `LearnedDriver` does, with another velocity: the point in the subspace
    is drawn a little to each reading, and the targets lead. When the reach is over the targets go
    over to the point's posture as the hand squeezes. The point stays where destinations may lie.
    """

    _drawn_of: tuple[Array | None, Array | None] = (None, None)
    _stayed: list[list[float]] | None = None

    def give(self, actions: Array) -> None:
        """Take the next velocities, (n, n_components) in `SPEED`."""
        self._asked.value = SPEED * actions

    def point(self, time: float, reference: Array, readings: Array) -> Array:
        """Return where the hand is meant to be at a reading, (n, n_components) [rad]."""
        if not self.reaching(time):
            return reference
        of, by = self._drawn_of
        if reference is not of or readings is not by:  # it is asked for twice a reading
            self._drawn_of = reference, readings
            self._drawn = self._led.drawn(reference, readings)
        return self._drawn

    def step(
        self, time: float, dt: float, reference: Array, readings: Array
    ) -> tuple[Array, Array]:
        """Return targets (n, 22) [rad] and the next point."""
        if self.reaching(time):
            point = self.point(time, reference, readings)
            targets, following = self._led.led(time, dt, point)
            self._last = targets
        else:
            schedule, following = self._schedule, reference + dt * self._asked.value
            targets = posture = self._posture_at(reference)
            if time < schedule.action_start:
                closed = ramp(time, schedule.squeeze_start, schedule.squeeze)
                targets = self._last + closed * (posture - self._last)
        return targets, np.minimum(np.maximum(following, self._low), self._high)

    def _posture_at(self, z: Array) -> Array:
        """Return the posture of points, (n, 22) [rad]; the same array while they stay."""
        now = z.tolist()
        if now != self._stayed:
            subspace = self._led.controller.subspace
            # A stack of vectors: a product of two matrices rounds otherwise than each by itself.
            posture = subspace.inverse_transform(z[:, None])[:, 0]
            self._stayed, self._posture = now, clip_to_range(posture)
        return self._posture


class TargetDriver(SteeredDriver):
    """Tells the joint targets that it is given."""

    def give(self, actions: Array) -> None:
        """Take the next targets, (n, 22) from -1 to 1 within the joints' ranges."""
        self._targets = targets_of(actions)

    def point(self, time: float, reference: Array, readings: Array) -> Array:
        """Return the readings in the subspace, (n, n_components) [rad]."""
        return self.coordinates(readings)

    def step(
        self, time: float, dt: float, reference: Array, readings: Array
    ) -> tuple[Array, Array]:
        """Return the targets (n, 22) [rad]; readings do not count."""
        return self._targets, reference


Steered = VelocityDriver | TargetDriver


def steered_driver(
    kind: ActionKind,
    controller: GraspController,
    plan: GraspPlan,
    lead: Array,
    schedule: Schedule,
) -> Steered:
    """Return the driver for a kind of action; the parameters are those of `SteeredDriver`."""
    made = VelocityDriver if kind == "components" else TargetDriver
    return made(controller, plan, lead, schedule)

"""Drivers of the 22 joints during a reach: a script, or the learned controller."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from handsim.grasping.plan import GraspPlan, Schedule, ramp
from handsim.joints import LOWER, UPPER, clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.movement.progress import ProgressLaw
from handsim.learning.movement.timing import Timing
from handsim.learning.transport.coupling import WIDEST_AT
from handsim.reproducible import totals_of
from handsim.types import Array

CORRECTION = 0.02
"""Share of the difference to each reading that a reference takes on: a time constant of 0.5 s."""


class Driver(Protocol):
    """Turns the glove's readings into joint targets, 100 times a second.

    Readings are those of n runs at one time. Each run gets the same bits as by itself.
    """

    @property
    def name(self) -> str:
        """Name of the driver in a rollout."""
        ...

    @property
    def reach(self) -> float:
        """When the reach ends [s]; targets then go over to the destination."""
        ...

    def start(self, n: int) -> Array:
        """Return where n runs are meant to be at first, (n, k), in the driver's own coordinates."""
        ...

    def step(
        self, time: float, dt: float, reference: Array, readings: Array
    ) -> tuple[Array, Array]:
        """Return joint targets, and where runs are meant to be at the next reading.

        Parameters
        ----------
        time, dt
            Now, and until the next reading [s].
        reference : (n, k)
            Where the runs are meant to be now.
        readings : (n, 22) [rad]

        Returns
        -------
        (n, 22) or (22,) [rad], (n, k)
            Targets, (22,) where they are the same for all, and the next reference.
        """
        ...

    @property
    def destination(self) -> Array:
        """Joint targets (22,) [rad] after the reach."""
        ...

    def coordinates(self, readings: Array) -> Array:
        """Return readings (n, 22) [rad] in the driver's subspace, (n, n_components) [rad].

        n_components is 0 for a driver without a subspace.
        """
        ...

    def arrived(self, reading: Array) -> bool:
        """Whether a reading (22,) [rad] is at the destination."""
        ...


@dataclass(frozen=True)
class ScriptedDriver:
    """Moves from a rest posture to a pre-shape and on to a closed posture.

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

    def start(self, n: int) -> Array:
        """Return an empty array (n, 0): a script needs no memory."""
        return np.empty((n, 0))

    def step(
        self, time: float, dt: float, reference: Array, readings: Array
    ) -> tuple[Array, Array]:
        """Return the scripted posture (22,) [rad]; readings do not count."""
        opening = ramp(time, 0.0, self.peak_aperture_at * self.reach)
        closing = ramp(
            time, self.peak_aperture_at * self.reach, (1 - self.peak_aperture_at) * self.reach
        )
        posture = self.q_start + opening * (self.q_open - self.q_start)
        return posture + closing * (self.q_close - posture), reference

    @property
    def destination(self) -> Array:
        """The closed posture (22,) [rad]."""
        return self.q_close

    def coordinates(self, readings: Array) -> Array:
        """Return an empty array (n, 0): a script has no subspace."""
        return np.empty((len(readings), 0))

    def arrived(self, reading: Array) -> bool:
        """Return True: a script always comes to its end."""
        return True


@dataclass(frozen=True)
class LearnedDriver:
    """Closes the loop through the learned controller.

    The controller's velocity is integrated to a reference in the subspace, which is drawn a little
    to each reading (`CORRECTION`). The targets are the reference's posture plus what makes the
    actuators move at its velocity (``lead``). A target made from the reading itself would take a
    glove that is off by 3 deg for a hand that moves at 3 deg / lead, some 150 deg/s.

    Attributes
    ----------
    controller
        The learned controller.
    z_start, z_goal : (n_components,) [rad]
        Start and destination.
    timing
        Velocities over time.
    lead : (22,) [s]
        Ratio of damping to stiffness of each position actuator: a target that leads a moving
        joint by velocity times lead keeps it at that velocity.
    reach
        When the reach ends [s]; from then on the target is the destination.
    outside : (22,) [rad]
        What the posture at the start has beside its place in the subspace. It fades until the hand
        is to be widest, since a hand that sprang to the subspace would open within a tenth of a
        second.
    widest_at
        When the hand is to be widest, and that has faded [s].
    """

    controller: GraspController
    z_start: Array
    z_goal: Array
    timing: Timing
    lead: Array
    reach: float
    name: str = "controller"
    outside: Array | None = None
    widest_at: float = 0.0

    def start(self, n: int) -> Array:
        """Return the start of the planned movement, (n, n_components) [rad]."""
        return np.tile(self.z_start, (n, 1))

    def step(
        self, time: float, dt: float, reference: Array, readings: Array
    ) -> tuple[Array, Array]:
        """Return the reference's posture with the lead for its velocity, (n, 22) [rad]."""
        return self.led(time, dt, self.drawn(reference, readings))

    def led(self, time: float, dt: float, z: Array) -> tuple[Array, Array]:
        """Return the same for references (n, n_components) [rad] that are drawn already."""
        subspace, n = self.controller.subspace, len(z)
        velocity = self.timing.velocities(z, time)
        # A stack of vectors (2 n, 1, n_components): each is multiplied with the matrix by itself,
        # since a product of two matrices rounds otherwise.
        lifted = (np.concatenate([velocity, z])[:, None] @ subspace.components_)[:, 0]
        mean, lead, lower, upper = self._as_rows
        targets = lifted[n:] + mean + lifted[:n] * lead
        if self.outside is not None and time < self.widest_at:
            targets += self._left(time)
        return np.minimum(np.maximum(targets, lower), upper), z + dt * velocity

    def drawn(self, reference: Array, readings: Array) -> Array:
        """Return references (n, n_components) [rad], each drawn a little to its reading."""
        if len(readings) == 1:  # the same bits, faster
            deviation = readings[0] - self.controller.subspace.mean_
            products = deviation[:, None] * self._columns
            before = reference[0].tolist()
            z = totals_of(products.ravel().tolist(), len(before))
            return np.array(
                [[at + CORRECTION * (to - at) for at, to in zip(before, z, strict=True)]]
            )
        return reference + CORRECTION * (self.coordinates(readings) - reference)

    def _left(self, time: float) -> Array:
        """Return what is left of ``outside`` and the lead for its fading, (22,) [rad]."""
        assert self.outside is not None
        covered, rate = self._fading.at(time)
        left = 1.0 - covered
        return self.outside * (left - rate * self.lead)

    @cached_property
    def _fading(self) -> ProgressLaw:
        return ProgressLaw(self.widest_at)

    @cached_property
    def _as_rows(self) -> tuple[Array, ...]:
        """What all runs have in common, (1, 22): NumPy is faster with one shape than with two."""
        mean = self.controller.subspace.mean_
        return mean[None], self.lead[None], LOWER[None], UPPER[None]

    @cached_property
    def _columns(self) -> Array:
        return self.controller.subspace.components_.T.copy()

    @property
    def destination(self) -> Array:
        """The posture of the destination (22,) [rad]."""
        return clip_to_range(self.controller.subspace.inverse_transform(self.z_goal))

    def coordinates(self, readings: Array) -> Array:
        """Return readings in the subspace, (n, n_components) [rad]."""
        return self.controller.subspace.transform(readings)

    def arrived(self, reading: Array) -> bool:
        """Whether the reading lies within 15 deg of the destination, contact included."""
        distance = np.linalg.norm(self.coordinates(reading) - self.z_goal)
        return bool(distance < np.deg2rad(15.0))


def learned_driver(
    controller: GraspController,
    plan: GraspPlan,
    lead: Array,
    schedule: Schedule,
    grasped: str | None = None,
) -> LearnedDriver:
    """Return the driver that moves the hand by a controller from a plan's start to its destination.

    Parameters
    ----------
    controller, plan
    lead : (22,) [s]
    schedule
    grasped
        Name of the object; one that no recording is about tells the controller nothing.

    Raises
    ------
    InputError
        If the controller cannot go to that destination.
    """
    z_start, z_goal = controller.subspace.transform(plan.q_start), plan.goal_in(controller.subspace)
    timing = controller.timing(z_start, z_goal, schedule.reach, grasped)
    return timed_driver(controller, plan, timing, lead, schedule)


def timed_driver(
    controller: GraspController, plan: GraspPlan, timing: Timing, lead: Array, schedule: Schedule
) -> LearnedDriver:
    """Return the driver that moves the hand from a plan's start with velocities that are given.

    Parameters
    ----------
    controller, plan
    timing
        The velocities.
    lead : (22,) [s]
    schedule
    """
    subspace = controller.subspace
    z_start = subspace.transform(plan.q_start)
    return LearnedDriver(
        controller,
        z_start,
        plan.goal_in(subspace),
        timing,
        lead,
        schedule.reach,
        outside=plan.q_start - subspace.inverse_transform(z_start),
        widest_at=WIDEST_AT * plan.arrive * schedule.reach,
    )

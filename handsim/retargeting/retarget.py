"""Map movements of the human hand to a robot hand of other proportions or joints.

The paper leaves this for later (its Sec. VII); here fingertips are matched, all postures of a
movement in one optimisation. What counts most is what grasps: how far each fingertip is from the
thumb's. Which way that opening points, where fingertips are and which way they point come second,
and the thumb itself may stand elsewhere. Links do not run into one another, and no coordinate
changes faster than it may (`handsim.retargeting.solving.residuals` has the terms).

In the frame of the palm, with h_i the pads of the human fingers and p_i those of the robot, the
targets are

    p_i - p_thumb = s (h_i - h_thumb),    p_i = robot's root_i + s_i (h_i - human root_i),

with s = length of the robot's / human fingers, and s_i the same of finger i, so that each finger
moves about where it is rooted, however broad the palm is. Openings count the more the closer they
are: grasps live there, and what touches in the human hand must touch in the robot's.

The wrist's two angles are not mapped: they belong to whatever carries the robot's palm. Ball
joints, closed loops and tendons that are held together are refused.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from handsim.content import ByContent
from handsim.errors import InputError
from handsim.joints import N_JOINTS, Finger
from handsim.retargeting._judgement import judge
from handsim.retargeting.person import Person, human_hand
from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.movement_fit import SETTLED, Movement, fit
from handsim.retargeting.solving.reachable import Reachable
from handsim.retargeting.solving.residuals import Residuals, Weights
from handsim.retargeting.solving.self_contact import NearLinks, SelfContact
from handsim.retargeting.solving.starts import first_guess
from handsim.retargeting.solving.targets import Targets, openings_of
from handsim.retargeting.solving.untangle import untangled
from handsim.types import MEDIAN_HAND, Array, HandSize, Index

__all__ = ["Retargeted", "Retargeter", "Weights", "human_hand"]

SETTLING = np.deg2rad(0.5)
"""Change from posture to posture that is always allowed: a hand held still settles [rad]."""


STEPS, ALONE = 7, 40
"""Steps of the fit of a whole movement, and of a posture by itself."""


@dataclass(frozen=True, eq=False)
class Retargeted(ByContent):
    """Postures of the robot hand and how well they match.

    Attributes
    ----------
    joint_names
        Of the robot, (n_joints,).
    positions : (..., n_joints) [rad, m for slides]
    fingers
        The n fingers that both hands have, thumb first.
    tip_error : (..., n) [m]
        Distance of each fingertip from its target; the thumb may stand elsewhere.
    opening_error : (..., n) [m]
        Of the distance from thumb to finger; 0 for the thumb, and where there is none.
    vector_error : (..., n) [m]
        Of the vector from thumb to finger in the palm's frame, which counts less.
    penetration : (...) [m]
        How deep links overlap, by the collision shapes of the file; 0 where they do not.
    matched : (...)
        Whether all openings are within tolerance (`handsim.retargeting._judgement`).
    reason
        Empty where all match; else how many do not, the worst, and of which hand it is the limit.
    actuator_names
        Of the robot's actuators that move these joints, (n_actuators,).
    commands : (..., n_actuators)
        Controls of its position servos that hold the postures; NaN for other actuators.
    """

    joint_names: tuple[str, ...]
    positions: Array
    fingers: tuple[Finger, ...]
    tip_error: Array
    opening_error: Array
    vector_error: Array
    penetration: Array
    matched: npt.NDArray[np.bool_]
    reason: str
    actuator_names: tuple[str, ...]
    commands: Array


class Retargeter:
    """Maps postures of the human hand to one robot hand.

    Parameters
    ----------
    robot
        The robot hand.
    size
        Hand of the person whose postures they are. Its side is that of the robot hand: a recorded
        right hand drives a left robot as its mirror image.
    opening_scale
        Scale of the vectors from thumb to fingers: by default that of the hands, so that the
        robot opens as wide for its size as the person; 1 keeps the width of the objects.
    weights
        What counts how much.

    Attributes
    ----------
    person
        The person's hand beside the robot's.
    finger_scale : (n,)
        Length of the robot's fingers over the person's.
    scale
        The same for all of them together.
    unit
        Mean length of the robot's fingers, to which errors are relative [m].

    Raises
    ------
    InputError
        If the person's hand cannot be built or ``opening_scale`` is not positive.
    """

    def __init__(
        self,
        robot: RobotHand,
        size: HandSize = MEDIAN_HAND,
        opening_scale: float | None = None,
        weights: Weights | None = None,
    ) -> None:
        if opening_scale is not None and not 0 < opening_scale < np.inf:
            raise InputError(f"opening scale {opening_scale:g}; give a positive number, 1 = as is")
        self.robot = robot
        self.weights = weights or Weights()
        self.person = Person(robot, size, opening_scale, self.weights.near)
        self.finger_scale, self.scale = self.person.finger_scale, self.person.scale
        self.unit = float(robot.reach.mean())
        self._contact = SelfContact(robot)
        self._reachable = Reachable(robot, self.unit)
        if not robot.pads_are_known:  # the backs of fingertips may point anywhere
            self.weights = replace(self.weights, back=0.0)

    def retarget(
        self,
        q: Array,
        max_gain: float = 3.0,
        max_step: float = np.inf,
        time: Array | None = None,
    ) -> Retargeted:
        """Map a posture (22,) or a movement of them (n, 22) [rad], glove order.

        All postures of a movement are fitted together, each bound to its neighbours.

        Parameters
        ----------
        q
            They may leave the human ranges, as gloves do.
        max_gain
            No coordinate changes from one posture to the next by more than this times the largest
            change of a human joint, plus `SETTLING`: near singular postures small movements of
            fingertips would ask for large ones of joints. Slides count in lengths of a finger.
        max_step
            Nor by more than this [rad, m for slides].
        time : (n,) [s]
            When the postures are. Given, no coordinate goes faster than the robot's file says.

        Returns
        -------
        Retargeted
            Postures that do not match are results too; ``matched`` and ``reason`` tell.

        Raises
        ------
        InputError
            If ``q`` has another shape or is not finite, a limit is not positive, or times do not
            increase.
        """
        postures = _checked(q, max_gain, max_step)
        sequence = np.atleast_2d(postures)
        steps = self._largest_steps(sequence, max_gain, max_step, time)
        goal = self.targets_of(sequence)
        x, depth = self._fitted(goal, steps)
        return self._result(x, depth, goal, postures.shape[:-1])

    def follow(self, q: Array, before: Array, max_step: float = np.inf, steps: int = 6) -> Array:
        """Return the coordinates of one posture (22,) that follow those before it, (m,).

        For control loops: a few steps of the fit from where the robot is, collisions included.

        Parameters
        ----------
        q
        before : (m,)
            Coordinates of the posture before.
        max_step
            Largest change [rad, m for slides].
        steps
            Of the fit.
        """
        robot = self.robot
        targets = self.targets_of(np.atleast_2d(_checked(q, 1.0, max_step)))
        residuals = Residuals(robot, targets, self.weights, self.unit)
        start = np.clip(before, robot.lower, robot.upper)[None]
        near = self._near_links(start, np.full(1, self.weights.contact))
        lower = np.maximum(robot.lower, start[0] - max_step)
        upper = np.minimum(robot.upper, start[0] + max_step)
        return fit(lambda x: residuals.at(x, near), start, lower, upper, None, steps)[0][0]

    def targets(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Return what the robot is to match for a posture (22,) [rad], palm frame.

        Returns
        -------
        points : (n, 3)
            Fingertips [m].
        openings : (n, 3)
            Vectors from the thumb to them [m]; 0 without a thumb.
        directions : (n, 3)
            Unit vectors out of the fingers.
        weights : (n,)
            Of the openings; 0 for the thumb.
        """
        goal = self.targets_of(np.atleast_2d(q))
        weights = self.weights
        counts = weights.opening + goal.nearness * (weights.pinch - weights.opening)
        return goal.points[0], goal.openings[0], goal.directions[0], (goal.counted * counts)[0]

    def targets_of(self, q: Array) -> Targets:
        """Return what the robot is to match for postures (n, 22) [rad]."""
        return self.person.targets(q)

    def _largest_steps(
        self, q: Array, max_gain: float, max_step: float, time: Array | None
    ) -> Array:
        """Return the largest change of each coordinate from posture to posture, (n - 1, m)."""
        changes = np.abs(np.diff(q, axis=0)).max(axis=1) + 1e-12  # times inf is inf
        turn_or_slide = np.where(self.robot.slides, self.unit, 1.0)
        steps = np.minimum((max_gain * changes + SETTLING)[:, None] * turn_or_slide, max_step)
        if time is None:
            return steps
        passed = np.diff(np.asarray(time, dtype=float))
        if passed.shape != changes.shape or not (passed > 0).all():
            raise InputError(
                f"{len(q)} postures and times that do not increase; give one time each"
            )
        return np.minimum(steps, passed[:, None] * self.robot.speed)

    def _fitted(self, targets: Targets, steps: Array) -> tuple[Array, Array]:
        """Return coordinates (n, m) and how deep links overlap, (n,) [m]."""
        robot, weights = self.robot, self.weights

        def residuals_of(chosen: slice | Index) -> Residuals:
            return Residuals(robot, targets[chosen], weights, self.unit)

        residuals = residuals_of(slice(None))
        x = first_guess(residuals_of, len(targets.points), robot, self._contact)
        near = self._near_links(x, np.full(len(x), weights.contact))
        movement = Movement(weights.previous, weights.speed, steps)
        most, settled = (STEPS, SETTLED) if len(x) > 1 else (ALONE, 1e-5)
        # First as if all changes were allowed: limits that bind from the start can hold a movement
        # in a worse solution for good.
        for bound in (movement.unlimited(), movement):
            x, _ = fit(
                lambda at: residuals.at(at, near),
                x, robot.lower, robot.upper, bound, most, settled,
            )  # fmt: skip
            if movement.allows(x):
                break
        return untangled(residuals_of, robot, self._contact, movement, x)

    def _near_links(self, x: Array, weight: Array) -> NearLinks:
        return self._contact.near_links(self._contact.find(x), x, weight)

    def _result(self, x: Array, depth: Array, goal: Targets, lead: tuple[int, ...]) -> Retargeted:
        """Judge what was found, and give it the shape of what was asked for."""
        robot = self.robot
        (points, _, _), _ = robot.poses_in(robot.link_frames(x))
        apart = openings_of(points, robot.fingers)
        tip = np.linalg.norm(points - goal.points, axis=2)
        wanted, reached = (np.linalg.norm(o, axis=2) for o in (goal.openings, apart))
        matched, reason = judge(
            wanted, reached, tip, self.unit, robot.fingers, lambda: self._reachable.openings
        )
        return Retargeted(
            robot.joint_names,
            robot.joint_positions(x).reshape(*lead, -1),
            robot.fingers,
            tip.reshape(*lead, -1),
            np.abs(reached - wanted).reshape(*lead, -1),
            np.linalg.norm(apart - goal.openings, axis=2).reshape(*lead, -1),
            depth.reshape(lead),
            matched.reshape(lead),
            reason,
            robot.actuator_names,
            robot.commands(x).reshape(*lead, -1),
        )


def _checked(q: Array, max_gain: float, max_step: float) -> Array:
    """Return postures as an array; refuse what is none, and limits that allow nothing."""
    postures = np.asarray(q, dtype=float)
    if postures.shape[-1:] != (N_JOINTS,) or postures.ndim > 2 or not len(postures):
        raise InputError(f"postures of shape {postures.shape}; give (22,) or (n, 22)")
    if not np.isfinite(postures).all():
        raise InputError("postures hold values that are not finite; give angles in radians")
    if not (max_gain > 0 and max_step > 0):
        raise InputError(f"gain {max_gain:g} and step {max_step:g}; give positive limits")
    return postures

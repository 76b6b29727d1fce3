"""The movement of a person's hand through a grasp, and what a robot hand is told to make of it.

The controller runs as it does for a person: in its few components, from reading to reading, the
robot being taken to be where it was told to be. All its postures are mapped as one movement, so
that the robot's is smooth. What the fingers add after the reach, the squeeze and the flexion of
single fingers, is mapped as a direction in the robot's own coordinates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.grasping.plan import ramp
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.drivers import Driver, LearnedDriver
from handsim.grasping.rollout.glove import RATE
from handsim.joints import Finger, clip_to_range
from handsim.recordings.phases import low_pass
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.types import Array, Index

WIDER = 0.5
"""How much wider a robot opens until its palm is in place, in units of the squeeze."""
CLOSING_STEPS = 4
"""Postures on the way of the squeeze that are mapped."""


@dataclass(frozen=True)
class RobotMovement:
    """What a robot is told in a run.

    Attributes
    ----------
    postures : (n, 22) [rad]
        What a person's hand would be told at each reading, without squeeze and flexion.
    told : (n, m)
        Coordinates of the robot at each reading [rad or m].
    closing : (m,)
        What its coordinates change by as the hand squeezes.
    flexion : (n, m)
        What the action adds to single fingers.
    shift : (n, 3) [m]
        By how much its palm is moved, in its own axes, so that the middle between its thumb and
        its fingers goes where the person's does.
    mapped : (k, m)
        Coordinates of all postures that were mapped, of which ``told`` and the rest are made.
    """

    postures: Array
    told: Array
    closing: Array
    flexion: Array
    shift: Array
    mapped: Array


def told_postures(driver: Driver, commands: Commands) -> Array:
    """Return the postures that a perfect hand is told, (n, 22) [rad].

    Parameters
    ----------
    driver
        Without any lead: a robot's servos have their own.
    commands
        Of one run.
    """
    n_reach = int(np.searchsorted(commands.times, driver.reach, side="right"))
    reference = driver.start(1)
    postures: list[Array] = []
    for time in commands.times[:n_reach]:
        reading = _perfect(driver, reference, postures)
        told, reference = driver.step(float(time), 1.0 / RATE, reference, reading)
        postures.append(np.reshape(told, -1))
    closed = commands.closed[n_reach:, None]
    rest = postures[-1] + closed * (driver.destination - postures[-1])
    return np.vstack([*postures, rest])


def _perfect(driver: Driver, reference: Array, told: list[Array]) -> Array:
    """Return the reading of a hand that is where it was told to be, (1, 22) [rad]."""
    if isinstance(driver, LearnedDriver):
        return driver.controller.subspace.inverse_transform(reference)
    return told[-1][None] if told else driver.destination[None]


def robot_movement(
    retargeter: Retargeter,
    driver: Driver,
    commands: Commands,
    arrival: float,
    fingers: Sequence[Finger],
    mapped: Array | None = None,
) -> RobotMovement:
    """Map all postures of a run to a robot.

    Parameters
    ----------
    retargeter
    driver, commands
        As `told_postures` takes them.
    arrival
        When the palm is in place [s]. Until then the robot opens wider than the person by
        `WIDER`, since its fingertips are thicker.
    fingers
        Those of the robot that grasp, beside the thumb.
    mapped : (k, m)
        What the same postures were mapped to before, if they were. Where links evade each other,
        the last bits in which processors differ grow to tens of degrees: a plan that was tried
        with one movement need not hold with the other. Of another shape, it is not looked at.

    Raises
    ------
    InputError
        If the robot has no fingers that could oppose each other.
    """
    robot = retargeter.robot
    check_opposing(robot)
    postures = told_postures(driver, commands)
    different = np.append(True, (np.diff(postures, axis=0) != 0).any(axis=1))
    row: Index = np.cumsum(different) - 1
    way, last = postures[different], postures[-1]
    closings = last + np.linspace(0.0, 1.0, CLOSING_STEPS + 1)[1:, None] * commands.closing
    flexed, which = np.unique(commands.flexion, axis=0, return_inverse=True)
    beyond = clip_to_range(np.vstack([closings, last + flexed]))
    x = mapped
    if x is None or x.shape != (len(way) + len(beyond), len(robot.lower)):
        x = retargeter.retarget(np.vstack([way, beyond])).positions[:, robot.joint_map.free]
    end = x[len(way) - 1]
    closed = x[len(way) + CLOSING_STEPS - 1]
    bent = x[len(way) + CLOSING_STEPS :] - end
    bent[~flexed.any(axis=1)] = 0.0
    squeezed = commands.schedule.squeeze_start + commands.schedule.squeeze
    wider = WIDER * (1.0 - ramp(commands.times, arrival, squeezed - arrival))
    smooth = low_pass(x[row], RATE)
    told = np.clip(smooth - wider[:, None] * (closed - end), robot.lower, robot.upper)
    mine = middle_between(robot, told, fingers)
    theirs = middle_between(retargeter.person.hand, postures[:, retargeter.person.glove], fingers)
    shift = (theirs - theirs[-1]) - (mine - mine[-1])
    return RobotMovement(
        postures,
        told,
        closed - end,
        bent[which.reshape(-1)],
        shift,
        x,
    )


def middle_between(hand: RobotHand, x: Array, fingers: Sequence[Finger]) -> Array:
    """Return the points midway between the thumb and some fingers, (n, 3) [m], palm's frame."""
    (points, _, _), _ = hand.poses_in(hand.link_frames(x))
    others = points[:, [hand.fingers.index(finger) for finger in fingers]].mean(axis=1)
    return 0.5 * (points[:, hand.fingers.index("thumb")] + others)


def check_opposing(robot: RobotHand) -> None:
    """Check that a robot has a thumb and a finger, which can oppose each other.

    Raises
    ------
    InputError
        If it has not.
    """
    if "thumb" not in robot.fingers or len(robot.fingers) < 2:
        raise InputError(
            f"the hand has only {', '.join(robot.fingers)}; a grasp needs a thumb and a finger"
        )

"""Map postures of the human hand to a robot hand of other proportions or joints.

The paper leaves this for later (its Sec. VII); here it is done by matching fingertips. For each
posture the robot's joints x minimise

    sum_i  w_t^2 |p_i - p_i*|^2  +  sum_i w_o(d_i)^2 |(p_i - p_thumb) - s (h_i - h_thumb)|^2
    + sum_i w_d^2 L^2 |a_i - a_i*|^2  + (small) distance to the last posture and to mid-range

within their ranges, in the frame of the palm. h_i are the pads of the human fingers, p_i the
points that the user named on the robot, a_i the directions out of the fingers, d_i the human
distance from thumb to finger, L the mean length of the robot's fingers. The targets are

    p_i* = robot's root_i + s_i (h_i - human root_i),   s_i = length of robot's / human finger i,

so that each finger moves about where it is rooted, however broad the palm is. The thumb-finger
vectors are scaled by one s for the whole hand and count the more the closer they are: grasps live
there, and what touches in the human hand must touch in the robot's.

What it needs of the user: an MJCF (or URDF), the names of palm and fingertips (`RobotHand`; frames
with an offset do where the file has no sites), and which finger stands for which, which is the keys
of ``fingertips``: a three-finger hand may take thumb, index and middle, or thumb, index and little.
Hinges and slides, joints that follow others by ``<equality><joint>`` or that one actuator moves
together by a fixed tendon, and any arm around the hand are understood; ball joints, closed loops
and equalities of tendons are refused. The wrist's two angles are not mapped: they belong to
whatever carries the robot's palm. Collisions of the robot with itself are not looked at.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handsim.content import ByContent
from handsim.errors import InputError
from handsim.hand.mjcf import build_hand
from handsim.joints import FINGERS, JOINT_INDEX, N_JOINTS, Finger
from handsim.retargeting._posture_fit import PostureFit, judge_fit, openings_of
from handsim.retargeting.robot_hand import AttachedFrame, RobotHand
from handsim.types import MEDIAN_HAND, Array, HandSize

SETTLING = np.deg2rad(0.5)
"""Change from posture to posture that is always allowed: a hand held still settles [rad]."""


@dataclass(frozen=True)
class Weights:
    """What counts how much; errors are relative to the mean length of the robot's fingers.

    Attributes
    ----------
    tip
        Fingertips at their targets.
    opening, pinch
        Vectors from thumb to fingers, far apart and touching.
    near
        Human distance over which ``pinch`` fades into ``opening``, / human finger's mean length.
    direction
        Directions out of the fingers.
    previous
        Distance to the posture before [rad].
    middle
        Distance to mid-range, / half of the range; decides only where nothing else does.
    """

    tip: float = 1.0
    opening: float = 1.0
    pinch: float = 5.0
    near: float = 0.5
    direction: float = 0.15
    previous: float = 0.05
    middle: float = 0.0005


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
        Distance of each fingertip from its target.
    opening_error : (..., n) [m]
        Of the vector from thumb to finger; 0 for the thumb, and where there is none.
    matched : (...)
        Whether all errors are within `TIP_TOLERANCE` and `OPENING_TOLERANCE`.
    reason
        Empty where all match; else how many do not, and the worst fingertip.
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
        self.human = human_hand(size)
        self.weights = weights or Weights()
        self._glove = [JOINT_INDEX[name] for name in self.human.joint_names]
        self._chosen = [FINGERS.index(finger) for finger in robot.fingers]
        human_reach = self.human.reach[self._chosen]
        self.finger_scale: Array = robot.reach / human_reach
        self.scale = float(robot.reach.sum() / human_reach.sum())
        self.opening_scale = self.scale if opening_scale is None else opening_scale
        self.unit = float(robot.reach.mean())
        self._near = self.weights.near * float(human_reach.mean())

    def retarget(self, q: Array, max_gain: float = 3.0, max_step: float = np.inf) -> Retargeted:
        """Map a posture (22,) or a sequence of them (n, 22) [rad], glove order.

        Each posture of a sequence starts from the one before and is drawn to it.

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

        Returns
        -------
        Retargeted
            Postures that do not match are results too; ``matched`` and ``reason`` tell.

        Raises
        ------
        InputError
            If ``q`` has another shape or is not finite, or a limit is not positive.
        """
        postures = np.asarray(q, dtype=float)
        if postures.shape[-1:] != (N_JOINTS,) or postures.ndim > 2 or not len(postures):
            raise InputError(f"postures of shape {postures.shape}; give (22,) or (n, 22)")
        if not np.isfinite(postures).all():
            raise InputError("postures hold values that are not finite; give angles in radians")
        if not (max_gain > 0 and max_step > 0):
            raise InputError(f"gain {max_gain:g} and step {max_step:g}; give positive limits")
        sequence = np.atleast_2d(postures)
        changes = np.abs(np.diff(sequence, axis=0)).max(axis=1) + 1e-12  # times inf is inf
        turn_or_slide = np.where(self.robot.slides, self.unit, 1.0)
        path, errors = np.empty((len(sequence), len(self.robot.lower))), []
        for i, posture in enumerate(sequence):
            fit = PostureFit(self, posture)
            if i == 0:
                path[i] = fit.first()
            else:
                step = (max_gain * changes[i - 1] + SETTLING) * turn_or_slide
                path[i] = fit.after(path[i - 1], np.minimum(step, max_step))
            errors.append(fit.errors(path[i]))
        tip, opening, excess = np.transpose(errors, (1, 0, 2))
        lead = postures.shape[:-1]
        matched, reason = judge_fit(tip, opening, excess, self.robot.fingers)
        return Retargeted(
            self.robot.joint_names,
            self.robot.joint_positions(path).reshape(*lead, -1),
            self.robot.fingers,
            tip.reshape(*lead, -1),
            opening.reshape(*lead, -1),
            matched.reshape(lead),
            reason,
            self.robot.actuator_names,
            self.robot.commands(path).reshape(*lead, -1),
        )

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
        pads = self.human.forward(q[self._glove])
        points, directions = pads.points[self._chosen], pads.directions[self._chosen]
        scale = self.finger_scale[:, None]
        moved = self.robot.roots + scale * (points - self.human.roots[self._chosen])
        openings = openings_of(points, self.robot.fingers)
        closeness = np.exp(-np.sum((openings / self._near) ** 2, axis=1))
        weights = self.weights.opening + closeness * (self.weights.pinch - self.weights.opening)
        weights[[finger == "thumb" for finger in self.robot.fingers]] = 0.0
        if "thumb" not in self.robot.fingers:
            weights[:] = 0.0
        return moved, self.opening_scale * openings, directions, weights


def human_hand(size: HandSize = MEDIAN_HAND) -> RobotHand:
    """Return the human hand in the terms of a robot hand, its pads as fingertips.

    Parameters
    ----------
    size
        As in `handsim.hand.mjcf.build_hand`.
    """
    pads: dict[Finger, AttachedFrame | str] = {finger: f"{finger}_pad" for finger in FINGERS}
    return RobotHand(build_hand(size), "palm", pads)

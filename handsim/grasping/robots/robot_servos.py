"""How stiff the servos of a robot hand are, and how far they lag behind what they are told.

Position servos give way in proportion to what their joints carry: a glass of 0.25 kg bends fingers
of 1 N m/rad by a quarter of a radian. What moves lags by the ratio of damping to stiffness: fingers
that close with 1 rad/s are a tenth of a radian late where that ratio is 0.1 s.
"""

from dataclasses import dataclass

import numpy as np

from handsim.joints import FINGERS
from handsim.retargeting.robot_hand import RobotHand
from handsim.types import Array, Mask

SOFTEST = 0.1
"""Least force that is reckoned with [N]."""
_SMALL = 1e-4  # step of differences [rad or m]
_SOFT = (
    1e-3  # least stiffness relative to the greatest: coordinates without a servo give way freely
)


@dataclass(frozen=True)
class RobotServos:
    """Servos of a robot in one posture.

    Attributes
    ----------
    stiffness : (m, m) [N m/rad]
        Of the coordinates.
    jacobian : (5, 3, m) [m/rad]
        How fingertips move in the palm's frame; 0 for fingers that the robot has not.
    lead : (m,) [s]
        Ratio of damping to stiffness: a target that leads a moving joint by velocity times lead
        keeps it at that velocity. 0 where no servo moves the coordinate.
    driven : (m,)
        Whether a servo does.
    """

    stiffness: Array
    jacobian: Array
    lead: Array
    driven: Mask

    @property
    def lag(self) -> float:
        """Time constant with which the fingers follow, [s]."""
        return float(np.median(self.lead[self.driven])) if self.driven.any() else 0.0

    @classmethod
    def at(cls, robot: RobotHand, x: Array) -> "RobotServos":
        """Return the servos at coordinates x, (m,)."""
        middle = 0.5 * (robot.lower + robot.upper)  # away from the ends of the actuators' ranges
        moved = robot.commands(middle + _SMALL * np.eye(len(x))) - robot.commands(middle)
        slopes = np.nan_to_num(moved.T / _SMALL)
        gains = robot.model.actuator_gainprm[robot.actuator_ids, 0]
        stiffness = slopes.T @ (gains[:, None] * slopes)
        least = _SOFT * np.diag(stiffness).max()
        driven = np.diag(stiffness) >= least
        stiffness[np.diag_indices_from(stiffness)] += np.where(driven, 0.0, least)
        jacobian = np.zeros((len(FINGERS), 3, len(x)))
        for finger, rates in zip(robot.fingers, robot.forward(x).d_points, strict=True):
            jacobian[FINGERS.index(finger)] = rates
        ids = robot.joint_ids[robot.joint_map.free]
        resisting = robot.model.dof_damping[robot.model.jnt_dofadr[ids]]
        speeds = -robot.model.actuator_biasprm[robot.actuator_ids, 2]
        damping = resisting + np.diag(slopes.T @ (speeds[:, None] * slopes))
        lead = np.where(driven, damping / np.diag(stiffness), 0.0)
        return cls(stiffness, jacobian, lead, np.asarray(driven))

    def force_of(self, closing: Array) -> float:
        """Return the force of a fingertip for a movement of the targets [N]; the thumb's if any.

        Parameters
        ----------
        closing : (m,)
        """
        for rates in self.jacobian:  # the thumb first
            own = np.where(np.abs(rates).max(axis=0) > 0, closing, 0.0)
            moved = float(np.linalg.norm(rates @ own))
            if moved > 0:  # the work of the force is that of the servos
                return max(float(own @ self.stiffness @ own) / moved, SOFTEST)
        return SOFTEST

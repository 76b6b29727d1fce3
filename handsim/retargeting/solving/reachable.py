"""How far and how close a robot hand's fingertips come to its thumb's."""

from functools import cached_property

import numpy as np

from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.movement_fit import fit
from handsim.retargeting.solving.residuals import Residuals, Weights
from handsim.retargeting.solving.targets import Targets
from handsim.types import Array

_STARTS = 24
_STEPS = 25
_FAR = 4.0
"""An opening that no hand reaches, / length of a finger."""
_ALONE = Weights(
    opening=1.0, pinch=1.0, vector=0.0, tip=0.0, thumb=0.0, direction=0.0, back=0.0, middle=1e-5
)


class Reachable:
    """Least and greatest openings of a robot hand, each finger by itself.

    Parameters
    ----------
    robot
    unit
        Mean length of its fingers [m].
    """

    def __init__(self, robot: RobotHand, unit: float) -> None:
        self._robot, self._unit = robot, unit

    @cached_property
    def openings(self) -> tuple[Array, Array]:
        """Least and greatest distance of each fingertip from the thumb's, (k,) each [m]."""
        robot = self._robot
        fingers = len(robot.fingers)
        if "thumb" not in robot.fingers:
            return np.zeros(fingers), np.full(fingers, np.inf)
        rng = np.random.default_rng(3)
        drawn = rng.random((_STARTS, len(robot.lower)))
        starts = robot.lower + drawn * (robot.upper - robot.lower)
        ends: list[Array] = []
        for far in (0.0, _FAR * self._unit):
            found = np.zeros((_STARTS, fingers))
            for i in range(fingers):
                targets = self._only(i, far)
                x, _ = fit(
                    Residuals(robot, targets, _ALONE, self._unit).at,
                    starts, robot.lower, robot.upper, None, _STEPS,
                )  # fmt: skip
                points = robot.forward(x).points
                found[:, i] = np.linalg.norm(points[:, i] - points[:, 0], axis=1)
            ends.append(found.min(axis=0) if far == 0 else found.max(axis=0))
        return ends[0], ends[1]

    def _only(self, finger: int, far: float) -> Targets:
        """Return targets that ask for an opening of one finger; the others are let be."""
        shape = (_STARTS, len(self._robot.fingers), 3)
        points = np.zeros(shape)
        openings = np.zeros(shape)
        openings[:, finger, 0] = far
        counted = np.zeros(shape[:2])
        counted[:, finger] = 1.0
        return Targets(points, openings, openings, points, points, np.zeros(shape[:2]), counted)

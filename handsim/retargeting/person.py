"""The person whose movements a robot hand is to make, and what the robot is to match."""

from dataclasses import replace

import numpy as np

from handsim.hand.mjcf import build_hand
from handsim.joints import FINGERS, JOINT_INDEX, Finger
from handsim.retargeting.robot_hand import AttachedFrame, RobotHand
from handsim.retargeting.solving.targets import Targets, openings_of, turned_openings
from handsim.types import MEDIAN_HAND, Array, HandSize

SPREAD = 0.25
"""How far openings are turned by fingers rooted further apart than the person's: 0 to 1."""


def human_hand(size: HandSize = MEDIAN_HAND) -> RobotHand:
    """Return the human hand in the terms of a robot hand, its pads as fingertips.

    Parameters
    ----------
    size
        As in `handsim.hand.mjcf.build_hand`.
    """
    pads: dict[Finger, AttachedFrame | str] = {finger: f"{finger}_pad" for finger in FINGERS}
    return RobotHand(build_hand(size), "palm", pads)


class Person:
    """A person's hand beside a robot's.

    Parameters
    ----------
    robot
    size
        Its side is turned to that of the robot, where the robot's file says which that is.
    opening_scale
        As `handsim.Retargeter` takes it.
    near
        Distance over which openings count less and less, / mean length of the person's fingers.

    Attributes
    ----------
    size
        Of the person's hand, with its side.
    hand
        The person's hand in the terms of a robot hand.
    glove
        Places of its joints in the glove's order.
    finger_scale : (k,)
        Length of the robot's fingers over the person's.
    scale
        The same for all of them together.
    """

    def __init__(
        self, robot: RobotHand, size: HandSize, opening_scale: float | None, near: float
    ) -> None:
        if robot.frames.origin != "given":
            size = replace(size, side=robot.side)
        self._robot, self.size = robot, size
        self.hand = human_hand(size)
        self.glove = [JOINT_INDEX[name] for name in self.hand.joint_names]
        self._chosen = [FINGERS.index(finger) for finger in robot.fingers]
        reach = self.hand.reach[self._chosen]
        self.finger_scale: Array = robot.reach / reach
        self.scale = float(robot.reach.sum() / reach.sum())
        self.opening_scale = self.scale if opening_scale is None else opening_scale
        self._near = near * float(reach.mean())
        self._spread = self._wider_spread()

    def targets(self, q: Array) -> Targets:
        """Return what the robot is to match for postures (n, 22) [rad]."""
        robot, hand = self._robot, self.hand
        poses, _ = hand.poses_in(hand.link_frames(q[:, self.glove]))
        points, directions, backs = (pose[:, self._chosen] for pose in poses)
        from_root = points - hand.roots[self._chosen]
        openings = openings_of(points, robot.fingers)
        nearness = np.exp(-np.sum((openings / self._near) ** 2, axis=2))
        with_thumb = "thumb" in robot.fingers
        other = np.array([f != "thumb" and with_thumb for f in robot.fingers], dtype=float)
        return Targets(
            robot.roots + self.finger_scale[:, None] * from_root,
            self.opening_scale * openings,
            turned_openings(self.opening_scale * openings, self._spread),
            directions,
            backs,
            nearness * other,
            np.broadcast_to(other, nearness.shape),
        )

    def _wider_spread(self) -> Array:
        """Return how much further from their middle the robot's fingers are rooted, (k, 3) [m].

        Across the palm alone: a robot's fingers are often broader, and would run into each other
        were they as near each other as a person's.
        """
        others = [i for i, finger in enumerate(self._robot.fingers) if finger != "thumb"]
        spread = np.zeros((len(self._robot.fingers), 3))
        if others:
            robot = self._robot.roots[others, 1]
            person = self.scale * self.hand.roots[self._chosen][others, 1]
            spread[others, 1] = SPREAD * ((robot - robot.mean()) - (person - person.mean()))
        return spread

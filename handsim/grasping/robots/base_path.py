"""Where a robot's base is told to be at each step between readings.

A base that jumped with each reading, by some millimetres in a reach, would shake what the hand
holds a hundred times a second.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from handsim.grasping.rollout.commands import Commands
from handsim.physics import TIMESTEP
from handsim.types import Array


@dataclass(frozen=True)
class BasePath:
    """Even movements from reading to reading; after the last one the base stays.

    Attributes
    ----------
    pos, quat : (n, steps, 3) [m], (n, steps, 4)
        For the end of each step, of n readings.
    velocity : (n, steps, 6) [m/s, rad/s]
        Of each step, along and about the axes that the base then has.
    """

    pos: Array
    quat: Array
    velocity: Array

    @classmethod
    def of(cls, commands: Commands, steps: int) -> "BasePath":
        """Return the path of commands, with so many steps of the simulation between readings."""
        n = len(commands.times)
        at = np.minimum(np.arange(n * steps + 1) / steps, n - 1)
        turns = Slerp(np.arange(n), Rotation.from_quat(commands.palm_quat, scalar_first=True))(at)
        rows, then = np.arange(n), turns[1:]
        pos = np.stack([np.interp(at, rows, column) for column in commands.palm_pos.T], axis=1)
        moving = then.inv().apply(np.diff(pos, axis=0)) / TIMESTEP
        turning = (turns[:-1].inv() * then).as_rotvec() / TIMESTEP
        return cls(
            pos[1:].reshape(n, steps, 3),
            then.as_quat(scalar_first=True).reshape(n, steps, 4),
            np.hstack([moving, turning]).reshape(n, steps, 6),
        )

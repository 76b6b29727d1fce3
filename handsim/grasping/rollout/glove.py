"""The virtual data glove: readings of the simulated joints as a sensor glove would give them."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from handsim.grasping.rollout.record import Rollout
from handsim.recordings.recording import SYNTHETIC, Recording
from handsim.tasks.task import Task
from handsim.types import Array, Mask

RATE = 100.0
"""Rate of the readings, that of the paper's glove (Sec. VI-A) [Hz]."""


def steps_per_reading(model: mujoco.MjModel) -> int:
    """Return how many steps MuJoCo makes between two readings of the glove."""
    return round(1.0 / (RATE * model.opt.timestep))


class Measured(NamedTuple):
    """What gloves and fingertips of n runs measure at one time; most readings are never asked for.

    Attributes
    ----------
    q, noise : (n, 22) [rad]
        Posture, and what the glove adds to it.
    wrist : (n, 2) [rad]
        What is said of the wrist's joints instead, where the arm moves them and not the driver,
        who is not to answer it; otherwise None.
    forces : (n, 5) [N]
        Normal forces of the fingers.
    """

    q: Array
    noise: Array
    wrist: Array | None
    forces: list[list[float]]

    def without(self, lost: Mask, before: "Measured") -> "Measured":
        """Return this with the posture of the time before in runs (n,) whose reading is lost."""
        where = lost[:, None]
        wrist = self.wrist
        if wrist is not None and before.wrist is not None:
            wrist = np.where(where, before.wrist, wrist)
        q, noise = np.where(where, before.q, self.q), np.where(where, before.noise, self.noise)
        return Measured(q, noise, wrist, self.forces)


@dataclass(frozen=True)
class DataGlove:
    """Noise and resolution of the 22 sensors.

    Attributes
    ----------
    resolution
        Step between two readings, 1 deg in the paper's Sec. VI-A [rad].
    noise
        Standard deviation added before rounding [rad]; a quarter of a degree makes readings
        flicker between neighbouring steps as those of real gloves do.
    """

    resolution: float = float(np.deg2rad(1.0))
    noise: float = float(np.deg2rad(0.25))

    def read(self, q: Array, generator: np.random.Generator) -> Array:
        """Return the reading of joint angles ``q`` (..., 22) [rad]."""
        return self.reading(q, self.disturbance(q.shape, generator))

    def disturbance(self, shape: tuple[int, ...], generator: np.random.Generator) -> Array:
        """Return noise for readings (..., 22) of a shape [rad]."""
        return self.noise * generator.standard_normal(shape)

    def reading(self, q: Array, disturbance: Array) -> Array:
        """Return the reading of joint angles (..., 22) [rad] with noise that is given [rad]."""
        return np.rint((q + disturbance) / self.resolution) * self.resolution


def recorded_reach(rollout: Rollout, task: Task) -> Recording:
    """Return the glove's readings during the reach, from rest to touch, as a recording."""
    reaching = rollout.time <= rollout.phases[1].start + 1e-9
    return Recording(
        name=task.name,
        time=rollout.time[reaching],
        q=rollout.reading[reaching],
        number=task.number,
        subject=SYNTHETIC,
        object=task.object_name,
        task=task.name,
        hand=rollout.conditions.hand,
    )

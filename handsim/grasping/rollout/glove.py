"""The virtual data glove: readings of the simulated joints as a sensor glove would give them."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.record import Rollout
from handsim.recordings.recording import SYNTHETIC, Recording
from handsim.tasks.task import Task
from handsim.types import Array, Index, Mask

RATE = 100.0
"""Rate of the readings, that of the paper's glove (Sec. VI-A) [Hz]."""


def steps_per_reading(model: mujoco.MjModel) -> int:
    """Return how many steps MuJoCo makes between two readings of the glove."""
    return round(1.0 / (RATE * model.opt.timestep))


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


class _Felt(NamedTuple):
    """What is kept of a reading: its number, what had been told by then, and forces."""

    tick: int
    told: Array | None
    forces: list[list[float]]


class LateGloves:
    """What gloves and fingertips of n runs measure: some readings later, and not if it gets lost.

    Most postures are never asked for, so that they are looked up when they are. What is returned is
    kept until the next reading, and is not to be changed.

    Parameters
    ----------
    glove
    disturbance, lost : (n_readings, n, 22) [rad], (n_readings, n)
        What the glove adds to postures, and which readings do not come: the one before is taken.
        Forces come in any case; they are not the glove's.
    delay
        Age of what comes, in readings.
    qpos : (n, nq)
        MuJoCo's positions, a live view.
    past : (n_readings, n, nq)
        Positions at the readings before.
    joints : (22,)
        Where the joints are among positions.
    """

    def __init__(
        self,
        glove: DataGlove,
        disturbance: Array,
        lost: Mask,
        delay: int,
        qpos: Array,
        past: Array,
        joints: Index,
    ) -> None:
        self._glove, self._disturbance = glove, disturbance
        self._qpos, self._past, self._joints = qpos, past, joints
        self._felt: deque[_Felt] = deque(maxlen=delay + 1)
        self._tolds: list[Array | None] = []
        self._read: Array | None = None
        self._read_by_driver: Array | None = None
        self._any_lost: list[bool] = lost.any(axis=1).tolist()
        came = np.where(lost, 0, np.arange(len(lost))[:, None])
        self._source = np.maximum.accumulate(came, axis=0)

    def measure(self, tick: int, told: Array | None, forces: list[list[float]]) -> None:
        """Measure at a reading.

        Parameters
        ----------
        tick
            Its number.
        told : (n, 22) [rad]
            What the driver told last, where an arm moves the wrist and not the driver, who is not
            to answer it: he reads of the wrist what he told. None where he moves it himself, and
            before he has told something.
        forces : (n, 5) [N]
            Normal forces of the fingers.
        """
        self._tolds.append(told)
        self._felt.append(_Felt(tick, told, forces))
        self._read = self._read_by_driver = None

    @property
    def forces(self) -> list[list[float]]:
        """Normal forces of the fingers that come now, (n, 5) [N]."""
        return self._felt[0].forces

    def read(self) -> Array:
        """Return the readings that come now, (n, 22) [rad], the wrist's as they are."""
        if self._read is not None:
            return self._read
        felt = self._felt[0]
        now = self._qpos if felt is self._felt[-1] else self._past[felt.tick]
        q, noise = now.take(self._joints, axis=1), self._disturbance[felt.tick]
        if self._any_lost[felt.tick]:
            noise = noise.copy()
            for i, row in self._before(felt.tick):
                q[i], noise[i] = self._past[row, i, self._joints], self._disturbance[row, i]
        self._read = self._glove.reading(q, noise)
        return self._read

    def read_by_driver(self) -> Array:
        """Return them with what was told of the wrist, (n, 22) [rad]."""
        if self._read_by_driver is None:
            self._read_by_driver = self._with_told_wrist(self.read())
        return self._read_by_driver

    def _with_told_wrist(self, read: Array) -> Array:
        felt = self._felt[0]
        if felt.told is None:
            return read
        reading = read.copy()
        reading[:, WRIST_COLUMNS] = felt.told[:, WRIST_COLUMNS]
        if self._any_lost[felt.tick]:
            for i, row in self._before(felt.tick):
                told = self._tolds[row]
                by = read if told is None else told
                reading[i, WRIST_COLUMNS] = by[i, WRIST_COLUMNS]
        return reading

    def _before(self, tick: int) -> Iterator[tuple[int, int]]:
        """Yield runs whose reading is lost, and the number of the one that is taken instead."""
        for i, row in enumerate(self._source[tick].tolist()):
            if row < tick:
                yield i, row


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

"""MuJoCo simulations that go from one reading of the glove to the next: one alone, or a batch.

Both have the same arrays, with a row for each simulation, and both give the same bits.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Literal

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import steps_per_reading
from handsim.grasping.rollout.sensing import NO_SENSORS, SLOTS, Sensors, Touch, contacts_of
from handsim.types import Array, Index, Mask

Device = Literal["cpu", "warp"]
"""What steps runs: MuJoCo on the processor, or mujoco_warp, on a GPU where there is one."""
DEVICES: tuple[Device, ...] = ("cpu", "warp")
COMMANDS = ("ctrl", "mocap_pos", "mocap_quat")
"""MuJoCo's arrays that a run commands."""


class Simulations(ABC):
    """Simulations of scenes whose models have one shape; all arrays are live views of their state.

    Parameters
    ----------
    scene
        The first scene.
    bind
        Returns the field of that name of all simulations, (n, ...).
    warnings : (n, n_kinds)
        How often MuJoCo gave each of its warnings.

    Attributes
    ----------
    commanded
        Which of `COMMANDS` move something.
    """

    def __init__(
        self, scene: Scene, bind: Callable[[str], Array], warnings: npt.NDArray[np.int32]
    ) -> None:
        model = scene.hand.model
        self.sensors = Sensors(model)
        self.n_steps = steps_per_reading(model)
        self.warnings = warnings
        self.qpos, self.qvel, self.ctrl = bind("qpos"), bind("qvel"), bind("ctrl")
        self.commanded = COMMANDS if scene.mocap is not None else COMMANDS[:1]
        if scene.mocap is None:  # nothing follows it: only the record tells where the palm is to be
            self.mocap_pos, self.mocap_quat = (
                np.empty((len(warnings), 3)),
                np.empty((len(warnings), 4)),
            )
        else:
            self.mocap_pos = bind("mocap_pos")[:, scene.mocap]
            self.mocap_quat = bind("mocap_quat")[:, scene.mocap]
        self.sensordata = bind("sensordata")[:, self.sensors.first :]
        self.site_xpos = bind("site_xpos")

    @abstractmethod
    def reset(self) -> None:
        """Put everything back to where the models have it, at rest."""

    @abstractmethod
    def forward(self) -> None:
        """Compute what follows from positions, velocities and controls."""

    @abstractmethod
    def step_to_next_reading(self, tick: int, ends: Index) -> None:
        """Make the steps that follow reading ``tick``, but in runs that have ended before.

        ``ends`` (n,) are the numbers of readings of the runs.
        """

    def exact_contacts(self) -> Touch | None:
        """Return how hand and object touch if sensors have too few slots, otherwise None.

        A batch returns None in any case: it keeps no contacts that could be counted.
        """
        return None

    def incomplete(self) -> Mask | None:
        """Return which simulations (n,) had no room for all that they met; None if none can."""
        return None


class OneSimulation(Simulations):
    """One simulation by itself, of the scene's own model and data."""

    def __init__(self, scene: Scene) -> None:
        self._model, self._data = scene.hand.model, scene.hand.data
        self._options, data = self._model.opt, self._data
        super().__init__(scene, lambda name: getattr(data, name)[None], data.warning.number[None])
        self._n_contacts = self.sensors.n_contacts(self.sensordata)
        self._sensing = self._options.disableflags & ~NO_SENSORS

    def reset(self) -> None:
        mujoco.mj_resetData(self._model, self._data)
        self._options.disableflags = self._sensing

    def forward(self) -> None:
        mujoco.mj_forward(self._model, self._data)

    def step_to_next_reading(self, tick: int, ends: Index) -> None:
        # Sensors are read once a reading, so that only the last step computes them.
        model, data, options = self._model, self._data, self._options
        options.disableflags = self._sensing | NO_SENSORS
        mujoco.mj_step(model, data, nstep=self.n_steps - 1)
        options.disableflags = self._sensing
        mujoco.mj_step(model, data)

    def exact_contacts(self) -> Touch | None:
        # The number of all contacts is known at once, and seldom as large as a sensor's slots.
        if self._data.ncon <= SLOTS or max(self._n_contacts[0].tolist()) <= SLOTS:
            return None
        return contacts_of(self._model, self._data)


class BatchOfSimulations(Simulations):
    """Several simulations in one of MuJoCo's batches (MuJoCo 4.0 and later)."""

    def __init__(self, scenes: Sequence[Scene]) -> None:
        from mujoco.batch import Batch

        self._batch = Batch(scenes[0].hand.model, len(scenes), 1)
        self._batch.set_models([scene.hand.model for scene in scenes])
        super().__init__(scenes[0], self._batch.bind, self._batch.warning[:, :, 1])

    def reset(self) -> None:
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)

    def forward(self) -> None:
        self._batch.forward()

    def step_to_next_reading(self, tick: int, ends: Index) -> None:
        self._batch.step(ends > tick, nstep=self.n_steps)


def simulations_of(scenes: Sequence[Scene], device: Device = "cpu") -> Simulations:
    """Return simulations of scenes whose models have one shape."""
    if device == "warp":
        from handsim.grasping.rollout._warp_worlds import WarpWorlds

        return WarpWorlds(scenes)
    return OneSimulation(scenes[0]) if len(scenes) == 1 else BatchOfSimulations(scenes)

"""Simulations in the worlds of mujoco_warp: many at once, on a GPU where there is one.

Positions, velocities and sensors come back to arrays of this machine at each reading, so that all
else is commanded and judged as in any other run. Worlds count in single precision: runs are near
those of MuJoCo, not the same bits.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Hashable, Sequence
from dataclasses import fields
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import mujoco
import numpy as np

from handsim.errors import InputError, MissingToolError
from handsim.grasping.rollout._stepping import Simulations
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.sensing import NO_SENSORS
from handsim.types import Array, Index, Mask

INSTALL = "pip install 'handsim[warp]'"
MOST_CONTACTS = 100
"""Contacts for which a world has room; a run that meets more is left out."""
_MOST_ROWS = 4 * MOST_CONTACTS
"""Rows of its constraints: four a contact."""
_STATE = ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat")
_FOUND = ("qpos", "qvel", "sensordata", "site_xpos")
_BAD_CONTROL = int(mujoco.mjtWarning.mjWARN_BADCTRL)
_BAD_POSITION = int(mujoco.mjtWarning.mjWARN_BADQPOS)


def need_warp() -> None:
    """Check that mujoco_warp is installed.

    Raises
    ------
    MissingToolError
        If it is not.
    """
    if find_spec("mujoco_warp") is None:
        raise MissingToolError(f"device 'warp' needs mujoco_warp; install it by {INSTALL}")


def shared_key(model: mujoco.MjModel) -> Hashable:
    """Return a key that is equal for models of one shape which worlds of one batch can have.

    Worlds differ in friction, masses, places and the like, but not in what mujoco_warp keeps once
    for all of them.
    """
    return tuple(
        np.asarray(getattr(model, name)).tobytes() for name in _names(model, batched=False)
    )


class WarpWorlds(Simulations):
    """Simulations of scenes whose models have one shape and one `shared_key`.

    Raises
    ------
    InputError
        If mujoco_warp lacks something that a scene has.
    """

    def __init__(self, scenes: Sequence[Scene]) -> None:
        self._warp = _warp()
        models, n = [scene.hand.model for scene in scenes], len(scenes)
        self._device_model = _put(models, scenes[0].task.name)
        self._device = self._warp.make_data(
            models[0], nworld=n, nconmax=MOST_CONTACTS, njmax=_MOST_ROWS
        )
        # What the solver's limit of iterations cuts short is as good as MuJoCo's own.
        full = self._warp.OverflowType
        self._incomplete = int(full.ALL) & ~int(full.ITERATIONS)
        self._first_qpos = np.array([model.qpos0 for model in models])
        self._host: dict[str, Array] = {
            name: np.zeros(getattr(self._device, name).numpy().shape) for name in {*_STATE, *_FOUND}
        }
        self._on_gpu, self._graph = self._device.qpos.device.is_cuda, None
        warnings = np.zeros((n, mujoco.mjtWarning.mjNWARNING), dtype=np.int32)
        super().__init__(scenes[0], self._host.__getitem__, warnings)
        self._mocap = [
            np.array([getattr(model, f"body_{part}")[model.body_mocapid >= 0] for model in models])
            for part in ("pos", "quat")
        ]

    def reset(self) -> None:
        self.warnings[:] = 0
        for name in ("qvel", "ctrl"):
            self._host[name][:] = 0.0
        self._host["qpos"][:] = self._first_qpos
        self._host["mocap_pos"][:], self._host["mocap_quat"][:] = self._mocap

    def forward(self) -> None:
        self._upload(_STATE)
        self._warp.forward(self._device_model, self._device)
        self._download()

    def step_to_next_reading(self, tick: int, ends: Index) -> None:
        # Worlds are stepped together: those of runs that have ended go on, and nobody looks.
        bad = ~np.isfinite(self.ctrl).all(axis=1)
        self.warnings[bad, _BAD_CONTROL] += 1
        self.ctrl[bad] = 0.0  # as MuJoCo does
        self._upload(self.commanded)
        if self._graph is not None:
            import_module("warp").capture_launch(self._graph)
        else:
            self._steps()  # compiles what they need, so that they can be recorded
            self._graph = self._recorded() if self._on_gpu else None
        self._download()
        self._put_back()

    def _steps(self) -> None:
        """Step to the next reading; only its own step computes sensors."""
        options = self._device_model.opt
        options.disableflags |= NO_SENSORS
        for _ in range(self.n_steps - 1):
            self._warp.step(self._device_model, self._device)
        options.disableflags &= ~NO_SENSORS
        self._warp.step(self._device_model, self._device)

    def _recorded(self) -> Any:
        """Return the steps as a graph: started as one, not kernel by kernel from Python."""
        with import_module("warp").ScopedCapture() as capture:
            self._steps()
        return capture.graph

    def incomplete(self) -> Mask:
        return (self._device.overflow.numpy() & self._incomplete) != 0

    def _upload(self, names: Sequence[str]) -> None:
        for name in names:
            if self._host[name].size:
                getattr(self._device, name).assign(self._host[name].astype(np.float32))

    def _download(self) -> None:
        for name in _FOUND:
            self._host[name][:] = getattr(self._device, name).numpy()

    def _put_back(self) -> None:
        """Put worlds that have diverged to where they began, and warn of it, as MuJoCo does."""
        bad = ~(np.isfinite(self.qpos).all(axis=1) & np.isfinite(self.qvel).all(axis=1))
        if not bad.any():
            return
        self.warnings[bad, _BAD_POSITION] += 1
        self.qpos[bad], self.qvel[bad] = self._first_qpos[bad], 0.0
        self._host["sensordata"][bad] = 0.0
        self._upload(("qpos", "qvel"))


def _warp() -> Any:
    """Import mujoco_warp, which takes seconds and carries no types."""
    return import_module("mujoco_warp")


def _put(models: Sequence[mujoco.MjModel], name: str) -> Any:
    """Put models onto the device; what differs between them has a row for each."""
    rows: dict[str, Array] = {}
    for each in _names(models[0], batched=True):
        values = [np.asarray(getattr(model, each)) for model in models]
        if any(not np.array_equal(value, values[0]) for value in values[1:]):
            rows[each] = np.stack(values)
    try:
        made = _warp().put_model(models[0], dict.fromkeys(rows, len(models)))
    except NotImplementedError as error:
        lacking = str(error).rstrip(".")
        raise InputError(
            f"mujoco_warp cannot take the scene of '{name}': {lacking}; leave out device='warp'"
        ) from error
    for each, values in rows.items():
        target = getattr(made, each)
        target.assign(values.astype(target.numpy().dtype).reshape(target.numpy().shape))
    made.opt.warn_overflow = 0  # `WarpWorlds.incomplete` tells of it
    return made


def _names(model: mujoco.MjModel, *, batched: bool) -> list[str]:
    """Return the arrays of a model that mujoco_warp keeps for each world, or once for all."""
    names: list[str] = []
    for each in fields(_warp().Model):
        shape = getattr(each.type, "shape", None)
        if shape and (shape[0] == "*") == batched and hasattr(model, each.name):
            names.append(each.name)
    return names

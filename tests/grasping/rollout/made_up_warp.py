"""A stand-in for mujoco_warp whose worlds are MuJoCo's own simulations, in single precision.

It has what `handsim.grasping.rollout._warp_worlds` asks of mujoco_warp and nothing else, so that
what is around the worlds can be tested without minutes of compiling.
"""

from copy import copy
from dataclasses import make_dataclass
from enum import IntFlag
from types import ModuleType, SimpleNamespace

import mujoco
import numpy as np

BATCHED = (
    "qpos0", "qpos_spring", "body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass",
    "body_subtreemass", "body_inertia", "body_invweight0", "dof_invweight0", "dof_damping",
    "geom_friction", "geom_pos", "geom_size", "geom_rbound", "actuator_gainprm",
    "actuator_biasprm", "actuator_forcerange", "actuator_acc0",
)  # fmt: skip
SHARED = ("site_size", "geom_type", "mesh_vert", "body_parentid")
STATE = ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat")


class OverflowType(IntFlag):
    NEFC = 1
    ITERATIONS = 2
    ALL = 3


class Rows:
    """An array on a device: copied there and back."""

    device = SimpleNamespace(is_cuda=False)

    def __init__(self, values: np.ndarray, kind: type = np.float32) -> None:
        self._values = np.array(values, dtype=kind)

    def numpy(self) -> np.ndarray:
        return self._values.copy()

    def assign(self, values: np.ndarray) -> None:
        assert values.shape == self._values.shape
        assert values.dtype == self._values.dtype
        self._values[:] = values


def put_model(model: mujoco.MjModel, batch_sizes: dict[str, int]) -> SimpleNamespace:
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_IMPLICITFAST:
        raise NotImplementedError("mjINT_EULER is unsupported.")
    rows = {name: Rows(np.stack([getattr(model, name)] * n)) for name, n in batch_sizes.items()}
    option = SimpleNamespace(disableflags=model.opt.disableflags, warn_overflow=3)
    return SimpleNamespace(host=model, opt=option, batched=tuple(rows), **rows)


def make_data(model: mujoco.MjModel, nworld: int, nconmax: int, njmax: int) -> SimpleNamespace:
    worlds = [mujoco.MjData(model) for _ in range(nworld)]
    names = (*STATE, "sensordata", "site_xpos")
    rows = {name: Rows([getattr(each, name) for each in worlds]) for name in names}
    overflow = Rows(np.zeros(nworld), np.int32)
    return SimpleNamespace(worlds=worlds, overflow=overflow, room=nconmax, **rows)


def models_of(model: SimpleNamespace, n: int) -> list[mujoco.MjModel]:
    if not hasattr(model, "worlds"):
        model.worlds = [copy(model.host) for _ in range(n)]
        for name in model.batched:
            for i, each in enumerate(model.worlds):
                getattr(each, name)[:] = getattr(model, name).numpy()[i]
    for each in model.worlds:
        each.opt.disableflags = model.opt.disableflags
    return model.worlds


def _each(model: SimpleNamespace, data: SimpleNamespace, move) -> None:
    for name in STATE:
        for i, world in enumerate(data.worlds):
            getattr(world, name)[:] = getattr(data, name).numpy()[i]
    overflow = data.overflow.numpy()
    for i, (each, world) in enumerate(
        zip(models_of(model, len(data.worlds)), data.worlds, strict=True)
    ):
        move(each, world)
        overflow[i] |= OverflowType.ITERATIONS | (
            OverflowType.NEFC if world.ncon > data.room else 0
        )
    data.overflow.assign(overflow)
    for name in ("qpos", "qvel", "sensordata", "site_xpos"):
        values = [getattr(world, name) for world in data.worlds]
        getattr(data, name).assign(np.array(values, dtype=np.float32))


def forward(model: SimpleNamespace, data: SimpleNamespace) -> None:
    _each(model, data, mujoco.mj_forward)


def step(model: SimpleNamespace, data: SimpleNamespace) -> None:
    _each(model, data, mujoco.mj_step)


class ScopedCapture:
    """Records the steps that are asked for in place of making them, as warp does on a GPU."""

    graph: list[tuple[SimpleNamespace, SimpleNamespace, int]] | None = None
    recording: "ScopedCapture | None" = None

    def __enter__(self) -> "ScopedCapture":
        self.graph, ScopedCapture.recording = [], self
        return self

    def __exit__(self, *_: object) -> None:
        ScopedCapture.recording = None


def recorded_or_made(model: SimpleNamespace, data: SimpleNamespace) -> None:
    """Step in a module that can record."""
    if ScopedCapture.recording is None:
        step(model, data)
    else:
        ScopedCapture.recording.graph.append((model, data, model.opt.disableflags))


def capture_launch(graph: list[tuple[SimpleNamespace, SimpleNamespace, int]]) -> None:
    """Make what was recorded, with the options of then."""
    for model, data, flags in graph:
        before, model.opt.disableflags = model.opt.disableflags, flags
        step(model, data)
        model.opt.disableflags = before


def as_module() -> ModuleType:
    """The stand-in, to be put into ``sys.modules``."""
    made = ModuleType("mujoco_warp")
    specs = [(name, SimpleNamespace(shape=("*", "n"))) for name in BATCHED]
    specs += [(name, SimpleNamespace(shape=("n",))) for name in SHARED]
    made.Model = make_dataclass("Model", specs)
    for each in (OverflowType, put_model, make_data, forward, step):
        setattr(made, each.__name__, each)
    return made

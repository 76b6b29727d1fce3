"""One simulated grasp as a record: what was simulated, what happened, how it was judged.

The file holds all that is needed to draw or to judge the grasp again without simulating it: the
model as XML with its meshes, states, commands, contact loads, versions and the outcome.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math
import platform
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from handsim.content import ByContent
from handsim.errors import FileError, InputError
from handsim.files import read_archive, write_archive
from handsim.joints import FINGERS, N_JOINTS
from handsim.simulation.conditions import Conditions
from handsim.simulation.stored_model import trusted_xml
from handsim.simulation.trials import Outcome

if TYPE_CHECKING:
    import mujoco

Array = npt.NDArray[np.float64]

KIND = "rollout"
SCHEMA = 1
ASSET_PREFIX = "asset:"
CONTACT_PARTS: tuple[str, ...] = (*FINGERS, "palm")
"""Parts of the hand whose contact load on the object is kept, in column order."""


@dataclass(frozen=True)
class Phase:
    """A named stretch of a grasp that starts at ``start`` [s]."""

    name: str
    start: float


class _Text:
    """A field of text that may be given as a function, which is called when the text is wanted."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = f"_{name}"

    def __get__(self, instance: Any, owner: type | None = None) -> str:
        if instance is None:
            raise AttributeError(self._name)  # tells dataclasses that there is no default
        value: str | Callable[[], str] = getattr(instance, self._name)
        text = value if isinstance(value, str) else value()
        self.__set__(instance, text)
        return text

    def __set__(self, instance: Any, value: str | Callable[[], str]) -> None:
        object.__setattr__(instance, self._name, value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rollout(ByContent):
    """A simulated grasp; equal to another that holds the same, to the bit.

    Attributes
    ----------
    task, driver
        Name of the task, and of what drove the hand.
    model_xml, assets
        The model, which may be given as a function that makes the text, and the files it refers
        to by name.
    time : (n,) [s]
    qpos, qvel, ctrl : (n, nq), (n, nv), (n, nu)
        MuJoCo's arrays in the order of the model.
    mocap_pos, mocap_quat : (n, 3) [m], (n, 4)
        Commanded pose of the forearm.
    reading : (n, 22) [rad]
        What the data glove read.
    z : (n, n_components) [rad]
        Measured posture in the subspace; (n, 0) where the driver has none.
    contact_force : (n, 6) [N]
        Sum of normal forces on the object, per part of the hand (`CONTACT_PARTS`).
    penetration : (n,) [m]
        Deepest overlap of hand and object.
    phases
        In order of time.
    conditions, outcome
        What it was made with, and its judgement.
    """

    task: str
    driver: str
    model_xml: _Text = _Text()
    assets: dict[str, bytes]
    time: Array
    qpos: Array
    qvel: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array
    reading: Array
    z: Array
    contact_force: Array
    penetration: Array
    phases: tuple[Phase, ...]
    conditions: Conditions
    outcome: Outcome
    versions: dict[str, str] = field(default_factory=dict)

    def model(self) -> "mujoco.MjModel":
        """Compile the stored model.

        Raises
        ------
        InputError
            If it holds what no scene of this package does (see `trusted_xml`), is no model, or
            not the one that moved.
        """
        import mujoco

        try:
            xml = trusted_xml(self.model_xml, self.assets)
            model = mujoco.MjModel.from_xml_string(xml, self.assets)
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"rollout of {self.task}: {reason}") from error
        if (model.nq, model.nv) != (self.qpos.shape[1], self.qvel.shape[1]):
            raise InputError(
                f"rollout of {self.task}: {self.qpos.shape[1]} positions and "
                f"{self.qvel.shape[1]} velocities for a model of {model.nq} and {model.nv}; "
                "make it again"
            )
        return model

    def phase_at(self, time: float) -> str:
        """Name of the phase at ``time`` [s]."""
        names = [phase.name for phase in self.phases if phase.start <= time + 1e-9]
        return names[-1] if names else ""


_ARRAYS: dict[str, tuple[int | None, ...]] = {
    "time": (),
    "qpos": (None,),
    "qvel": (None,),
    "ctrl": (None,),
    "mocap_pos": (3,),
    "mocap_quat": (4,),
    "reading": (N_JOINTS,),
    "z": (None,),
    "contact_force": (len(CONTACT_PARTS),),
    "penetration": (),
}
"""Shape of a sample of each array, None for any length."""


def current_versions() -> dict[str, str]:
    """Versions and platform that bear on the numbers of a simulation."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    return {
        "handsim": version("handsim"),
        "mujoco": version("mujoco"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }


def write_rollout(rollout: Rollout, path: Path) -> None:
    """Write a rollout as ``.npz``, as a whole or not at all."""
    metadata: dict[str, Any] = {
        "task": rollout.task,
        "driver": rollout.driver,
        "model_xml": rollout.model_xml,
        "phases": [asdict(phase) for phase in rollout.phases],
        "conditions": asdict(rollout.conditions),
        "outcome": asdict(rollout.outcome),
        "versions": rollout.versions,
    }
    arrays: dict[str, npt.NDArray[Any]] = {name: getattr(rollout, name) for name in _ARRAYS}
    for name, content in rollout.assets.items():
        arrays[ASSET_PREFIX + name] = np.frombuffer(content, dtype=np.uint8)
    write_archive(path, KIND, SCHEMA, metadata, arrays)


def read_rollout(path: Path) -> Rollout:
    """Read a rollout.

    Raises
    ------
    FileError
        If the file is missing, damaged, foreign or of a newer schema, or its model could reach
        beyond the file (see `trusted_xml`).
    """
    metadata, arrays = read_archive(path, KIND, SCHEMA)
    try:
        assets = {
            name.removeprefix(ASSET_PREFIX): content.tobytes()
            for name, content in arrays.items()
            if name.startswith(ASSET_PREFIX)
        }
        trusted_xml(_text(metadata["model_xml"]), assets)
        conditions = _checked(Conditions, metadata["conditions"])
        offset = tuple(float(part) for part in conditions["object_offset"])
        return Rollout(
            task=_text(metadata["task"]),
            driver=_text(metadata["driver"]),
            model_xml=metadata["model_xml"],
            assets=assets,
            phases=tuple(Phase(**_checked(Phase, phase)) for phase in metadata["phases"]),
            conditions=Conditions(**{**conditions, "object_offset": offset}),
            outcome=Outcome(**_checked(Outcome, metadata["outcome"])),
            versions={_text(k): _text(v) for k, v in dict(metadata["versions"]).items()},
            **_checked_arrays(arrays),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path}: not a whole rollout ({error}); make it again") from error


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not text")
    return value


def _checked(kind: type, values: Any) -> dict[str, Any]:
    """Return the stored fields of a dataclass, if numbers are numbers and text is text."""
    if not isinstance(values, dict):
        raise TypeError(f"{values!r} is no table")
    for each in fields(kind):
        if each.name not in values:
            continue  # has a default, or its absence is told when it is needed
        value = values[each.name]
        if each.type in (int, float):
            number = isinstance(value, int | float) and not isinstance(value, bool)
            good = number and math.isfinite(value)
        else:
            good = each.type not in (str, bool) or isinstance(value, each.type)
        if not good:
            raise ValueError(f"{each.name} is {value!r}")
    return values


def _checked_arrays(arrays: dict[str, npt.NDArray[Any]]) -> dict[str, Array]:
    """Return the traces, if they are finite numbers and of one length."""
    n = len(np.atleast_1d(arrays["time"]))
    for name, sample in _ARRAYS.items():
        array = arrays[name]
        shaped = array.ndim == 1 + len(sample) and len(array) == n > 0
        shaped = shaped and all(
            b in (None, a) for a, b in zip(array.shape[1:], sample, strict=True)
        )
        if not shaped or array.dtype != np.float64 or not np.isfinite(array).all():
            raise ValueError(f"{name} of shape {array.shape} is not {n} samples of finite numbers")
    if not (np.diff(arrays["time"]) > 0).all():
        raise ValueError("time does not increase")
    return {name: arrays[name] for name in _ARRAYS}

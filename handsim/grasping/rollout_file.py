"""Rollouts as files: all that is needed to draw or judge a grasp again without simulating it."""

import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from handsim.errors import FileError
from handsim.files import read_archive, write_archive
from handsim.grasping._stored_model import trusted_xml
from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.record import Phase, Rollout
from handsim.joints import CONTACT_PARTS, N_JOINTS
from handsim.tasks.rules import Outcome
from handsim.types import Array, HandSize

if TYPE_CHECKING:
    pass


KIND = "rollout"


SCHEMA = 2
"""2: forces as vectors and those on the table; before that they count as 0."""


ASSET_PREFIX = "asset:"


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
    "press": (len(CONTACT_PARTS), 3),
    "penetration": (),
    "table_force": (),
}
"""Shape of a sample of each array, None for any length."""


def write_rollout(rollout: Rollout, path: Path) -> None:
    """Write a rollout as ``.npz``, as a whole or not at all."""
    metadata: dict[str, Any] = {
        "task": rollout.task,
        "driver": rollout.driver,
        "model_xml": rollout.model_xml,
        "phases": [asdict(phase) for phase in rollout.phases],
        "conditions": rollout.conditions.as_dict(),
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
        return Rollout(
            task=_text(metadata["task"]),
            driver=_text(metadata["driver"]),
            model_xml=metadata["model_xml"],
            assets=assets,
            phases=tuple(Phase(**_checked(Phase, phase)) for phase in metadata["phases"]),
            conditions=_conditions_of_json(metadata["conditions"]),
            outcome=Outcome(**_checked(Outcome, metadata["outcome"])),
            versions={_text(k): _text(v) for k, v in dict(metadata["versions"]).items()},
            **_checked_arrays(arrays, metadata["schema"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path}: not a whole rollout ({error}); make it again") from error


def _conditions_of_json(stored: Any) -> Conditions:
    """Restore what `Conditions.as_dict` gave."""
    values = dict(_checked(Conditions, stored))
    names = {"length": "hand_length", "breadth": "hand_breadth", "side": "side"}
    of_hand = {name: values.pop(key) for name, key in names.items() if key in values}
    values.setdefault("base", "free")  # before there were arms
    x, y, yaw = (float(part) for part in values.pop("object_offset"))
    return Conditions(
        hand=HandSize(**_checked(HandSize, of_hand)), object_offset=(x, y, yaw), **values
    )


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
        if each.name == "forces_n":
            good = isinstance(value, dict) and all(map(_finite, value.values()))
        elif each.type in (int, float):
            good = _finite(value)
        else:
            good = each.type not in (str, bool) or isinstance(value, each.type)
        if not good:
            raise ValueError(f"{each.name} is {value!r}")
    return values


def _finite(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value)


def _checked_arrays(arrays: dict[str, npt.NDArray[Any]], schema: int) -> dict[str, Array]:
    """Return the traces, if they are finite numbers and of one length."""
    n = len(np.atleast_1d(arrays["time"]))
    since_2 = {"press": np.zeros((n, len(CONTACT_PARTS), 3)), "table_force": np.zeros(n)}
    arrays = {**since_2, **arrays} if schema == 1 else arrays
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

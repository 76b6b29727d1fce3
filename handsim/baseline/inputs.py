"""Hashes of all that answers depend on, each small enough to say what has changed.

A hash is of rounded numbers, since what is computed elsewhere differs in its last bits and is the
same all the same: steps of `STEP` for a controller, 6 digits for what MuJoCo compiles. A number
that lies on the edge between two steps may fall to either side of it, so the edges are put where
people and files of few digits have no numbers.
"""

import hashlib
import tempfile
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.baseline.scene_arrays import scene_arrays
from handsim.files import read_archive
from handsim.learning.controller import SCHEMA, GraspController
from handsim.motion.recording import RecordingSet
from handsim.simulation.closed_loop import Stage
from handsim.simulation.glove import DataGlove
from handsim.simulation.plan import GraspPlan, schedule_for

SCHEMA_OF_INPUTS = "schema"
"""Name under which inputs say how they were hashed; 1 had no such entry."""
_HASHED_AS = {SCHEMA_OF_INPUTS: "2"}
STEP = 1e-6
"""Step in which the numbers of a controller and of recordings are told apart (rad, rad^2, m, s,
logarithms): noise of the last bits is below 1e-12, and a coefficient, of size 1, that is another
by a thousandth of its size moves a movement by less than a hundredth of a degree."""
_RELATIVE = 1e-6
_LEAST_EXPONENT = -20  # numbers below 1e-6 in steps of 1e-12, as inertias of small parts need it
_EDGE = 0.318  # of a step; no decimal or binary fraction of few digits
_NOT_OF_CONTENT = ("kind", "schema")


def controller_inputs(controller: GraspController) -> dict[str, str]:
    """Hash every array of a controller as its file holds it, in steps; give the settings."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.npz"
        controller.save(path)
        metadata, arrays = read_archive(path, "controller", SCHEMA)
    hashes = {f"controller/{name}": _hash(in_steps(array)) for name, array in arrays.items()}
    settings = {name: value for name, value in metadata.items() if name not in _NOT_OF_CONTENT}
    hashes["controller/demonstrations"] = _hash_of(settings.pop("demonstrations"))
    return _HASHED_AS | hashes | {f"controller/{n}": _said(v) for n, v in settings.items()}


def recording_inputs(recordings: RecordingSet) -> dict[str, str]:
    """Hash every recording."""
    return {
        f"recordings/{r.name}": _hash(
            *(in_steps(part) for part in (r.time, r.q, [r.hand_length, r.hand_breadth])),
            np.frombuffer(f"{r.task} {r.object}".encode(), dtype=np.uint8),
        )
        for r in recordings
    }


def grasp_inputs(stage: Stage, plan: GraspPlan) -> dict[str, str]:
    """Hash the compiled scene, the task, its schedule, the plan and the glove of a grasp.

    The conditions, which are those of all grasps, are given as they are.
    """
    name = stage.task.name
    hashes = {
        f"scene {group}/{name}": _hash(*(in_digits(array) for array in arrays))
        for group, arrays in scene_arrays(stage.hand.model).items()
    }
    task = {field.name: getattr(stage.task, field.name) for field in fields(stage.task)}
    task.pop("own_object")  # what is grasped is in the scene
    hashes[f"task/{name}"] = _hash_of(task)
    hashes[f"schedule/{name}"] = _hash_of(schedule_for(stage.task))
    hashes[f"plan/{name}"] = _hash_of(plan)
    hashes[f"glove/{name}"] = _hash_of(DataGlove())
    conditions = stage.conditions
    return hashes | {
        f"condition/{field.name}": _said(getattr(conditions, field.name))
        for field in fields(conditions)
    }


def in_steps(values: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return numbers as multiples of `STEP`; what is no number keeps its kind."""
    array = np.asarray(values, dtype=float)
    return np.floor(array / STEP + _EDGE) + 0.0


def in_digits(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return numbers to 6 digits and no finer than 1e-12; whole numbers as they are."""
    if values.dtype.kind != "f":
        return values
    exact = values.astype(float)
    # Where the size doubles so does the step, and what is just below is rounded to the same.
    size = np.ldexp(1.0, np.maximum(np.frexp(exact)[1], _LEAST_EXPONENT))
    return np.floor(exact / size / _RELATIVE + _EDGE) * size + 0.0


def _hash(*arrays: npt.NDArray[Any]) -> str:
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(f"{array.dtype.kind} {array.shape} ".encode())
        whole.update(np.ascontiguousarray(array).tobytes())
    return whole.hexdigest()[:16]


def _hash_of(value: Any) -> str:
    return hashlib.sha256("\n".join(_lines(value)).encode()).hexdigest()[:16]


def _lines(value: Any, name: str = "") -> Iterator[str]:
    """Say all that something is made of, a line each, numbers in steps."""
    if is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        for key in sorted(value):
            yield from _lines(value[key], f"{name}.{key}")
    elif isinstance(value, list | tuple):
        yield f"{name} {len(value)}"
        for i, item in enumerate(value):
            yield from _lines(item, f"{name}.{i}")
    elif isinstance(value, float):
        yield f"{name} {in_steps(value):.0f}"
    else:
        yield f"{name} {value}"


def _said(value: Any) -> str:
    """Return a setting in words: numbers to 9 digits, several with commas."""
    if isinstance(value, list | tuple):
        return ", ".join(_said(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {_said(item)}" for key, item in sorted(value.items()))
    return f"{value:.9g}" if isinstance(value, float) else str(value)

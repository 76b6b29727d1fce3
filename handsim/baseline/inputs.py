"""Hashes of all that outputs depend on, each small enough to say what has changed."""

import hashlib
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.files import read_archive
from handsim.learning.controller import SCHEMA, GraspController
from handsim.motion.recording import RecordingSet
from handsim.simulation.closed_loop import Stage

_SCENE_PARTS: dict[str, tuple[str, ...]] = {
    "friction": ("geom_friction", "geom_condim", "geom_priority"),
    "masses": ("body_mass", "body_inertia"),
    "geometry": ("geom_size", "geom_pos", "body_pos", "site_pos"),
    "contacts": ("geom_solref", "geom_solimp", "geom_contype", "geom_conaffinity"),
    "joints": (
        "jnt_axis", "jnt_range", "dof_damping", "dof_armature", "jnt_stiffness",
        "dof_frictionloss",
    ),
    "actuators": (
        "actuator_gainprm", "actuator_biasprm", "actuator_ctrlrange", "actuator_forcerange",
    ),
}  # fmt: skip
"""Arrays of a compiled model by what they mean."""
_SOLVER = (
    "timestep",
    "impratio",
    "iterations",
    "noslip_iterations",
    "integrator",
    "cone",
    "gravity",
)


def controller_inputs(controller: GraspController) -> dict[str, str]:
    """Hash every array and setting of a controller as its file holds it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.npz"
        controller.save(path)
        metadata, arrays = read_archive(path, "controller", SCHEMA)
    hashes = {f"controller/{name}": _hash(array) for name, array in arrays.items()}
    settings = {name: value for name, value in metadata.items() if name != "demonstrations"}
    return hashes | {f"controller/{name}": str(value) for name, value in settings.items()}


def recording_inputs(recordings: RecordingSet) -> dict[str, str]:
    """Hash every recording."""
    return {
        f"recordings/{r.name}": _hash(r.time, r.q, np.array([r.hand_length, r.hand_breadth]))
        for r in recordings
    }


def scene_inputs(stage: Stage) -> dict[str, str]:
    """Hash the parts of a compiled scene; give the conditions as they are.

    Numbers are taken at 6 digits, since another version of MuJoCo compiles the last ones otherwise.
    """
    model, conditions = stage.hand.model, stage.conditions
    hashes = {
        f"scene {part}/{stage.task.name}": _hash_rounded(*(getattr(model, name) for name in names))
        for part, names in _SCENE_PARTS.items()
    }
    hashes[f"scene solver/{stage.task.name}"] = _hash_rounded(
        *(np.atleast_1d(getattr(model.opt, name)) for name in _SOLVER)
    )
    settings = ("seed", "hand_length", "hand_breadth", "side", "friction", "mass_scale")
    return hashes | {f"condition/{name}": str(getattr(conditions, name)) for name in settings}


def _hash(*arrays: npt.NDArray[Any]) -> str:
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(str(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    return whole.hexdigest()[:16]


def _hash_rounded(*arrays: npt.NDArray[Any]) -> str:
    whole = hashlib.sha256()
    for array in arrays:
        values = np.round(np.asarray(array, dtype=float).ravel(), 9) + 0.0
        whole.update(" ".join(f"{value:.6g}" for value in values.tolist()).encode())
    return whole.hexdigest()[:16]

"""Hashes of all that answers depend on, each small enough to say what has changed.

A hash is of rounded numbers (`handsim.digests`), since what is computed elsewhere differs in its
last bits and is the same all the same.
"""

import tempfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.baseline.scene_arrays import scene_arrays
from handsim.digests import content_digest
from handsim.files import read_archive
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.run import Scene
from handsim.learning.controller import SCHEMA, GraspController
from handsim.recordings.folder import RecordingSet

SCHEMA_OF_INPUTS = "schema"
"""Name under which inputs say how they were hashed; 1 had no such entry."""
_HASHED_AS = {SCHEMA_OF_INPUTS: "2"}
_ENDLESS = 1e9
_NOT_OF_CONTENT = ("kind", "schema")


def controller_inputs(controller: GraspController) -> dict[str, str]:
    """Hash every array of a controller as its file holds it; give the settings."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.npz"
        controller.save(path)
        metadata, arrays = read_archive(path, "controller", SCHEMA)
    hashes = {f"controller/{name}": content_digest(array) for name, array in arrays.items()}
    settings = {name: value for name, value in metadata.items() if name not in _NOT_OF_CONTENT}
    hashes["controller/demonstrations"] = content_digest(settings.pop("demonstrations"))
    return _HASHED_AS | hashes | {f"controller/{n}": _said(v) for n, v in settings.items()}


def recording_inputs(recordings: RecordingSet) -> dict[str, str]:
    """Hash every recording."""
    return {
        f"recordings/{r.name}": content_digest(
            r.time, r.q, r.hand.length, r.hand.breadth, r.task, r.object
        )
        for r in recordings
    }


def grasp_inputs(scene: Scene, plan: GraspPlan) -> dict[str, str]:
    """Hash the compiled scene, the task, its schedule, the plan and the glove of a grasp.

    The conditions, which are those of all grasps, are given as they are.
    """
    name = scene.task.name
    hashes = {
        f"scene {group}/{name}": content_digest(*map(_measured, arrays))
        for group, arrays in scene_arrays(scene.hand.model).items()
    }
    task = {field.name: getattr(scene.task, field.name) for field in fields(scene.task)}
    task.pop("own_object")  # what is grasped is in the scene
    hashes[f"task/{name}"] = content_digest(task)
    hashes[f"schedule/{name}"] = content_digest(schedule_for(scene.task))
    hashes[f"plan/{name}"] = content_digest(plan)
    hashes[f"glove/{name}"] = content_digest(DataGlove())
    conditions = scene.conditions.as_json()
    return hashes | {f"condition/{field}": _said(value) for field, value in conditions.items()}


def _measured(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array of a model, with MuJoCo's 5e9 and 1e10 for what has no end as infinite.

    Beside such a number all others would be rounded to 0.
    """
    if array.dtype.kind != "f":
        return array
    return np.where(np.abs(array) >= _ENDLESS, np.copysign(np.inf, array), array)


def _said(value: Any) -> str:
    """Return a setting in words: numbers to 9 digits, several with commas."""
    if isinstance(value, list | tuple):
        return ", ".join(_said(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {_said(item)}" for key, item in sorted(value.items()))
    return f"{value:.9g}" if isinstance(value, float) else str(value)

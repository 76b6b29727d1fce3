"""Hashes of all that results depend on, one for each part, so that a change can be located.

Numbers are rounded before they are hashed (`handsim.digests`), since another machine computes other
last bits.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from handsim.baseline.scene_arrays import scene_arrays
from handsim.digests import content_digest
from handsim.files import read_archive
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.plan_key import task_content
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import DataGlove
from handsim.learning.controller import SCHEMA, GraspController
from handsim.recordings.recording import RecordingSet

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
    """Hash the compiled scene, the task, its schedule, plan, transport and glove of a grasp.

    The conditions are given as values; they are the same for all grasps.
    """
    name = scene.task.name
    hashes = {
        f"scene {group}/{name}": content_digest(*map(_measured, arrays))
        for group, arrays in scene_arrays(scene.hand.model).items()
    }
    hashes[f"task/{name}"] = content_digest(task_content(scene.task))
    hashes[f"schedule/{name}"] = content_digest(schedule_for(scene.task))
    hashes[f"plan/{name}"] = content_digest(plan.stored)
    hashes[f"transport/{name}"] = plan.transport.digest if plan.transport else "straight"
    hashes[f"glove/{name}"] = content_digest(DataGlove())
    conditions = scene.conditions.as_dict()
    return hashes | {f"condition/{field}": _said(value) for field, value in conditions.items()}


def _measured(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array of a model with MuJoCo's large numbers for "no limit" made infinite.

    Those are 5e9 and 1e10. Beside such a number the rounding would turn all others into 0.
    """
    if array.dtype.kind != "f":
        return array
    return np.where(np.abs(array) >= _ENDLESS, np.copysign(np.inf, array), array)


def _said(value: object) -> str:
    """Return a setting as text: numbers to 9 digits, several with commas."""
    if isinstance(value, list | tuple):
        return ", ".join(_said(item) for item in cast("Sequence[object]", value))
    if isinstance(value, dict):
        items = sorted(cast("dict[str, object]", value).items())
        return ", ".join(f"{key} {_said(item)}" for key, item in items)
    return f"{value:.9g}" if isinstance(value, float) else str(value)

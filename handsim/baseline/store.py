"""A baseline as a file."""

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.baseline.outputs import Outputs, Questions, Trace
from handsim.errors import FileError
from handsim.files import read_archive, write_archive
from handsim.joints import N_JOINTS
from handsim.simulation.plan import GraspPlan, Pose
from handsim.simulation.rollout import current_versions

KIND = "baseline"
SCHEMA = 1
_MAX_VALUE = 1000.0  # of angles [rad], times [s] and lengths [m]
_PLAN_NUMBERS = 3 + 4 + 3 + 2 * N_JOINTS + 2


@dataclass(frozen=True)
class Baseline:
    """Questions, the answers that were right, and why they were taken for right.

    Attributes
    ----------
    questions, outputs
        What was asked, and what came.
    relearned
        Whether a controller learned again was asked too.
    versions
        Of the packages and the platform that the answers come from.
    reasons
        One for the record and each update since.
    """

    questions: Questions
    outputs: Outputs
    relearned: bool
    versions: dict[str, str]
    reasons: tuple[str, ...]


def versions_here() -> dict[str, str]:
    """Return versions and platform that bear on learning and simulation."""
    return current_versions() | {name: version(name) for name in ("scipy", "scikit-learn")}


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline as ``.npz``, as a whole or not at all."""
    traces, questions = baseline.outputs.traces, baseline.questions
    arrays: dict[str, npt.NDArray[Any]] = {}
    for i, trace in enumerate(traces.values()):
        arrays[f"time_{i}"], arrays[f"q_{i}"] = trace.time, trace.q
    arrays["starts"] = np.array(list(questions.starts.values())).reshape(-1, N_JOINTS)
    arrays["goals"] = np.array(list(questions.goals.values())).reshape(-1, N_JOINTS)
    plans = [_plan_to_row(plan) for plan in questions.plans.values()]
    arrays["plans"] = np.array(plans).reshape(-1, _PLAN_NUMBERS)
    metadata = {
        "traces": [
            {"name": name, "verdict": trace.verdict, "measures": trace.measures}
            for name, trace in traces.items()
        ],
        "movements": list(questions.starts),
        "tasks": list(questions.plans),
        "inputs": baseline.outputs.inputs,
        "relearned": baseline.relearned,
        "versions": baseline.versions,
        "reasons": list(baseline.reasons),
    }
    write_archive(path, KIND, SCHEMA, metadata, arrays)


def read_baseline(path: Path) -> Baseline:
    """Read a baseline.

    Raises
    ------
    FileError
        If the file is missing, damaged, foreign or of a newer schema.
    """
    metadata, arrays = read_archive(path, KIND, SCHEMA)
    try:
        for name, array in arrays.items():
            if array.dtype != np.float64 or not (np.abs(array) <= _MAX_VALUE).all():
                raise ValueError(f"{name} holds what is no number up to {_MAX_VALUE:g}")
        n = len(metadata["movements"])
        starts, goals = _matrix(arrays["starts"], n), _matrix(arrays["goals"], n)
        tasks, plans = metadata["tasks"], arrays["plans"]
        if plans.shape != (len(tasks), _PLAN_NUMBERS):
            raise ValueError(f"plans of shape {plans.shape} for {len(tasks)} tasks")
        return Baseline(
            questions=Questions(
                dict(zip(metadata["movements"], starts, strict=True)),
                dict(zip(metadata["movements"], goals, strict=True)),
                {str(task): _plan_of_row(row) for task, row in zip(tasks, plans, strict=True)},
            ),
            outputs=Outputs(
                {
                    str(stored["name"]): _trace(stored, arrays[f"time_{i}"], arrays[f"q_{i}"])
                    for i, stored in enumerate(metadata["traces"])
                },
                {str(name): str(value) for name, value in dict(metadata["inputs"]).items()},
            ),
            relearned=bool(metadata["relearned"]),
            versions={str(k): str(v) for k, v in dict(metadata["versions"]).items()},
            reasons=tuple(str(reason) for reason in metadata["reasons"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path}: not a whole baseline ({error}); record it again") from error


def _matrix(array: npt.NDArray[Any], n: int) -> npt.NDArray[np.float64]:
    if array.shape != (n, N_JOINTS):
        raise ValueError(f"postures of shape {array.shape} instead of ({n}, {N_JOINTS})")
    return array


def _trace(
    stored: dict[str, Any], time: npt.NDArray[np.float64], q: npt.NDArray[np.float64]
) -> Trace:
    if time.ndim != 1 or not len(time) or (np.diff(time) <= 0).any():
        raise ValueError(f"time of {stored['name']} does not increase")
    measures = {str(name): float(value) for name, value in dict(stored["measures"]).items()}
    if not np.isfinite(list(measures.values())).all():
        raise ValueError(f"measures of {stored['name']} are not finite")
    return Trace(time, _matrix(q, len(time)), str(stored["verdict"]), measures)


def _plan_to_row(plan: GraspPlan) -> npt.NDArray[np.float64]:
    factors = np.array([plan.squeeze, plan.arrive])
    pose = (plan.palm.pos, plan.palm.quat)
    return np.concatenate([*pose, plan.retreat, plan.q_start, plan.q_goal, factors])


def _plan_of_row(row: npt.NDArray[np.float64]) -> GraspPlan:
    pos, quat, retreat, q_start, q_goal, factors = np.split(
        row, np.cumsum([3, 4, 3, N_JOINTS, N_JOINTS])
    )
    return GraspPlan(Pose(pos, quat), retreat, q_start, q_goal, *factors.tolist())

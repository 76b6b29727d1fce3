"""A baseline as a file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.baseline.comparison import not_numbers
from handsim.baseline.environment import Environment
from handsim.baseline.results import Cases, Results, Trace
from handsim.errors import FileError, InputError
from handsim.files import read_archive, write_archive
from handsim.grasping.plan import GraspPlan, Pose
from handsim.joints import N_JOINTS

KIND = "baseline"
SCHEMA = 2  # 1: plans as rows of numbers, versions instead of an environment; still read
_MAX_VALUE = 1000.0  # of angles [rad], times [s] and lengths [m]
_PLAN_NUMBERS = 3 + 4 + 3 + 2 * N_JOINTS + 2
_LENGTHS = {"palm_pos": 3, "palm_quat": 4, "retreat": 3, "q_start": N_JOINTS, "q_goal": N_JOINTS}
"""Lengths of the vectors of a plan."""
_SCALARS = tuple(each.name for each in fields(GraspPlan) if each.type is float)


@dataclass(frozen=True)
class Baseline:
    """Cases, their results, and why these results are taken for right.

    Attributes
    ----------
    cases, results
        What was run, and what came of it.
    relearned
        Whether the movements were also made by a controller learned again.
    environment
        In which the results were made.
    handsim
        Version that made them.
    reasons
        Why the results are right: one for the first record, and one for each update since.
    """

    cases: Cases
    results: Results
    relearned: bool
    environment: Environment
    handsim: str
    reasons: tuple[str, ...]


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline as ``.npz``, as a whole or not at all.

    Raises
    ------
    InputError
        If a result holds values that are not finite.
    """
    for fault in not_numbers(baseline.results):
        raise InputError(f"{path}: {fault}; no baseline can be made of it, nothing is written")
    traces, cases = baseline.results.traces, baseline.cases
    arrays: dict[str, npt.NDArray[Any]] = {}
    for i, trace in enumerate(traces.values()):
        arrays[f"time_{i}"], arrays[f"q_{i}"] = trace.time, trace.q
    arrays["starts"] = np.array(list(cases.starts.values())).reshape(-1, N_JOINTS)
    arrays["goals"] = np.array(list(cases.goals.values())).reshape(-1, N_JOINTS)
    metadata = {
        "traces": [
            {"name": name, "verdict": trace.verdict, "measures": trace.measures}
            for name, trace in traces.items()
        ],
        "movements": list(cases.starts),
        "tasks": list(cases.plans),
        "plans": [_plan_to_json(plan) for plan in cases.plans.values()],
        "inputs": baseline.results.inputs,
        "relearned": baseline.relearned,
        "environment": asdict(baseline.environment),
        "handsim": baseline.handsim,
        "reasons": list(baseline.reasons),
    }
    write_archive(path, KIND, SCHEMA, metadata, arrays)


def read_baseline(path: Path) -> Baseline:
    """Read a baseline.

    Raises
    ------
    FileError
        If the file is missing, damaged, foreign or of a newer schema, or a result in it is not
        finite or lacks its measures.
    """
    metadata, arrays = read_archive(path, KIND, SCHEMA)
    try:
        for name, array in arrays.items():
            if array.dtype != np.float64 or not (np.abs(array) <= _MAX_VALUE).all():
                raise ValueError(f"{name} holds what is no number up to {_MAX_VALUE:g}")
        old = metadata["schema"] == 1
        movements = [str(name) for name in metadata["movements"]]
        starts, goals = (_matrix(arrays[name], len(movements)) for name in ("starts", "goals"))
        tasks = [str(task) for task in metadata["tasks"]]
        plans = _rows(arrays["plans"], len(tasks)) if old else metadata["plans"]
        from_stored = _plan_of_row if old else _plan_of_json
        known = dict(metadata["versions"] if old else metadata["environment"])
        return Baseline(
            cases=Cases(
                dict(zip(movements, starts, strict=True)),
                dict(zip(movements, goals, strict=True)),
                {task: from_stored(plan) for task, plan in zip(tasks, plans, strict=True)},
            ),
            results=Results(
                {
                    str(stored["name"]): _trace(stored, arrays[f"time_{i}"], arrays[f"q_{i}"])
                    for i, stored in enumerate(metadata["traces"])
                },
                {str(name): str(value) for name, value in dict(metadata["inputs"]).items()},
            ),
            relearned=bool(metadata["relearned"]),
            environment=Environment.stored(known),
            handsim=str(known["handsim"] if old else metadata["handsim"]),
            reasons=tuple(str(reason) for reason in metadata["reasons"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path}: not a whole baseline ({error}); record it again") from error


def _matrix(array: npt.NDArray[Any], n: int) -> npt.NDArray[np.float64]:
    if array.shape != (n, N_JOINTS):
        raise ValueError(f"postures of shape {array.shape} instead of ({n}, {N_JOINTS})")
    return array


def _trace(
    stored: Mapping[str, Any], time: npt.NDArray[np.float64], q: npt.NDArray[np.float64]
) -> Trace:
    name, verdict = str(stored["name"]), str(stored["verdict"])
    if time.ndim != 1 or not len(time) or (np.diff(time) <= 0).any():
        raise ValueError(f"time of {name} does not increase")
    measures = {str(measure): float(value) for measure, value in dict(stored["measures"]).items()}
    if not np.isfinite(list(measures.values())).all():
        raise ValueError(f"measures of {name} are not finite")
    if name.startswith("grasp/") and not verdict.startswith("refused") and not measures:
        raise ValueError(f"{name} has no measures")
    return Trace(time, _matrix(q, len(time)), verdict, measures)


def _plan_to_json(plan: GraspPlan) -> dict[str, Any]:
    """Return what is stored of a plan; JSON keeps every bit of a number."""
    values: dict[str, Any] = dict(plan.stored)
    palm = values.pop("palm")
    values |= {"palm_pos": palm.pos, "palm_quat": palm.quat}
    return {name: None if v is None else np.asarray(v).tolist() for name, v in values.items()}


def _plan_of_json(stored: Mapping[str, Any]) -> GraspPlan:
    values = {name: _plan_value(name, value) for name, value in dict(stored).items()}
    palm = Pose(values.pop("palm_pos"), values.pop("palm_quat"))
    return GraspPlan(palm=palm, **values)


def _plan_value(name: str, value: Any) -> Any:
    """Return a stored field of a plan: a number, a vector, or None where there may be nothing."""
    scalar = name in _SCALARS
    if value is None and not scalar and name not in _LENGTHS:
        return None
    array = np.array(value, dtype=float)
    if array.ndim != (0 if scalar else 1) or array.size != _LENGTHS.get(name, array.size):
        raise ValueError(f"{name} of a plan has shape {array.shape}")
    if not (np.abs(array) <= _MAX_VALUE).all():
        raise ValueError(f"{name} of a plan is no number up to {_MAX_VALUE:g}")
    return float(array) if scalar else array


def _rows(array: npt.NDArray[Any], n: int) -> npt.NDArray[np.float64]:
    if array.shape != (n, _PLAN_NUMBERS):
        raise ValueError(f"plans of shape {array.shape} for {n} tasks")
    return array


def _plan_of_row(row: npt.NDArray[np.float64]) -> GraspPlan:
    pos, quat, retreat, q_start, q_goal, factors = np.split(
        row, np.cumsum([3, 4, 3, N_JOINTS, N_JOINTS])
    )
    return GraspPlan(Pose(pos, quat), retreat, q_start, q_goal, *factors.tolist())

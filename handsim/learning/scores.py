"""How well a controller does what people did.

Path error: both paths resampled at 100 points equally spaced in their own arc length, root of the
mean squared distance in the subspace. Straight: the same for the segment from start to
destination, which is what a constant beta gives. A run that does not arrive counts as it is.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.learning.controller import GraspController
from handsim.learning.paths import FlowPath, follow, path_error
from handsim.motion.recording import RecordingSet

Array = npt.NDArray[np.float64]
Learn = Callable[[RecordingSet], GraspController]


def evaluate(controller: GraspController, recordings: RecordingSet) -> dict[str, Any]:
    """Compare roll-outs with recordings, from the same starts to the same destinations.

    Returns
    -------
    dict
        ``n_recordings, n_arrived, path_error_deg`` (mean)``, straight_error_deg`` (mean)``,
        ratio, per_recording: [{name, arrived, path_error_deg, straight_error_deg}]``.
    """
    paths = [controller.subspace.transform(r.q) for r in recordings]
    rollouts = roll_out(controller, paths)
    return _summarise([_row(*args) for args in zip(recordings, rollouts, paths, strict=True)])


def leave_one_out(recordings: RecordingSet, learn: Learn) -> dict[str, Any]:
    """Score each recording with a controller learned from all the others.

    Parameters
    ----------
    recordings
        At least 2.
    learn
        Makes a controller from recordings.

    Returns
    -------
    dict
        As `evaluate`.
    """
    rows = []
    for i, recording in enumerate(recordings):
        controller = learn(recordings.without(i))
        path = controller.subspace.transform(recording.q)
        rows.append(_row(recording, roll_out(controller, [path])[0], path))
    return _summarise(rows)


def roll_out(controller: GraspController, paths: list[Array]) -> list[FlowPath]:
    """Follow the controller from the start of each path to its end."""
    starts = np.array([path[0] for path in paths])
    goals = np.array([path[-1] for path in paths])
    return follow(controller.navigation.directions, starts, goals)


def _row(recording: Any, rollout: FlowPath, path: Array) -> dict[str, Any]:
    return {
        "name": recording.name,
        "arrived": rollout.arrived,
        "path_error_deg": float(np.rad2deg(path_error(rollout.points, path))),
        "straight_error_deg": float(np.rad2deg(path_error(path[[0, -1]], path))),
    }


def _summarise(rows: list[dict[str, Any]]) -> dict[str, Any]:
    error = float(np.mean([row["path_error_deg"] for row in rows]))
    straight = float(np.mean([row["straight_error_deg"] for row in rows]))
    return {
        "n_recordings": len(rows),
        "n_arrived": sum(row["arrived"] for row in rows),
        "path_error_deg": error,
        "straight_error_deg": straight,
        "ratio": error / straight,
        "per_recording": rows,
    }

"""Scores: how close the paths of a controller are to recorded ones.

Path error, as in the paper's Fig. 7: both paths resampled at 100 points equally spaced in their own
arc length, root of the mean squared distance in the subspace. Straight: the same for the segment
from start to destination, which is the flow of a constant beta. Repeatability: the path error of
the other trials of the same object by the same person, their ends moved to match. A path that does
not arrive is scored like all others.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handsim.errors import InputError
from handsim.learning.certification import proves
from handsim.learning.controller import GraspController
from handsim.learning.guide.likeness import Grasped, object_numbers
from handsim.learning.over_time import SCORED, over_time
from handsim.navigation.flow import FlowPath
from handsim.navigation.paths import N_COMPARED, at_arc_length, between_ends, path_error
from handsim.recordings.recording import Recording, RecordingSet
from handsim.reproducible import units
from handsim.result import Result
from handsim.types import Array, Progress

Learn = Callable[[RecordingSet], GraspController]

# Where direction is compared: near its end a recording's direction is noise.
_DIRECTION_FRACTIONS = np.linspace(0.0, 0.97, N_COMPARED)


@dataclass(frozen=True)
class Scores(Result):
    """How close paths of a controller come to recorded ones.

    Attributes
    ----------
    n_recordings, n_arrived
    path_error_deg, straight_error_deg
        Means over the recordings.
    ratio
        The first over the second; None where the straight error is 0.
    repeatability_deg
        None if no object was grasped twice.
    direction_error_deg
        Mean angle between the path and the recorded motion, both at the same fraction of length.
    object_known
        Whether the controller was told which object each recording is about.
    n_proven
        Recordings whose destination is proven to be reached from everywhere in the workspace.
    rms_over_time_deg, rms_truncation_deg, rms_clipping_deg, rms_path_deg, speed_correlation
    peak_time_error
        See `learning.over_time.OverTime`.
    variance_explained
        By the subspace, of the postures of the recordings that were scored.
    per_recording
        ``name, object, arrived, proven, path_error_deg, straight_error_deg, repeatability_deg,
        direction_error_deg`` of each, and its scores over time.
    per_object
        The means of each object.
    """

    n_recordings: int
    n_arrived: int
    path_error_deg: float | None
    straight_error_deg: float | None
    ratio: float | None
    repeatability_deg: float | None
    direction_error_deg: float | None
    rms_over_time_deg: float | None
    rms_truncation_deg: float | None
    rms_clipping_deg: float | None
    rms_path_deg: float | None
    speed_correlation: float | None
    peak_time_error: float | None
    n_proven: int
    per_recording: tuple[dict[str, Any], ...]
    per_object: tuple[dict[str, Any], ...]
    variance_explained: float
    object_known: bool = True


def evaluate(
    controller: GraspController,
    recordings: RecordingSet,
    object_known: bool = True,
    progress: Progress | None = None,
) -> Scores:
    """Compare roll-outs with recordings, from the same starts to the same destinations.

    Parameters
    ----------
    controller
    recordings
    object_known
        Whether the controller is told which object each recording is about.
    progress
        Called with the fraction done.
    """
    paths = [controller.subspace.transform(r.q) for r in recordings]
    repeats = _repeatabilities(recordings, paths)
    rows: list[dict[str, Any]] = []
    for recording, path, repeat in zip(recordings, paths, repeats, strict=True):
        rows.append(_row(controller, recording, path, repeat, object_known))
        if progress:
            progress(len(rows) / len(recordings))
    return _summarise(rows, variance_explained(controller, recordings), object_known)


def leave_one_out(
    recordings: RecordingSet,
    learn: Learn,
    progress: Progress | None = None,
    object_known: bool = True,
) -> Scores:
    """Score each recording with a controller learned from all the others.

    Parameters
    ----------
    recordings
        At least 2.
    learn
        Makes a controller from recordings.
    progress
        Called with the fraction done.
    object_known
        As in `evaluate`.

    Returns
    -------
    Scores
        ``variance_explained`` is of the recordings left out.
    """
    if len(recordings) < 2:
        raise InputError("1 recording; leaving one out needs at least 2")
    rows: list[dict[str, Any]] = []
    explained: list[float] = []
    for i, recording in enumerate(recordings):
        controller = learn(recordings.without(i))
        paths = [controller.subspace.transform(r.q) for r in recordings]
        repeat = _repeatabilities(recordings, paths)[i]
        rows.append(_row(controller, recording, paths[i], repeat, object_known))
        explained.append(variance_explained(controller, RecordingSet((recording,))))
        if progress:
            progress((i + 1) / len(recordings))
    return _summarise(rows, float(np.mean(explained)), object_known)


def roll_out(controller: GraspController, path: Array, grasped: Grasped | None = None) -> FlowPath:
    """Follow the controller from the start of a recorded path (n, n_components) to its end.

    The end of a recorded movement can be where no destination is allowed; such a path does not
    arrive.
    """
    try:
        return controller.path(path[0], path[-1], grasped)
    except InputError:
        return FlowPath(path[[0, 0]], False, "refused")


def repeatability(path: Array, others: list[Array]) -> float | None:
    """Mean path error [rad] of other paths whose ends are moved to those of ``path``.

    None if there are no others.
    """
    errors = [path_error(between_ends(other, path[0], path[-1]), path) for other in others]
    return float(np.mean(errors)) if errors else None


def direction_error(
    controller: GraspController, path: Array, grasped: Grasped | None = None
) -> float:
    """Mean angle [rad] between the flow and the direction of motion along a recorded path."""
    points = at_arc_length(path, _DIRECTION_FRACTIONS)
    tangents: Array = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    guided = controller.field(path[0], path[-1], grasped)
    if guided is None:
        flow = controller.navigation.directions(points, path[-1])
    else:
        here = zip(points, _DIRECTION_FRACTIONS.tolist(), strict=True)
        flow = units(
            np.vstack([guided.velocity(z[None], s, 1.0, 1.0 / (1.0 - s)) for z, s in here])
        )
    cosines: Array = np.sum(flow * tangents, axis=1)
    return float(np.mean(np.arccos(np.clip(cosines, -1.0, 1.0))))


def variance_explained(controller: GraspController, recordings: RecordingSet) -> float:
    """Fraction of the recordings' variance (about the subspace's mean) inside the subspace."""
    q = np.vstack([r.q for r in recordings])
    subspace = controller.subspace
    missed = q - subspace.inverse_transform(subspace.transform(q))
    return 1.0 - float(np.sum(missed**2) / np.sum((q - subspace.mean_) ** 2))


def _repeatabilities(recordings: RecordingSet, paths: list[Array]) -> list[float | None]:
    """Repeatability of each recording against the same person's others of the same object."""
    keys = [(r.subject, r.object, r.task) for r in recordings]
    return [
        repeatability(path, [p for j, p in enumerate(paths) if j != i and keys[j] == keys[i]])
        for i, path in enumerate(paths)
    ]


def _row(
    controller: GraspController,
    recording: Recording,
    path: Array,
    repeat: float | None,
    object_known: bool,
) -> dict[str, Any]:
    grasped = _grasped(controller, recording) if object_known else None
    rollout = roll_out(controller, path, grasped)
    refused = rollout.reason == "refused"
    return {
        "name": recording.name,
        "object": recording.object,
        "arrived": rollout.arrived,
        "proven": not refused and proves(controller, path[0], path[-1], grasped),
        "path_error_deg": _degrees(path_error(rollout.points, path)),
        "straight_error_deg": _degrees(path_error(path[[0, -1]], path)),
        "repeatability_deg": None if repeat is None else _degrees(repeat),
        "direction_error_deg": (
            None if refused else _degrees(direction_error(controller, path, grasped))
        ),
        **vars(over_time(controller, recording, rollout, grasped)),
    }


def _grasped(controller: GraspController, recording: Recording) -> Grasped:
    """Return what is told of the object of a recording.

    Its numbers, if it has all by which the controller knows objects, or else its name.
    """
    predictor, numbers = controller.predictor, object_numbers(recording.extra)
    asked = predictor.objects[0].numbers if predictor else ()
    return numbers if asked and set(asked) <= set(numbers) else recording.object


def _summarise(rows: list[dict[str, Any]], explained: float, object_known: bool) -> Scores:
    objects = dict.fromkeys(row["object"] for row in rows)
    of_objects = (
        {"object": name, **_means([row for row in rows if row["object"] == name])}
        for name in objects
    )
    return Scores(
        **_means(rows),
        per_recording=tuple(rows),
        per_object=tuple(of_objects),
        variance_explained=explained,
        object_known=object_known,
    )


def _means(rows: list[dict[str, Any]]) -> dict[str, Any]:
    def mean(key: str) -> float | None:
        values = [row[key] for row in rows if row[key] is not None]
        return float(np.mean(values)) if values else None

    error, straight = mean("path_error_deg"), mean("straight_error_deg")
    return {
        "n_recordings": len(rows),
        "n_arrived": sum(row["arrived"] for row in rows),
        "path_error_deg": error,
        "straight_error_deg": straight,
        "ratio": error / straight if error is not None and straight else None,
        "repeatability_deg": mean("repeatability_deg"),
        "direction_error_deg": mean("direction_error_deg"),
        "n_proven": sum(row["proven"] for row in rows),
        **{name: mean(name) for name in SCORED},
    }


def _degrees(angle: float) -> float:
    return float(np.rad2deg(angle))

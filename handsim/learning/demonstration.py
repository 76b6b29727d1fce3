"""What a controller keeps of each recording: both ends, its path, its timing and its signals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from handsim.errors import UnknownNameError
from handsim.learning.guide.likeness import object_numbers
from handsim.learning.movement.progress import N_PROGRESS
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.paths import N_COMPARED, arc_length, at_arc_length
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.signals import signals_of
from handsim.types import Array

SIGNAL_PROGRESS = np.linspace(0.0, 1.0, 101)
"""Progress at which signals are kept."""
_MOST_SIGNAL = 1e6  # a channel with greater values is not kept: a controller's file holds none


@dataclass(frozen=True)
class Demonstration:
    """What a controller keeps of one recording.

    Attributes
    ----------
    name, task, object
        As in the recording.
    q_start, q_goal : (22,) [rad]
        First and last posture recorded, whole.
    z_start, z_goal : (n_components,) [rad]
        The same in the subspace.
    hand_length, hand_breadth : [m]
    duration : [s]
    numbers
        What is known of the object: columns ``object_...`` of ``experiments.csv``.
    path : (100, n_components) [rad]
        The path in the subspace, equally spaced in arc length. None in files of earlier versions.
    progress : (51,)
        Fraction of its length covered at equal steps of time; None likewise.
    signals : name to (101,)
        Channels and what is derived from them (`handsim.recordings.signals`) at equally spaced
        progress, to 7 digits. Only those without a missing value.
    """

    name: str
    task: str
    object: str
    q_start: Array
    q_goal: Array
    z_start: Array
    z_goal: Array
    hand_length: float
    hand_breadth: float
    duration: float
    numbers: Mapping[str, float] = field(default_factory=dict[str, float])
    path: Array | None = None
    progress: Array | None = None
    signals: Mapping[str, Array] = field(default_factory=dict[str, Array])


def demonstrations_of(
    recordings: RecordingSet, subspace: PostureSubspace
) -> tuple[Demonstration, ...]:
    """Return what is kept of recordings."""
    return tuple(_demonstration_of(each, subspace) for each in recordings)


def _demonstration_of(recording: Recording, subspace: PostureSubspace) -> Demonstration:
    z = subspace.transform(recording.q)
    length = arc_length(z)
    passed = (recording.time - recording.time[0]) / recording.duration
    covered = length / max(float(length[-1]), np.finfo(float).tiny)
    return Demonstration(
        name=recording.name,
        task=recording.task,
        object=recording.object,
        q_start=recording.q[0],
        q_goal=recording.q[-1],
        z_start=z[0],
        z_goal=z[-1],
        hand_length=recording.hand.length,
        hand_breadth=recording.hand.breadth,
        duration=recording.duration,
        numbers=object_numbers(recording.extra),
        path=at_arc_length(z, np.linspace(0.0, 1.0, N_COMPARED)),
        progress=np.interp(np.linspace(0.0, 1.0, N_PROGRESS), passed, covered),
        signals=_by_progress(recording, covered),
    )


def _by_progress(recording: Recording, covered: Array) -> dict[str, Array]:
    """Return signals at equally spaced progress, given that at each frame; 7 digits take less."""
    moved = np.append(True, np.diff(covered) > 0)  # of a standstill its first frame counts
    return {
        name: np.interp(SIGNAL_PROGRESS, covered[moved], values[moved])
        .astype(np.float32)
        .astype(np.float64)
        for name, values in signals_of(recording.time, recording.channels).items()
        if (np.abs(values) <= _MOST_SIGNAL).all()
    }


def named(demonstrations: Sequence[Demonstration], name: str) -> Demonstration:
    """Return the first demonstration of a name: a recording's, a task's, or else an object's.

    Raises
    ------
    UnknownNameError
        If there is none; the message offers the nearest.
    """
    of_names = [(d.name, d.task) for d in demonstrations]
    of_objects = [(d.object,) for d in demonstrations]
    for known in (of_names, of_objects):
        for demonstration, names in zip(demonstrations, known, strict=True):
            if name in names:
                return demonstration
    every = [each for known in (of_names, of_objects) for names in known for each in names]
    kind = "task, recording or object"
    raise UnknownNameError(kind, name, tuple(dict.fromkeys(every)))

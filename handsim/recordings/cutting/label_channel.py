"""Labels beside a recording, such as the number of a repetition, and the reaches they frame."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from handsim.recordings.cutting.events import AT_EVENT
from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.cutting.readings import Reading, read_course
from handsim.recordings.cutting.single import is_single_reach
from handsim.recordings.cutting.stops import LARGE, Course, course_of
from handsim.recordings.recording import MIN_FRAMES, Recording
from handsim.types import Array

LABEL = "label"


def read_labels(
    motion: Motion, course: Course, labels: Array, options: CutOptions
) -> list[Reading]:
    """Look for one reach in every stretch of a label other than that of rest.

    Rest is 0, or the first label where none is 0. A stretch in which the hand comes back to the
    posture of rest is a return, and one in which it hardly moves is a hold.
    """
    rest = labels == (0 if (labels == 0).any() else labels[0])
    home = np.median(motion.place[rest], axis=0)
    changes = np.flatnonzero(np.diff(labels)) + 1
    found: list[Reading] = []
    for first, last in pairwise([0, *(int(change) for change in changes), len(labels)]):
        way = np.linalg.norm(motion.place[first:last] - home, axis=1)
        if rest[first] or last - first < MIN_FRAMES or float(np.ptp(way)) < LARGE * course.size:
            continue
        reading = _in_stretch(motion, first, last, options)
        if reading is not None and way[reading.end - first] > way[reading.start - first]:
            found.append(reading)
    return found


def _in_stretch(motion: Motion, first: int, last: int, options: CutOptions) -> Reading | None:
    """Return the surest reach between two frames."""
    part = Motion(
        motion.time[first:last], motion.q[first:last], motion.place[first:last],
        motion.speed[first:last], motion.seen[first:last], motion.palm, motion.floor,
    )  # fmt: skip
    course = course_of(part, options.rest_share(palm=motion.palm))
    if course is None:
        return None
    if is_single_reach(part, course, options):
        return Reading(first, last - 1, last - 1, AT_EVENT, f"{LABEL} says so", told="both")
    readings = read_course(part, course, options)
    best = max(readings, key=lambda reading: reading.confidence, default=None)
    if best is None:
        return None
    second = None if best.second is None else (best.second[0] + first, best.second[1] + first)
    return replace(
        best, start=best.start + first, end=best.end + first, hold_end=best.hold_end + first,
        second=second,
    )  # fmt: skip


def label_steps(recording: Recording, grid: Array) -> Array | None:
    """Return the label at each time, the last one given; None where it never changes."""
    values = recording.channels.get(LABEL)
    if values is None or not np.isfinite(values).any():
        return None
    known = np.isfinite(values)
    place = np.searchsorted(recording.time[known], grid, side="right") - 1
    labels = values[known][np.maximum(place, 0)]
    return labels if (labels != labels[0]).any() else None

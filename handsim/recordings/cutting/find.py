"""Find the reaches of one recording, by its speed and by what else was recorded."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.cutting.edges import edges
from handsim.recordings.cutting.events import AT_EVENT, beginnings, least_move, read_events
from handsim.recordings.cutting.motion import Motion, motion_of, on_grid
from handsim.recordings.cutting.reach import CutOptions, Reach
from handsim.recordings.cutting.readings import Reading, read_course
from handsim.recordings.cutting.stops import LARGE, NOISE_FACTOR, Course, course_of
from handsim.recordings.phases import RATE
from handsim.recordings.recording import MIN_FRAMES, Recording
from handsim.types import Array, Mask

OBJECT = ("object_x_m", "object_y_m", "object_z_m")
LABEL = "label"
WHOLE = "it is a single reach already"
CUT_ALREADY_S = 0.3
"""A recording that stands still no longer than this at its ends has been cut before [s]."""
ENDS_AWAY = 0.5
"""and it ends no nearer than this share of its largest distance from its start."""


def find_reaches(recording: Recording, options: CutOptions) -> tuple[Reach, ...]:
    """Find the reaches of one recording, in order; certain ones and doubtful ones.

    Raises
    ------
    UnknownNameError
        If the recording has not the channel of the options.
    InputError
        If that channel holds next to no values, or the recording is too short or too long.
    """
    try:
        motion = motion_of(recording.time, recording.q, recording.channels)
    except InputError as error:
        raise InputError(f"recording '{recording.name}': {error}") from error
    course = course_of(motion, options.rest_share(palm=motion.palm))
    if course is None:
        return ()
    readings = _readings(recording, motion, course, options)
    share = options.rest_share(palm=motion.palm)
    return tuple(_reach(recording.name, motion, course, each, share) for each in readings)


def _readings(
    recording: Recording, motion: Motion, course: Course, options: CutOptions
) -> list[Reading]:
    """Choose by what the end of a reach is told: a channel, an object, a label, or speed alone."""
    labels = _labels(recording, motion.time) if options.channel in (None, LABEL) else None
    if labels is not None:
        return read_labels(motion, course, labels, options)
    if options.channel is not None:
        values, seen = _channel(recording, options.channel, motion.time)
        events = beginnings(values, seen, least_move(values, position=False))
        return read_events(motion, course, events, f"{options.channel} begins to move", snap=False)
    if is_single_reach(motion, course, options):
        last = len(motion.time) - 1
        return [Reading(0, last, last, AT_EVENT, WHOLE, exact=True)]
    spoken = read_course(motion, course, options)
    tracked = _object(recording, motion.time)
    if tracked is not None:
        events = beginnings(*tracked, least_move(tracked[0], position=True))
        if events:
            touched = read_events(motion, course, events, "the object begins to move", snap=True)
            return _joined(touched, spoken)
    return spoken


def read_labels(
    motion: Motion, course: Course, labels: Array, options: CutOptions
) -> list[Reading]:
    """Look for one reach in every stretch of a label other than that of rest.

    Rest is 0, or the first label where none is 0. A stretch in which the hand comes back to the
    posture of rest is a return, and one in which it hardly moves is a hold.
    """
    rest = labels == (0 if (labels == 0).any() else labels[0])
    home = np.median(motion.place[rest], axis=0)
    edges_ = np.flatnonzero(np.diff(labels)) + 1
    found: list[Reading] = []
    for first, last in pairwise([0, *(int(edge) for edge in edges_), len(labels)]):
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
        return Reading(first, last - 1, last - 1, AT_EVENT, f"{LABEL} says so", exact=True)
    readings = read_course(part, course, options)
    best = max(readings, key=lambda reading: reading.confidence, default=None)
    if best is None:
        return None
    second = None if best.second is None else (best.second[0] + first, best.second[1] + first)
    return replace(
        best, start=best.start + first, end=best.end + first, hold_end=best.hold_end + first,
        second=second,
    )  # fmt: skip


def _labels(recording: Recording, grid: Array) -> Array | None:
    """Return the label at each time, the last one given; None where it never changes."""
    values = recording.channels.get(LABEL)
    if values is None or not np.isfinite(values).any():
        return None
    known = np.isfinite(values)
    place = np.searchsorted(recording.time[known], grid, side="right") - 1
    labels = values[known][np.maximum(place, 0)]
    return labels if (labels != labels[0]).any() else None


def is_single_reach(motion: Motion, course: Course, options: CutOptions) -> bool:
    """Whether a recording holds one reach and next to nothing before and after it."""
    longest = max((stop.duration for stop in course.stops[1:-1]), default=0.0)
    way = np.linalg.norm(motion.place - motion.place[0], axis=1)
    # Hands creep at the ends of what others have cut, at more than half the speed of a stop.
    share = options.rest_share(palm=motion.palm)
    creep = max(0.5 * share * course.peak, NOISE_FACTOR * motion.floor)
    moving = np.flatnonzero(motion.speed > creep)
    still = max(moving[0], len(motion.speed) - 1 - moving[-1]) / RATE
    return (
        still <= CUT_ALREADY_S
        and longest < options.longest_pause_s
        and float(way[-1]) >= ENDS_AWAY * float(way.max())
    )


def _joined(touched: list[Reading], spoken: list[Reading]) -> list[Reading]:
    """Add to the reaches that touched the object those that did not, which are doubtful."""
    missed = [
        Reading(r.start, r.end, r.hold_end, min(r.confidence, 0.5), "the object did not move")
        for r in spoken
        if not any(r.start < t.end and t.start < r.hold_end for t in touched)
    ]
    return sorted(touched + missed, key=lambda reading: reading.start)


def _channel(recording: Recording, name: str, grid: Array) -> tuple[Array, Mask]:
    if name not in recording.channels:
        raise UnknownNameError("channel", name, tuple(recording.channels))
    values, seen = on_grid(recording.time, recording.channels[name], grid)
    if not seen.any():
        raise InputError(
            f"recording '{recording.name}', channel {name}: holds fewer than 2 values; leave out "
            "--channel to cut by speed"
        )
    return values[:, None], seen


def _object(recording: Recording, grid: Array) -> tuple[Array, Mask] | None:
    if any(name not in recording.channels for name in OBJECT):
        return None
    columns = [on_grid(recording.time, recording.channels[name], grid) for name in OBJECT]
    seen = np.logical_and.reduce([mask for _, mask in columns])
    return (np.column_stack([v for v, _ in columns]), seen) if seen.any() else None


def _reach(name: str, motion: Motion, course: Course, reading: Reading, share: float) -> Reach:
    """Turn frames into times, after putting the ends where this reach's own speed says."""
    start, end = (
        (reading.start, reading.end) if reading.exact else edges(motion, course, reading, share)
    )
    sure, reason = reading.confidence, reading.reason
    if not motion.seen[start : end + 1].all():
        sure, reason = min(sure, 0.5), "the palm was lost on the way"
    if end + 1 - start < MIN_FRAMES:
        sure, reason = min(sure, 0.5), f"it is shorter than {MIN_FRAMES} frames"
    time = motion.time
    second = None
    if reading.second is not None:
        second = (float(time[reading.second[0]]), float(time[reading.second[1]]))
    return Reach(
        name, float(time[start]), float(time[end]), float(time[max(end, reading.hold_end)]),
        round(sure, 3), reason, second,
    )  # fmt: skip

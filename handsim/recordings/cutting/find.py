"""Find the reaches of one recording, by its speed and by what else was recorded."""

from dataclasses import replace

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.cutting.edges import edges
from handsim.recordings.cutting.events import AT_EVENT, SNAP_S, beginnings, least_move, read_events
from handsim.recordings.cutting.label_channel import LABEL, label_steps, read_labels
from handsim.recordings.cutting.motion import Motion, motion_of, on_grid
from handsim.recordings.cutting.reach import CERTAIN, CutOptions, Reach
from handsim.recordings.cutting.readings import Reading, read_course
from handsim.recordings.cutting.single import is_single_reach
from handsim.recordings.cutting.stops import Course, course_of
from handsim.recordings.phases import RATE
from handsim.recordings.recording import MIN_FRAMES, Recording
from handsim.types import Array, Mask

OBJECT = ("object_x_m", "object_y_m", "object_z_m")
WHOLE = "it is a single reach already"
LONGEST_REACH_S = 30.0
WANDERS = 10.0
"""Length of a path over the way it leads from which on it is no reach. Those of four persons who
reached for five things and handled them come to 2 as a rule and to 8 at most."""


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
    labels = label_steps(recording, motion.time) if options.channel in (None, LABEL) else None
    if labels is not None:
        return read_labels(motion, course, labels, options)
    if options.channel is not None:
        values, seen = _channel(recording, options.channel, motion.time)
        events = beginnings(values, seen, least_move(values, position=False))
        return read_events(motion, course, events, f"{options.channel} begins to move", snap=False)
    if is_single_reach(motion, course, options):
        last = len(motion.time) - 1
        return [Reading(0, last, last, AT_EVENT, WHOLE, told="both")]
    spoken = read_course(motion, course, options)
    tracked = _object(recording, motion.time)
    if tracked is not None:
        events = beginnings(*tracked, least_move(tracked[0], position=True))
        if events:
            touched = read_events(motion, course, events, "the object begins to move", snap=True)
            return _joined(touched, spoken)
    return spoken


def _joined(touched: list[Reading], spoken: list[Reading]) -> list[Reading]:
    """Join what the object and what the speed tell.

    An object that first moves while the hand holds it had been grasped when the hold began. Reaches
    that moved no object are doubtful.
    """
    sure = [reading for reading in spoken if reading.confidence >= CERTAIN]
    joined: list[Reading] = []
    for reading in touched:
        slack = 2 * SNAP_S * RATE  # the end has been moved to the stop after the event
        held = (s for s in sure if reading.start < s.end < reading.end <= s.hold_end + slack)
        hold = next(held, reading)
        told = reading.told if hold is reading else "neither"
        joined.append(replace(reading, end=hold.end, hold_end=hold.hold_end, told=told))
    missed = [
        replace(r, confidence=min(r.confidence, 0.5), reason="the object did not move")
        for r in spoken
        if not any(r.start < t.end and t.start < r.hold_end for t in touched)
    ]
    return sorted(joined + missed, key=lambda reading: reading.start)


def _channel(recording: Recording, name: str, grid: Array) -> tuple[Array, Mask]:
    if not recording.channels:
        raise InputError(
            f"recording '{recording.name}' has no channels, so none named '{name}'; leave out "
            "--channel to cut by speed"
        )
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


def _path(motion: Motion, start: int, end: int) -> float:
    """Return the length of a path over its farthest distance from where it starts."""
    way = np.linalg.norm(motion.place[start : end + 1] - motion.place[start], axis=1)
    return float(motion.speed[start : end + 1].sum()) / RATE / max(float(way.max()), 1e-9)


def _reach(name: str, motion: Motion, course: Course, reading: Reading, share: float) -> Reach:
    """Turn frames into times, after putting the ends where this reach's own speed says."""
    start, end = edges(motion, course, reading, share)
    sure, reason = reading.confidence, reading.reason
    if not motion.seen[start : end + 1].all():
        sure, reason = min(sure, 0.5), "the palm was lost on the way"
    if _path(motion, start, end) > WANDERS:
        sure, reason = min(sure, 0.5), "the hand wanders about on the way"
    if end + 1 - start < MIN_FRAMES:
        sure, reason = min(sure, 0.5), f"it is shorter than {MIN_FRAMES} frames"
    time = motion.time
    if time[end] - time[start] > LONGEST_REACH_S:
        sure, reason = min(sure, 0.5), "no reach takes so long; check that times are in seconds"
    second = None
    if reading.second is not None:
        second = (float(time[reading.second[0]]), float(time[reading.second[1]]))
    return Reach(
        name, float(time[start]), float(time[end]), float(time[max(end, reading.hold_end)]),
        round(sure, 3), reason, second,
    )  # fmt: skip

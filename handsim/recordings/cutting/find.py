"""Find the reaches of one recording, by its speed and by what else was recorded."""

from collections.abc import Mapping

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.cutting.events import AT_EVENT, beginnings, least_move, read_events
from handsim.recordings.cutting.motion import Motion, motion_of, on_grid
from handsim.recordings.cutting.reach import CERTAIN, CutOptions, Reach
from handsim.recordings.cutting.readings import Reading, read_course
from handsim.recordings.cutting.stops import NOISE_FACTOR, NOISE_LIMIT, Course, course_of
from handsim.recordings.phases import RATE
from handsim.recordings.recording import MIN_FRAMES, Recording
from handsim.types import Array, Mask

OBJECT = ("object_x_m", "object_y_m", "object_z_m")
LABEL = "label"
WHOLE = "it is a single reach already"
CUT_ALREADY_S = 0.3
"""A recording that stands still no longer than this at its ends has been cut before [s]."""
CLOSE = 0.05
"""Share of the way within which a hand has the posture of a stop."""
ENDS_AWAY = 0.7
"""and it ends at least at this share of its largest distance from where it starts."""


def find_reaches(recording: Recording, options: CutOptions) -> tuple[Reach, ...]:
    """Find the reaches of one recording, in order; certain ones and doubtful ones.

    Raises
    ------
    UnknownNameError
        If the recording has not the channel of the options.
    InputError
        If that channel holds next to no values.
    """
    motion = motion_of(recording.time, recording.q, recording.channels)
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


def is_single_reach(motion: Motion, course: Course, options: CutOptions) -> bool:
    """Whether a recording holds one reach and next to nothing before and after it."""
    first, last = course.stops[0], course.stops[-1]
    longest = max((stop.duration for stop in course.stops[1:-1]), default=0.0)
    way = np.linalg.norm(motion.place - motion.place[0], axis=1)
    return (
        max(first.duration, last.duration) <= CUT_ALREADY_S
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


def edges(motion: Motion, course: Course, reading: Reading, share: float) -> tuple[int, int]:
    """Return first and last frame of a reach, by its own peak speed and by its two postures.

    What else a recording holds, such as returns twice as fast, then does not matter. Ends move
    outwards only while the hand slows down, so that they do not go past a turn; and where fingers
    creep, until the hand is within `CLOSE` of the way from the posture of the stop.
    """
    speed = motion.speed
    start, end = reading.start, reading.end
    peak = float(speed[start : end + 1].max())
    limit = min(max(share * peak, NOISE_FACTOR * motion.floor), NOISE_LIMIT * peak)
    fast = start + np.flatnonzero(speed[start : end + 1] > limit)
    first, last = int(fast[0]), int(fast[-1])
    slow = limit if motion.palm else max(0.5 * share * peak, NOISE_FACTOR * motion.floor)
    while first > 0 and slow < speed[first - 1] <= speed[first]:
        first -= 1
    while last + 1 < len(speed) and slow < speed[last + 1] <= speed[last]:
        last += 1
    if motion.palm:
        return first, last
    return _creep(motion, course, first, last)


def _creep(motion: Motion, course: Course, first: int, last: int) -> tuple[int, int]:
    """Move the ends outwards within the stops, until the hand is nearly at the stop's posture."""
    way = float(np.linalg.norm(motion.place[last] - motion.place[first]))
    for stop in course.stops:
        if stop.first < stop.last and stop.first <= first <= stop.last + 1:
            rest = np.median(motion.place[stop.first : stop.last + 1], axis=0)
            gone = np.linalg.norm(motion.place[stop.first : first + 1] - rest, axis=1)
            near = np.flatnonzero(gone <= CLOSE * way)
            first = stop.first + int(near[-1]) if near.size else first
        elif stop.first < stop.last and stop.first - 1 <= last <= stop.last:
            hold = np.median(motion.place[stop.first : stop.last + 1], axis=0)
            left = np.linalg.norm(motion.place[last : stop.last + 1] - hold, axis=1)
            near = np.flatnonzero(left <= CLOSE * way)
            last += int(near[0]) if near.size else 0
    return first, last


def _reach(name: str, motion: Motion, course: Course, reading: Reading, share: float) -> Reach:
    """Turn frames into times, after putting the ends where this reach's own speed says."""
    start, end = (reading.start, reading.end) if reading.exact else edges(motion, course, reading, share)
    sure, reason = reading.confidence, reading.reason
    if not motion.seen[start : end + 1].all():
        sure, reason = min(sure, 0.5), "the palm was lost on the way"
    if end + 1 - start < MIN_FRAMES:
        sure, reason = min(sure, 0.5), f"it is shorter than {MIN_FRAMES} frames"
    time = motion.time
    second = None if reading.second is None else tuple(float(time[i]) for i in reading.second)
    return Reach(
        name, float(time[start]), float(time[end]), float(time[max(end, reading.hold_end)]),
        round(sure, 3), reason, second,
    )  # fmt: skip

"""Where an object or any other channel begins to move, and the reaches that end there."""

import numpy as np

from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.readings import HOME, SIZE_WIDTH, Reading, logistic
from handsim.recordings.cutting.stops import LARGE, SMALL, Course
from handsim.recordings.phases import RATE
from handsim.types import Array, Mask

QUIET_S = 0.3
"""A channel that has kept its value so long is at rest, and can begin to move again [s]."""
DRIFT_S = 2.0
"""What changes more slowly is drift, not movement [s]."""
NOISE_FACTOR = 6.0
SMALLEST_SHARE = 0.02
"""Smallest movement of a channel, as a share of its range over the recording."""
SMALLEST_MOVE_M = 0.002
"""Smallest movement of an object [m]; marker systems resolve a tenth of it."""
SNAP_S = 0.4
"""A soft object moves when it is touched, while the hand still slows down: the reach ends at the
stop that comes within this time."""
SAME_KIND = 0.25
AT_EVENT = 0.95
"""Confidence in a reach whose end a channel tells."""


def beginnings(values: Array, seen: Mask, least: float) -> list[int]:
    """Return the frames at which a channel leaves a value that it has kept.

    Parameters
    ----------
    values : (n, d), at 100 Hz
    seen : (n,)
        Where the channel was recorded; nothing begins elsewhere.
    least
        Smallest distance from the kept value that is a movement, in the unit of the channel.

    Returns
    -------
    list
        Without those whose whole movement is under a quarter of the largest: a handle that was
        turned and trembles has not begun to move again.
    """
    noise = _noise(values[seen])
    least = max(least, NOISE_FACTOR * noise)
    width = round(QUIET_S * RATE)
    found: list[int] = []
    gone: list[float] = []
    base, quiet = values[0], True
    for frame in range(1, len(values)):
        away = float(np.linalg.norm(values[frame] - base))
        if not quiet:
            gone[-1:] = [max(gone[-1], away)] if gone else []
        if not seen[frame]:
            quiet = False
        elif quiet and away > least:
            found.append(_begin(values, frame, base, least))
            gone.append(away)
            quiet = False
        elif quiet:
            base = base + (values[frame] - base) / (DRIFT_S * RATE)
        elif frame >= width and seen[frame - width : frame].all():
            recent = values[frame - width : frame + 1]
            if float(np.linalg.norm(np.ptp(recent, axis=0))) < least:
                quiet, base = True, recent.mean(axis=0)
    return [f for f, way in zip(found, gone, strict=True) if way >= SAME_KIND * max(gone)]


def _noise(values: Array) -> float:
    """Return the standard deviation of white noise that explains the steps of a channel."""
    if len(values) < 2:
        return 0.0
    steps = np.diff(values, axis=0)
    spread = 1.4826 * np.median(np.abs(steps - np.median(steps, axis=0)), axis=0)
    return float(np.linalg.norm(spread)) / np.sqrt(2)


def _begin(values: Array, frame: int, base: Array, least: float) -> int:
    """Go back from where a movement is beyond doubt to its first half."""
    while frame > 0 and np.linalg.norm(values[frame - 1] - base) > 0.5 * least:
        frame -= 1
    return frame


def least_move(values: Array, *, position: bool) -> float:
    """Return the smallest change of a channel, (n, d), that is a movement."""
    reach = float(np.linalg.norm(np.ptp(values, axis=0)))
    return max(SMALLEST_SHARE * reach, SMALLEST_MOVE_M if position else 0.0)


def read_events(
    motion: Motion, course: Course, events: list[int], reason: str, *, snap: bool
) -> list[Reading]:
    """Return the reaches that end where a channel begins to move.

    A reach begins at the last stop far from where it ends, since the last time the channel began to
    move. Beginnings between which the hand stays where it is belong to one reach, and so do those
    of a channel between which it does not come back to where the reach before began.

    Parameters
    ----------
    motion, course
    events
        Frames, increasing.
    reason
        What decided, as in `Reach`.
    snap
        Whether the end is the stop that comes right after the event, if one does.
    """
    found: list[Reading] = []
    before = 0  # frame of the last event that ended a reach
    for event in events:
        way = np.linalg.norm(motion.place[before : event + 1] - motion.place[event], axis=1)
        farthest = float(way.max())
        least = LARGE if snap else SMALL
        if farthest < least * course.size:
            continue
        stops = [stop for stop in course.stops if before <= stop.last < event]
        far = [stop.last for stop in stops if way[stop.last - before] > HOME * farthest]
        if found and not far:
            continue
        start = far[-1] if far else before
        home = motion.place[found[-1].start if found else start]
        if not snap and np.linalg.norm(motion.place[start] - home) > HOME * farthest:
            continue
        before = event
        sure = AT_EVENT * logistic((farthest / course.size - least) / SIZE_WIDTH + 2)
        end = _stop_after(course, event) if snap else event
        told = "end" if end == event else "neither"
        found.append(Reading(start, end, _hold_end(course, end), sure, reason, told=told))
    return found


def _stop_after(course: Course, event: int) -> int:
    """Return where the hand stops soon after an event, or the event where it stood or goes on."""
    for stop in course.stops[1:]:
        if stop.first <= event <= stop.last:
            return stop.first
        if event < stop.first <= event + SNAP_S * RATE:
            return stop.first
    return event


def _hold_end(course: Course, end: int) -> int:
    """Return the last frame of the stop that the hand is in or comes to next."""
    return next((stop.last for stop in course.stops[1:] if stop.last >= end), end)

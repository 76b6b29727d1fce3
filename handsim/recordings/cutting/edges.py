"""Where exactly a reach begins and ends, once it is known between which stops it lies."""

import numpy as np

from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.readings import Reading
from handsim.recordings.cutting.stops import NOISE_FACTOR, NOISE_LIMIT, Course

CLOSE = 0.03
"""Share of the way within which a hand has the posture of a stop."""


def edges(motion: Motion, course: Course, reading: Reading, share: float) -> tuple[int, int]:
    """Return first and last frame of a reach, by its own peak speed and by its two postures.

    What else a recording holds, such as returns twice as fast, then does not matter. Ends move
    outwards only while the hand slows down, so that they do not go past a turn; and where fingers
    creep, until the hand is within `CLOSE` of the way from the posture of the stop.
    """
    if reading.told == "both":
        return reading.start, reading.end
    first, last = _by_speed(motion, reading, share)
    if not motion.palm:
        first, last = _creep(motion, course, first, last)
    return first, reading.end if reading.told == "end" else last


def _by_speed(motion: Motion, reading: Reading, share: float) -> tuple[int, int]:
    speed = motion.speed
    start, end = reading.start, reading.end
    peak = float(speed[start : end + 1].max())
    limit = min(max(share * peak, NOISE_FACTOR * motion.floor), NOISE_LIMIT * peak)
    fast = start + np.flatnonzero(speed[start : end + 1] > limit)
    if not fast.size:  # it stands still throughout
        return start, end
    first, last = int(fast[0]), int(fast[-1])
    slow = limit if motion.palm else max(0.5 * share * peak, NOISE_FACTOR * motion.floor)
    while first > 0 and slow < speed[first - 1] <= speed[first]:
        first -= 1
    while last + 1 < len(speed) and slow < speed[last + 1] <= speed[last]:
        last += 1
    return first, last


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

"""Which way from stop to stop is a reach: by how far from rest the hand stands, and how long.

A hand that leaves its rest and comes back has made an excursion. Within it, the reach ends at the
first stop at which the hand is nearly as far from rest as it gets; stops before that are pauses.
A pause that lasts as long as a hold may be one: the grasp was there, and what followed was done
with the object. Each such doubt gives a probability, and their product is the confidence.
"""

import math
from dataclasses import dataclass

import numpy as np

from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.cutting.stops import LARGE, Course
from handsim.recordings.phases import RATE

ARRIVED = 0.85
"""A stop at this share of the farthest one's distance from rest is an arrival, not a pause."""
HOME = 0.5
"""A hand that is back at less than this share of the way is at rest again."""
HOME_WIDTH = 0.06
SIZE_WIDTH = 0.05
PAUSE_STEEPNESS = 2.0
"""A pause of half the permitted length is one with a probability of 0.8, a quarter with 0.94."""
SHORTEST_HOLD_S = 0.2
"""With joints alone, a hand that opens and closes at once may have grasped at the second stop."""


@dataclass(frozen=True)
class Reading:
    """One reach by frames, and what speaks for it.

    Attributes
    ----------
    start, end, hold_end, confidence, reason, second
        As in `Reach`, with frames for times.
    exact
        Whether both ends are told otherwise than by speed.
    """

    start: int
    end: int
    hold_end: int
    confidence: float
    reason: str
    second: tuple[int, int] | None = None
    exact: bool = False


def read_course(motion: Motion, course: Course, options: CutOptions) -> list[Reading]:
    """Find the reaches among the movements of a recording, which begins at rest."""
    excursions = _excursions(motion, course)
    sizes = [max(e.distances) for e in excursions]
    if not sizes:
        return []
    usual = float(np.median([s for s in sizes if s > LARGE * max(sizes)]))
    readings: list[Reading] = []
    home_sure = 1.0
    for excursion, size in zip(excursions, sizes, strict=True):
        large = logistic((size / usual - 0.4) / SIZE_WIDTH)
        if large >= 0.3:
            reading = _reading(motion, course, excursion, options)
            readings.append(_weighed(reading, large, home_sure))
        home_sure = excursion.home_sure
    return readings


@dataclass(frozen=True)
class _Excursion:
    """Stops away from rest: places of the first and last stop, both at rest unless it ends away.

    ``distances`` are those of the stops after the first from the first; ``returned`` is whether the
    last one is at rest, with the probability ``home_sure``.
    """

    first: int
    last: int
    distances: tuple[float, ...]
    returned: bool
    home_sure: float


def _excursions(motion: Motion, course: Course) -> list[_Excursion]:
    stops = course.stops
    found: list[_Excursion] = []
    home, distances = 0, list[float]()
    for place in range(1, len(stops)):
        way = motion.place[stops[place].first] - motion.place[stops[home].last]
        distances.append(float(np.linalg.norm(way)))
        share = distances[-1] / max(distances)
        if share < HOME:
            sure = logistic((HOME - share) / HOME_WIDTH)
            found.append(_Excursion(home, place, tuple(distances), True, sure))
            home, distances = place, []
    if distances:
        found.append(_Excursion(home, len(stops) - 1, tuple(distances), False, 1.0))
    return found


def _reading(
    motion: Motion, course: Course, excursion: _Excursion, options: CutOptions
) -> Reading:
    """Say where the reach of one excursion ends."""
    stops = course.stops
    away = range(excursion.first + 1, excursion.last + (not excursion.returned))
    distance = dict(zip(range(excursion.first + 1, excursion.last + 1), excursion.distances))
    farthest = max(distance[place] for place in away)
    arrival = next(place for place in away if distance[place] >= ARRIVED * farthest)
    hold = max(stops[place].duration for place in away if place >= arrival)
    leave = next((p for p in range(arrival, away.stop) if _left(p, away, distance)), away.stop - 1)
    start, leave_frame = stops[excursion.first].last, stops[leave].last
    sure, second, reason = 1.0, None, "the hand stops at its farthest from rest"
    for place in range(away.start, arrival):
        stop = stops[place]
        share = pause_probability(stop.duration, hold, distance[place] / farthest, options)
        other = (start, stop.first)
        if share < 0.5:
            reason = f"the hand stops for {stop.duration:.2f} s on the way, too long for a pause"
            second = (start, stops[arrival].first)
            return Reading(start, stop.first, stop.last, sure * (1 - share), reason, second)
        if share < sure:
            reason, second = f"the hand pauses for {stop.duration:.2f} s on the way", other
        sure *= share
    return Reading(start, stops[arrival].first, leave_frame, sure, reason, second)


def _left(place: int, away: range, distance: dict[int, float]) -> bool:
    """Whether the movement after a stop goes back towards rest."""
    return place + 1 not in away or distance[place + 1] < ARRIVED * distance[place]


def pause_probability(pause: float, hold: float, share: float, options: CutOptions) -> float:
    """Return the probability that a stop on the way is a pause, and not the grasp.

    Parameters
    ----------
    pause, hold
        How long the hand stops there, and where it gets to afterwards [s].
    share
        Distance from rest at the stop over that of the hold.
    """
    tick = 1 / RATE
    shorter = math.log(options.longest_pause_s / max(pause, tick))
    against_hold = math.log(max(hold, tick) / max(pause, tick))
    score = shorter if shorter > 0 else 0.5 * shorter + 0.7 * min(max(against_hold, -1.5), 1.5)
    return logistic(PAUSE_STEEPNESS * score)


def _weighed(reading: Reading, large: float, home_sure: float) -> Reading:
    doubts = (
        (large, "the movement is small beside the others"),
        (home_sure, "the hand had only half returned before"),
    )
    least, reason = min(doubts)
    return Reading(
        reading.start, reading.end, reading.hold_end, reading.confidence * large * home_sure,
        reason if least < min(0.9, reading.confidence) else reading.reason, reading.second,
    )  # fmt: skip


def logistic(score: float) -> float:
    """Return the probability of a log-odds score."""
    return 1 / (1 + math.exp(-min(max(score, -50.0), 50.0)))

"""Which way from stop to stop is a reach: by how far from rest the hand stands, and how long.

A hand that leaves its rest and comes back has made an excursion. Within it, the reach ends at the
first stop at which the hand is nearly as far from rest as it gets; stops before that are pauses.
A pause that lasts as long as a hold may be one: the grasp was there, and what followed was done
with the object. Each such doubt gives a probability, and their product is the confidence.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.cutting.stops import LARGE, Course, Stop
from handsim.recordings.phases import RATE

ARRIVED = 0.85
"""A stop at this share of the farthest one's distance from rest is an arrival, not a pause."""
ARRIVED_DOUBT = 0.3
SLOW = 0.3
"""A hand slower than this share of its peak has slowed down, as hands do that take hold."""
BUSY = 0.75
"""Confidence where a hand slows down at its farthest and is busy there before it stands still."""
HOME = 0.5
"""A hand that is back at less than this share of the way is at rest again."""
HOME_WIDTH = 0.06
SIZE_WIDTH = 0.05
PAUSE_STEEPNESS = 2.0
"""How fast doubt falls with the logarithm of the length of a pause. One of half the permitted
length is a pause with a probability of 0.8, of a quarter with 0.94, before what follows is weighed.
On streams made of two persons' trials no reach of confidence `CERTAIN` and more then ended
wrongly."""
TINY = 1e-12
SHORTEST_HOLD_S = 0.2
"""Without a palm, a hand that goes and comes back without so long a stop [s] may have reached, or
opened and closed around something near its posture of rest."""


@dataclass(frozen=True)
class Reading:
    """One reach by frames, and what speaks for it.

    Attributes
    ----------
    start, end, hold_end, confidence, reason, second
        As in `Reach`, with frames for times.
    told
        Which ends are told otherwise than by speed, and are not moved to where it is low.
    """

    start: int
    end: int
    hold_end: int
    confidence: float
    reason: str
    second: tuple[int, int] | None = None
    told: Literal["neither", "end", "both"] = "neither"


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
        distances.append(_distance(motion, stops[home], stops[place]))
        share = distances[-1] / max(*distances, TINY)
        if share < HOME and not _still_nearing(motion, stops[home], stops[place : place + 2]):
            sure = logistic((HOME - share) / HOME_WIDTH)
            if place > home + 1:  # else it came back to the very same place at once
                found.append(_Excursion(home, place, tuple(distances), True, sure))
            home, distances = place, []
    if distances and max(distances) > TINY:
        found.append(_Excursion(home, len(stops) - 1, tuple(distances), False, 1.0))
    return found


def _distance(motion: Motion, home: Stop, stop: Stop) -> float:
    return float(np.linalg.norm(motion.place[stop.first] - motion.place[home.last]))


def _still_nearing(motion: Motion, home: Stop, stops: Sequence[Stop]) -> bool:
    """Whether the next of two stops is nearer to home by half: a return may pause, too."""
    ways = [_distance(motion, home, stop) for stop in stops]
    return len(ways) == 2 and ways[1] < 0.5 * ways[0]


def _reading(motion: Motion, course: Course, excursion: _Excursion, options: CutOptions) -> Reading:
    """Say where the reach of one excursion ends: at the first stop that is no pause."""
    stops = course.stops
    home = stops[excursion.first]
    away = range(excursion.first + 1, excursion.last + (not excursion.returned))
    distance = dict(enumerate(excursion.distances, start=excursion.first + 1))
    farthest = max(distance[place] for place in away)
    leave, sure = _held(stops, away, distance, farthest)
    hold = stops[leave].duration
    second, reason = None, "the hand stops at its farthest from rest"
    if sure < 0.9:
        reason = "the hand stops twice as if it held something"
        other = next(p for p in reversed(away) if p != leave)
        second = (home.last, stops[other].first)
    if not motion.palm and excursion.returned and hold < SHORTEST_HOLD_S:
        sure, second = 0.5, (home.last, stops[excursion.last].first)
        reason = "the hand comes back without a stop; it may have opened and closed"
    for place in range(away.start, leave):
        stop = stops[place]
        onward = _onward(motion, home, stop, stops[leave])
        arrived = distance[place] >= ARRIVED * farthest
        share = pause_probability(stop.duration, hold, onward, options, arrived=arrived)
        if share < 0.5:
            reason = f"the hand stops for {stop.duration:.2f} s and moves on"
            second = (home.last, stops[place + 1].first)
            return Reading(home.last, stop.first, stop.last, sure * (1 - share), reason, second)
        if share < sure:
            reason = f"the hand pauses for {stop.duration:.2f} s on the way"
            second = (home.last, stop.first)
        sure *= share
    last = stops[leave].first
    slow = _slows_down(motion, home.last, last)
    if slow is not None and sure > BUSY and (last - slow) / RATE > options.longest_pause_s:
        sure, second = BUSY, (home.last, slow)
        reason = f"the hand slows down {(last - slow) / RATE:.2f} s before it stands still"
    return Reading(home.last, last, stops[leave].last, sure, reason, second)


def _slows_down(motion: Motion, start: int, end: int) -> int | None:
    """Return the first frame at which a hand that has arrived slows down without stopping.

    What it does from there on until it stops may be done with the object.
    """
    way = np.linalg.norm(motion.place[start : end + 1] - motion.place[start], axis=1)
    speed = motion.speed[start : end + 1]
    arrived = int(np.argmax(way >= ARRIVED * way[-1]))
    slow = SLOW * float(speed.max())
    under = np.flatnonzero(speed[arrived:] < slow)
    if not under.size:
        return None
    first = arrived + int(under[0])
    again = np.flatnonzero(speed[first:] > slow)
    return start + first if again.size else None


def _held(
    stops: tuple[Stop, ...], away: range, distance: dict[int, float], farthest: float
) -> tuple[int, float]:
    """Return the place of the stop before the return, and how sure it is that it is the hold.

    It is the last one that is as far from rest as the hand gets. A hand that opens wide and closes
    is nearer to rest afterwards, and so is one that pauses on its return: the longer stop wins.
    """
    leave = next(p for p in reversed(away) if distance[p] >= ARRIVED * farthest)
    hold = max(stops[p].duration for p in away if distance[p] >= ARRIVED * farthest)
    later = range(leave + 1, away.stop)
    if not later:
        return leave, 1.0
    longest = max(later, key=lambda place: stops[place].duration)
    tick = 1 / RATE
    beside = math.log(max(stops[longest].duration, tick) / max(hold, tick))
    share = logistic(PAUSE_STEEPNESS * beside)
    return (longest, share) if share > 0.5 else (leave, 1 - share)


def pause_probability(
    pause: float, hold: float, onward: float, options: CutOptions, *, arrived: bool
) -> float:
    """Return the probability that a stop on the way is a pause, and not the grasp.

    Parameters
    ----------
    pause, hold
        How long the hand stops there, and where it gets to afterwards [s].
    onward
        Share of the whole way that it then goes on in the same direction, 0 to 1. Fingers that hold
        something do not go on closing.
    arrived
        Whether the stop is as far from rest as that of the hold: then the grasp may have been, and
        what follows is done with the object.
    """
    tick = 1 / RATE
    permitted = math.log(options.longest_pause_s / max(pause, tick))
    beside_hold = math.log(max(hold, tick) / max(pause, tick))
    score = (
        (permitted if permitted > 0 else 0.5 * permitted)
        + 0.5 * min(max(beside_hold, -1.5), 1.5)
        + 0.8 * onward
        - ARRIVED_DOUBT * arrived
    )
    return logistic(PAUSE_STEEPNESS * score)


def _onward(motion: Motion, home: Stop, stop: Stop, arrival: Stop) -> float:
    """Return the share of the way from rest to arrival that lies beyond a stop."""
    whole = motion.place[arrival.first] - motion.place[home.last]
    beyond = motion.place[arrival.first] - motion.place[stop.first]
    return min(max(float(whole @ beyond / max(float(whole @ whole), 1e-12)), 0.0), 1.0)


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

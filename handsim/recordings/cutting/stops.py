"""Where a hand stands still, and where it turns round without standing still."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handsim.recordings.cutting.motion import MIN_TRAVEL, MIN_TURN, Motion
from handsim.recordings.phases import RATE
from handsim.types import Array, Mask

SHORTEST_STOP_S = 0.05
"""Shorter slow spells are noise about the threshold [s]."""
SMALL = 0.1
"""Movements under this share of a whole reach are fidgets; the hand counts as standing still."""
LARGE = 0.3
"""Movements above this share of the largest one are counted as whole reaches or returns."""
TURNED = 0.4
"""A hand has turned round when it is back at less than this share of the way it had gone."""
NOISE_FACTOR = 2.0
"""The threshold of standing still lies at least so far above the speed of the quietest moment."""
NOISE_LIMIT = 0.5
"""but never above this share of the usual peak, where everything would stand still."""


@dataclass(frozen=True)
class Stop:
    """Frames in which the hand stands still, both included; one frame where it only turns."""

    first: int
    last: int

    @property
    def duration(self) -> float:
        """How long the hand stands still [s]."""
        return (self.last - self.first) / RATE


@dataclass(frozen=True)
class Course:
    """A recording as stops with movements between them.

    Attributes
    ----------
    stops
        In order. The first begins at the first frame and the last ends at the last one; either is
        of one frame where the hand moves there.
    peak
        Usual peak speed of a movement [m/s or rad/s].
    size
        Usual distance covered by one [m or rad].
    """

    stops: tuple[Stop, ...]
    peak: float
    size: float


def course_of(motion: Motion, rest_speed: float) -> Course | None:
    """Split a recording into stops and movements; None where the hand never moves.

    Parameters
    ----------
    rest_speed
        Share of the usual peak speed under which a hand stands still.
    """
    fastest = float(motion.speed.max())
    if fastest == 0.0:
        return None
    # A fast return has several times the speed of a reach, hence half the share of the maximum in
    # the first round. The second takes the usual peak, which one odd movement does not move.
    runs = _moving(motion.speed, max(0.5 * rest_speed * fastest, NOISE_FACTOR * motion.floor))
    if not runs:
        return None
    farthest = max(_reached(motion, run) for run in runs)
    peak, size = _usual(motion, _split(motion, runs, LARGE * farthest))
    limit = min(max(rest_speed * peak, NOISE_FACTOR * motion.floor), NOISE_LIMIT * peak)
    moves = _split(motion, _moving(motion.speed, limit), LARGE * size)
    if size < (MIN_TRAVEL if motion.palm else MIN_TURN):
        return None
    moves = [move for move in moves if _reached(motion, move) > SMALL * size]
    return Course(_between(moves, len(motion.speed)), peak, size) if moves else None


def _moving(speed: Array, limit: float) -> list[tuple[int, int]]:
    """Return first and last frame of every run above ``limit`` that somewhere is twice as fast."""
    runs = _runs(speed > limit)
    joined: list[tuple[int, int]] = []
    for first, last in runs:
        if joined and first - joined[-1][1] <= SHORTEST_STOP_S * RATE:
            joined[-1] = (joined[-1][0], last)
        else:
            joined.append((first, last))
    return [(a, b) for a, b in joined if speed[a : b + 1].max() > 2 * limit]


def _runs(mask: Mask) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _reached(motion: Motion, move: tuple[int, int]) -> float:
    first, last = move
    way = np.linalg.norm(motion.place[first : last + 1] - motion.place[first], axis=1)
    return float(way.max())


def _usual(motion: Motion, moves: list[tuple[int, int]]) -> tuple[float, float]:
    """Return the medians of peak speed and distance over the large movements."""
    sizes = np.array([_reached(motion, move) for move in moves])
    peaks = np.array([motion.speed[a : b + 1].max() for a, b in moves])
    large = sizes >= LARGE * sizes.max()
    return float(np.median(peaks[large])), float(np.median(sizes[large]))


def _split(motion: Motion, runs: list[tuple[int, int]], least: float) -> list[tuple[int, int]]:
    """Split runs of movement where the hand turns round after going at least so far."""
    moves: list[tuple[int, int]] = []
    for first, last in runs:
        turns = _turns(motion.place[first : last + 1], least)
        moves += pairwise([first, *(first + turn for turn in turns), last])
    return moves


def _turns(place: Array, least: float) -> list[int]:
    """Return the frames at which a movement is farthest before it comes back."""
    turns: list[int] = []
    pivot = 0
    while True:
        way = np.linalg.norm(place[pivot:] - place[pivot], axis=1)
        farthest = np.maximum.accumulate(way)
        back = np.flatnonzero((way < TURNED * farthest) & (farthest > least))
        if not back.size:
            return turns
        pivot += int(np.argmax(way[: int(back[0]) + 1]))
        turns.append(pivot)


def _between(moves: list[tuple[int, int]], n_frames: int) -> tuple[Stop, ...]:
    edges = [0, *(frame for move in moves for frame in move), n_frames - 1]
    return tuple(Stop(a, max(a, b)) for a, b in zip(edges[::2], edges[1::2], strict=True))

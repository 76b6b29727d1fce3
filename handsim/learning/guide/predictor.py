"""The path, and its timing, that a person would likely choose for a query.

Gaussian-process regression on the recordings. What is predicted is how a path departs from the
straight segment between its ends, at equal steps of arc length; it is zero at both ends whatever is
predicted. Likewise, for the timing, how the covered fraction of the length departs from the
minimum-jerk profile. Two movements are alike as far as their starts, their destinations and their
objects are, timings as far as their durations are, too:

    K = exp(-|a - a'|^2 / (2 r_a^2) - |b - b'|^2 / (2 r_b^2)) likeness + common + linear

with starts a and destinations b; ``common`` is what all movements share, ``linear`` a scalar
product of (a, b). An object that is not known is averaged over, weighted by how near recorded
destinations are.

Lengths are relative to the spread of the recordings' ends, so that any person's recordings, and
other data, can be learned. `GuideSettings` were chosen on four people, each recording left out; the
optimum is flat (tests/benchmarks/README.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handsim.errors import InputError
from handsim.learning.demonstration import Demonstration
from handsim.learning.guide.chord import across, graphs
from handsim.learning.guide.gaussian_process import (
    left_out_means,
    predicted,
    regression_weights,
    shifted_products,
)
from handsim.learning.guide.likeness import Grasped, Likeness
from handsim.learning.movement.progress import N_PROGRESS, minimum_jerk
from handsim.navigation.paths import N_COMPARED, at_arc_length
from handsim.reproducible import dots, exp, log, spread, total
from handsim.types import Array

_N_SMOOTH = 16  # control points of a law of progress: what is finer is one person's chance
_MOST = 1000  # recordings asked; of more, every second, third ... is
_SHORT = 0.2  # of the mean distance: a shorter chord bends less, so that the field stays smooth
_LEAST_SPREAD = 0.05  # of the mean distance from start to destination, where all ends agree


@dataclass(frozen=True)
class GuideSettings:
    """How far recordings tell of others; distances relative to the spread of their ends.

    Attributes
    ----------
    start, goal
        r_a and r_b for paths.
    guess
        Distance of destinations over which an unknown object is guessed.
    other
        Likeness of different objects.
    common, linear, noise
        Variances relative to that of the kernel.
    time_start, time_goal, time_other, time_common, time_noise
        The same for timings.
    time_duration
        Difference of ln(duration) over which timings are alike.
    pull
        How much faster than along the guide the flow goes towards it (`learning.guide.field`).
    progress
        Whether progress is a coordinate of the field; if not, the place tells it
        (`learning.guide.chord_field`), and paths are graphs over their chord.
    """

    start: float = 1.0
    goal: float = 0.5
    guess: float = 0.2
    other: float = 0.15
    common: float = 0.3
    linear: float = 0.1
    noise: float = 0.25
    time_start: float = 0.5
    time_goal: float = 1.5
    time_other: float = 0.3
    time_common: float = 0.3
    time_noise: float = 0.4
    time_duration: float = 0.3
    pull: float = 2.0
    progress: bool = True


@dataclass(frozen=True, eq=False)
class PathPredictor:
    """Predicts paths and timings from demonstrations.

    Parameters
    ----------
    paths : (N, 100, n) [rad]
        Equally spaced in arc length.
    progress : (N, 51)
        Covered fractions at equal steps of time.
    durations : (N,) [s]
    objects
        How alike the objects are, for paths and for timings.
    settings
    """

    paths: Array
    progress: Array
    durations: Array
    objects: tuple[Likeness, Likeness]
    settings: GuideSettings

    @classmethod
    def of(
        cls, demonstrations: Sequence[Demonstration], settings: GuideSettings
    ) -> "PathPredictor":
        """Return the predictor of demonstrations, which must hold their paths."""
        asked = demonstrations[:: -(-len(demonstrations) // _MOST)]
        if not asked or any(d.path is None or d.progress is None for d in asked):
            raise InputError(
                "demonstrations without paths cannot guide; learn the recordings again"
            )
        names = [d.object for d in asked]
        numbers = [d.numbers for d in asked]
        return cls(
            np.array([d.path for d in asked]),
            np.array([d.progress for d in asked]),
            np.array([d.duration for d in asked]),
            (
                Likeness.of(names, numbers, settings.other),
                Likeness.of(names, numbers, settings.time_other),
            ),
            settings,
        )

    def path(self, start: Array, goal: Array, grasped: Grasped | None = None) -> Array:
        """Return the likely path (100, n) [rad] from a start to a destination, both (n,).

        It is equally spaced in arc length, or along its chord if progress is no coordinate, and
        begins and ends exactly there.
        """
        s = self.settings
        likeness = self.objects[0].to(grasped, self._nearness(goal))
        shares = self._near(start, goal, s.start, s.goal) * likeness + s.common
        shares += s.linear * self._linear(np.concatenate([start, goal])[None])[0]
        departure = predicted(shares, self._path_weights).reshape(N_COMPARED, -1)
        path = self._led(start, goal, departure)
        return at_arc_length(path, _FRACTIONS) if s.progress else path

    def covered(
        self, start: Array, goal: Array, duration: float, grasped: Grasped | None = None
    ) -> Array:
        """Return the control points (16,) of the likely progress, at equal steps of time."""
        s = self.settings
        likeness = self.objects[1].to(grasped, self._nearness(goal))
        apart = (log(np.array([duration])) - log(self.durations)) / s.time_duration
        shares = self._near(start, goal, s.time_start, s.time_goal) * exp(-0.5 * apart * apart)
        shares = shares * likeness + s.time_common
        covered = _SMOOTH + predicted(shares, self._time_weights)
        covered = np.maximum.accumulate(np.clip(covered, 0.0, 1.0))
        covered[0], covered[-1] = 0.0, 1.0
        return np.interp(np.linspace(0.0, 1.0, _N_SMOOTH), _TIMES, covered)

    def left_out(self) -> Array:
        """Return the paths (N, 100, n) predicted of the recordings, each from all others."""
        departures = self._departures
        flat = departures.reshape(len(departures), -1)
        means = left_out_means(self._path_kernel, self.settings.noise, flat)
        each = zip(self._starts, self._goals, means.reshape(departures.shape), strict=True)
        return np.array([self._led(*ends_and_departure) for ends_and_departure in each])

    def _led(self, start: Array, goal: Array, departure: Array) -> Array:
        """Return the path (100, n) that departs from its segment by (100, n)."""
        if not self.settings.progress:
            chord = goal - start
            short = float(np.sqrt(dots(chord, chord))) / (_SHORT * self._distance)
            departure = min(short, 1.0) * across(departure, chord)
        path = _segments(start[None], goal[None])[0] + departure
        path[0], path[-1] = start, goal
        return path

    @cached_property
    def _starts(self) -> Array:
        return self.paths[:, 0]

    @cached_property
    def _goals(self) -> Array:
        return self.paths[:, -1]

    @cached_property
    def _ends(self) -> Array:
        return np.hstack([self._starts, self._goals])

    @cached_property
    def _distance(self) -> float:
        away = self._goals - self._starts
        distance = float(np.sqrt(total(dots(away, away)) / len(away)))
        return max(distance, np.finfo(float).tiny)

    @cached_property
    def _spread(self) -> float:
        return max(spread(self._ends), _LEAST_SPREAD * self._distance, np.finfo(float).tiny)

    @cached_property
    def _path_kernel(self) -> Array:
        s = self.settings
        kernel = self._near(self._starts, self._goals, s.start, s.goal) * self.objects[0].among
        return kernel + (s.common + s.linear * self._linear(self._ends))

    @cached_property
    def _departures(self) -> Array:
        if self.settings.progress:
            return self.paths - _segments(self._starts, self._goals)
        return graphs(self.paths)

    @cached_property
    def _path_weights(self) -> Array:
        flat = self._departures.reshape(len(self.paths), -1)
        return regression_weights(self._path_kernel, self.settings.noise, flat)

    @cached_property
    def _time_weights(self) -> Array:
        s = self.settings
        lasting = log(self.durations)
        apart = (lasting[:, None] - lasting) / s.time_duration
        kernel = self._near(self._starts, self._goals, s.time_start, s.time_goal)
        kernel = kernel * exp(-0.5 * apart * apart) * self.objects[1].among + s.time_common
        return regression_weights(kernel, s.time_noise, self.progress - _SMOOTH)

    def _near(self, start: Array, goal: Array, by_start: float, by_goal: float) -> Array:
        """Kernel (..., N) of starts and destinations (..., n)."""
        a = (start[..., None, :] - self._starts) / (by_start * self._spread)
        b = (goal[..., None, :] - self._goals) / (by_goal * self._spread)
        return exp(-0.5 * (dots(a, a) + dots(b, b)))

    def _nearness(self, goal: Array) -> Array:
        away = (goal - self._goals) / (self.settings.guess * self._spread)
        return exp(-0.5 * dots(away, away))

    def _linear(self, ends: Array) -> Array:
        middle = total(self._ends) / len(self._ends)
        return shifted_products(ends, self._ends, middle, self._spread)


_FRACTIONS = np.linspace(0.0, 1.0, N_COMPARED)
_TIMES = np.linspace(0.0, 1.0, N_PROGRESS)
_SMOOTH = minimum_jerk(_TIMES, 1.0)


def _segments(starts: Array, goals: Array) -> Array:
    """Return the straight segments (N, 100, n) between ends (N, n)."""
    return starts[:, None] + _FRACTIONS[:, None] * (goals - starts)[:, None]

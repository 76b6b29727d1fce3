"""Progress that follows a signal, value by value.

Ahead it goes at once, but no faster than people do at the pace of this movement, by a factor. It
goes back only when the signal has gone back by more than the map's slack (hysteresis), as far as
the signal lets it, at the same speed. While the signal is missing it is held.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handsim.driving.signal_map import PHASES, SignalMap
from handsim.errors import InputError
from handsim.recordings.signals import low_passed
from handsim.types import Array

_AT_START = 1e-3
"""Phase below which the movement has not begun: a smoothed signal never quite returns."""


class DriverState(NamedTuple):
    """Where a driver stands.

    Attributes
    ----------
    phase
        0 to 1.
    value
        Of the signal, smoothed; None before the first.
    start
        Its value at the start of the movement.
    unseen
        Time since the last value [s].
    elapsed
        Time since the movement began [s].
    passed
        Number of levels of the pace to which the signal has come.
    duration
        Likely duration of the movement [s]; None if nothing is told of it yet.
    """

    phase: float = 0.0
    value: float | None = None
    start: float = 0.0
    unseen: float = 0.0
    elapsed: float = 0.0
    passed: int = 0
    duration: float | None = None


@dataclass(frozen=True, eq=False)
class DriverRule:
    """How progress follows a signal: a pure function of state and value.

    Attributes
    ----------
    map
    smoothing
        Time constant of the low-pass of the signal [s]; 0 takes it as it is.
    speed
        Greatest speed, relative to that of people at the pace of the movement.
    curve : (101,)
        Progress at equally spaced phases; by default the mean of people.
    """

    map: SignalMap
    smoothing: float = 0.04
    speed: float = 1.15
    curve: Array | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        for name, value, least in (("smoothing", self.smoothing, 0.0), ("speed", self.speed, 1e-3)):
            if not least <= value <= 1e3:
                raise InputError(f"{name} {value:g}; give a number from {least:g} to 1000")
        if self.curve is not None and np.shape(self.curve) != PHASES.shape:
            raise InputError(f"curve of shape {np.shape(self.curve)}; give {len(PHASES)} numbers")

    def progress(self, state: DriverState) -> float:
        """Return progress along the path, 0 to 1."""
        curve = self.map.curve if self.curve is None else self.curve
        return float(np.interp(state.phase, PHASES, curve))

    def after(self, state: DriverState, value: float, dt: float) -> DriverState:
        """Return the state ``dt`` [s] later, when the signal is ``value``; NaN if it is missing."""
        if not (np.isfinite(dt) and dt >= 0):
            raise InputError(f"time step {dt:g} s; give a number of seconds that is not negative")
        if not np.isfinite(value):
            return state._replace(unseen=state.unseen + dt)
        since = dt + state.unseen
        if state.value is None:
            smooth, start = float(value), float(value)
        else:
            smooth = low_passed(state.value, value, since, self.smoothing)
            # Whoever moves away before the movement begins has a new start.
            start = max(state.start, smooth) if state.phase < _AT_START else state.start
        level = self.map.level(smooth, start)
        timed = self._timed(state, level, since)
        seconds = timed.duration or self.map.pace.duration
        phase = self._followed(state.phase, level, self.speed * dt / seconds)
        return timed._replace(phase=phase, value=smooth, start=start, unseen=0.0)

    def _timed(self, state: DriverState, level: float, since: float) -> DriverState:
        """Return the state with what is known of the pace."""
        if max(state.phase, self.map.ahead(level)) < _AT_START:
            return state._replace(elapsed=0.0, passed=0, duration=None)
        elapsed, passed, duration = state.elapsed + since, state.passed, state.duration
        pace = self.map.pace
        while passed < len(pace.levels) and level >= pace.levels[passed]:
            duration = pace.after(passed, elapsed) or duration
            passed += 1
        return state._replace(elapsed=elapsed, passed=passed, duration=duration)

    def _followed(self, phase: float, level: float, most: float) -> float:
        """Return the phase that follows a level by steps of at most ``most``."""
        ahead = self.map.ahead(level)
        if ahead > phase:
            return min(ahead, phase + most)
        return max(min(phase, self.map.behind(level)), phase - most)


class SignalDriver:
    """Progress along the path, chosen by a signal that comes value by value.

    Parameters
    ----------
    rule

    Examples
    --------
    >>> from handsim import GraspController, data_folder
    >>> from handsim.driving.signal_map import map_between
    >>> controller = GraspController.load(data_folder("assets") / "controller.npz")
    >>> switch = map_between(controller.demonstrations, rest=0.0, grasp=1.0)
    >>> driver = SignalDriver(DriverRule(switch))
    >>> for _ in range(300):
    ...     progress = driver.step(1.0, dt=0.01)
    >>> progress
    1.0
    """

    def __init__(self, rule: DriverRule) -> None:
        self.rule = rule
        self.state = DriverState()

    @property
    def progress(self) -> float:
        """Progress now, 0 to 1."""
        return self.rule.progress(self.state)

    def step(self, value: float, dt: float) -> float:
        """Take the value of the signal ``dt`` [s] after the last, NaN if missing; return progress.

        Raises
        ------
        InputError
            If the time step is no number or negative.
        """
        self.state = self.rule.after(self.state, value, dt)
        return self.progress

    def reset(self) -> None:
        """Go back to the start, as for a new movement."""
        self.state = DriverState()

"""Progress that follows a signal, value by value.

Ahead it goes at once, but no faster than people did, by a factor. It goes back only when the signal
has gone back by more than the map's slack (hysteresis), as far as the signal lets it, at the same
speed. While the signal is missing it is held.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handsim.driving.signal_map import SignalMap
from handsim.errors import InputError
from handsim.recordings.signals import low_passed

_AT_START = 1e-3
"""Progress below which the movement has not begun: a smoothed signal never quite returns."""


class DriverState(NamedTuple):
    """Where a driver stands.

    Attributes
    ----------
    progress
        0 to 1.
    value
        Of the signal, smoothed; None before the first.
    start
        Its value at the start of the movement.
    unseen
        Time since the last value [s].
    """

    progress: float = 0.0
    value: float | None = None
    start: float = 0.0
    unseen: float = 0.0


@dataclass(frozen=True, eq=False)
class DriverRule:
    """How progress follows a signal: a pure function of state and value.

    Attributes
    ----------
    map
    smoothing
        Time constant of the low-pass of the signal [s]; 0 takes it as it is.
    speed
        Greatest speed of progress, relative to the mean of people at the same progress.
    """

    map: SignalMap
    smoothing: float = 0.02
    speed: float = 1.2

    def __post_init__(self) -> None:
        """Check the values."""
        for name, value, least in (("smoothing", self.smoothing, 0.0), ("speed", self.speed, 1e-3)):
            if not least <= value <= 1e3:
                raise InputError(f"{name} {value:g}; give a number from {least:g} to 1000")

    def after(self, state: DriverState, value: float, dt: float) -> DriverState:
        """Return the state ``dt`` [s] later, when the signal is ``value``; NaN if it is missing."""
        if not (np.isfinite(dt) and dt >= 0):
            raise InputError(f"time step {dt:g} s; give a number of seconds that is not negative")
        if not np.isfinite(value):
            return state._replace(unseen=state.unseen + dt)
        if state.value is None:
            smooth, start = float(value), float(value)
        else:
            smooth = low_passed(state.value, value, dt + state.unseen, self.smoothing)
            # Whoever moves away before the movement begins has a new start.
            start = max(state.start, smooth) if state.progress < _AT_START else state.start
        progress = self._followed(state.progress, self.map.level(smooth, start), dt)
        return DriverState(progress, smooth, start)

    def _followed(self, progress: float, level: float, dt: float) -> float:
        ahead, seconds = self.map.ahead(level), self.speed * dt
        if ahead > progress:
            return min(ahead, self.map.later(progress, seconds))
        return max(min(progress, self.map.behind(level)), self.map.later(progress, -seconds))


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
        return self.state.progress

    def step(self, value: float, dt: float) -> float:
        """Take the value of the signal ``dt`` [s] after the last, NaN if missing; return progress.

        Raises
        ------
        InputError
            If the time step is no number or negative.
        """
        self.state = self.rule.after(self.state, value, dt)
        return self.state.progress

    def reset(self) -> None:
        """Go back to the start, as for a new movement."""
        self.state = DriverState()

"""What moves in a recording: the palm where it was recorded and travels, otherwise the joints."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.recordings.phases import RATE, hand_speed, low_pass, resample
from handsim.recordings.recording import MIN_FRAMES
from handsim.types import Array, Mask

PALM = ("palm_x_m", "palm_y_m", "palm_z_m")
MIN_TRAVEL = 0.05
"""Travel of a palm that reaches [m]; one that moves less lies on the table or is the origin."""
MIN_TURN = float(np.deg2rad(5.0))
"""Change of posture by a reach, the Euclidean norm over the joints [rad]. People's are thirty times
as large; this lies above the noise of gloves."""
LONGEST_GAP_S = 0.25
"""Longest gap that a straight line bridges [s]; a quarter of a reach."""
MIN_SEEN = 0.5
"""Smallest share of frames in which the palm must be seen to be used."""
QUIET_S = 0.5
RESTLESS = 0.1
"""A hand that nowhere is slower than this share of its peak for `QUIET_S` moves all the time."""
LONGEST_S = 4 * 3600.0
"""Longest recording that is cut [s]; whoever has a longer one has given milliseconds."""


@dataclass(frozen=True)
class Motion:
    """One recording on an even grid of 100 Hz.

    Attributes
    ----------
    time : (n,) [s], of the recording
    q : (n, 22) [rad], low-passed
    place : (n, d)
        What is followed: the palm's position [m] or the posture [rad], low-passed.
    speed : (n,)
        Of ``place`` [m/s or rad/s].
    seen : (n,)
        False within gaps too long to bridge.
    palm
        Whether it is the palm.
    floor
        Speed in the quietest half second, which is noise, or 0 where the hand moves all the time
        and nothing tells the noise [m/s or rad/s].
    """

    time: Array
    q: Array
    place: Array
    speed: Array
    seen: Mask
    palm: bool
    floor: float


def motion_of(time: Array, q: Array, channels: Mapping[str, Array]) -> Motion:
    """Resample and filter a recording, and choose what is followed.

    Parameters
    ----------
    time : (n,) [s], increasing
    q : (n, 22) [rad]
    channels
        Further channels, (n,) each, NaN where missing.

    Raises
    ------
    InputError
        If it is too short to move in, or so long that its times are hardly seconds.
    """
    duration = float(time[-1] - time[0])
    if not (MIN_FRAMES - 1) / RATE <= duration <= LONGEST_S:
        raise InputError(
            f"it lasts {duration:g} s; give {(MIN_FRAMES - 1) / RATE:g} to {LONGEST_S:g} s, and "
            "its times in seconds"
        )
    grid, uniform = resample(time, q)
    q = low_pass(uniform)
    place, seen = q, np.ones(len(grid), dtype=bool)
    palm = _palm(time, channels, grid)
    if palm is not None:
        place, seen = palm
    speed = hand_speed(place)
    return Motion(grid, q, place, speed, seen, palm is not None, _quietest(speed))


def on_grid(time: Array, values: Array, grid: Array) -> tuple[Array, Mask]:
    """Bring a channel to other times, with straight lines over missing values.

    Returns
    -------
    values : (m,)
        NaN throughout where the channel has fewer than two values.
    seen : (m,)
        False before the first value, after the last, and in gaps longer than `LONGEST_GAP_S`.
    """
    known = np.isfinite(values)
    if known.sum() < 2:
        return np.full(len(grid), np.nan), np.zeros(len(grid), dtype=bool)
    times = time[known]
    after = np.clip(np.searchsorted(times, grid, side="left"), 0, len(times) - 1)
    before = np.clip(np.searchsorted(times, grid, side="right") - 1, 0, len(times) - 1)
    step = max(LONGEST_GAP_S, 2 * float(np.median(np.diff(time))))
    inside = (grid >= times[0]) & (grid <= times[-1])
    return np.interp(grid, times, values[known]), inside & (times[after] - times[before] <= step)


def _palm(time: Array, channels: Mapping[str, Array], grid: Array) -> tuple[Array, Mask] | None:
    if any(name not in channels for name in PALM):
        return None
    columns = [on_grid(time, np.asarray(channels[name], dtype=float), grid) for name in PALM]
    seen = np.logical_and.reduce([mask for _, mask in columns])
    if seen.mean() < MIN_SEEN:
        return None
    place = low_pass(np.column_stack([values for values, _ in columns]))
    travel = np.ptp(place[seen], axis=0)
    return (place, seen) if float(np.linalg.norm(travel)) > MIN_TRAVEL else None


def _quietest(speed: Array) -> float:
    width = min(len(speed), round(QUIET_S * RATE))
    total = np.concatenate([[0.0], np.cumsum(speed)])
    floor = max(float(np.min(total[width:] - total[:-width])) / width, 0.0)
    return floor if floor < RESTLESS * float(speed.max()) else 0.0

"""When frames were taken: from time stamps of any unit, from a rate, or by assumption."""

from dataclasses import dataclass

import numpy as np

from handsim.errors import FileError
from handsim.types import Array, Mask
from handsim.wording import number_of

ASSUMED_RATE_HZ = 30.0
"""Rate of frames without times where none was given: that of most cameras [Hz]."""
_UNITS = (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))
_LEAST_STEP, _LONGEST_STEP = 5e-5, 0.6
"""Steps between frames that are believed [s]: 20 kHz to little more than one a second."""
MOST_REPEATED = 0.1
"""Share of frames with the time of the one before, above which a clock is not believed."""


@dataclass(frozen=True)
class Clock:
    """Times of frames.

    Attributes
    ----------
    time : (k,) [s]
        Increasing, from 0.
    kept : (n,)
        Which of the frames have a time of their own.
    notes
        What was assumed or left out.
    """

    time: Array
    kept: Mask
    notes: tuple[str, ...] = ()


def clock_of(
    where: str, n: int, stamps: Array | None, said_hz: float | None, file_hz: float | None
) -> Clock:
    """Return the times of n frames: by a rate that was said, by stamps, or by the file's rate.

    Raises
    ------
    FileError
        As `clock_of_stamps`.
    """
    if stamps is not None and said_hz is None:
        return clock_of_stamps(where, stamps)
    return clock_of_rate(n, said_hz or file_hz)


def clock_of_stamps(where: str, stamps: Array) -> Clock:
    """Return the times of frames with time stamps (n,), whose unit is found by their steps.

    Raises
    ------
    FileError
        If stamps are missing or go back, or no unit gives a believable rate.
    """
    stamps = np.asarray(stamps, dtype=float)
    if not np.isfinite(stamps).all():
        row = int(np.flatnonzero(~np.isfinite(stamps))[0])
        raise FileError(f"{where}: frame {row + 1} has no time; correct or remove it")
    kept = np.concatenate([[True], np.diff(stamps) > 0])
    backward = np.flatnonzero(np.diff(stamps) < 0)
    if backward.size:
        row = int(backward[0]) + 1
        raise FileError(
            f"{where}: frame {row + 1} has time {stamps[row]:g} after {stamps[row - 1]:g}; time "
            "must increase"
        )
    if (~kept).mean() > MOST_REPEATED:
        raise FileError(
            f"{where}: {(~kept).sum()} of {len(kept)} frames repeat the time of the one before; "
            "give the rate instead (--rate) and leave the times out"
        )
    step = float(np.median(np.diff(stamps[kept]))) if kept.sum() > 1 else 0.0
    for unit, seconds in _UNITS:
        if _LEAST_STEP <= step * seconds <= _LONGEST_STEP:
            notes = [] if unit == "s" else [f"times taken as {unit}"]
            if not kept.all():
                what = number_of(
                    (~kept).sum(), "frame that repeats a time", "frames that repeat a time"
                )
                notes.append(f"{what} left out")
            time = (stamps[kept] - stamps[0]) * seconds
            return Clock(time, kept, tuple(notes))
    raise FileError(
        f"{where}: frames are {step:g} apart, which is no believable step in s, ms, us or ns; "
        "correct the times"
    )


def clock_of_rate(n: int, rate_hz: float | None) -> Clock:
    """Return the times of n frames at a rate, by default `ASSUMED_RATE_HZ`, and say so."""
    notes = ()
    if rate_hz is None:
        rate_hz = ASSUMED_RATE_HZ
        notes = (f"no times in the file: {rate_hz:g} Hz assumed (say --rate to correct it)",)
    return Clock(np.arange(n) / rate_hz, np.ones(n, dtype=bool), notes)

"""Columns of time as seconds: numbers of any unit, frames of a rate, and wall-clock stamps."""

import re
from collections.abc import Sequence
from datetime import date
from itertools import pairwise
from typing import Literal

import numpy as np

from handsim.types import Array

TimeUnit = Literal["s", "ms", "us", "frames", "clock"]
TIME_UNITS: dict[TimeUnit, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "frames": 1.0, "clock": 1.0}
"""Units of a column of time, and how many seconds one is (frames: over the rate)."""
_DAY = 86400.0
_CLOCK = re.compile(
    r"(?P<date>\d{1,4}[-./]\d{1,2}[-./]\d{1,4})?[T ,]*"
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2})(?:[.,:](?P<part>\d{1,9}))?)?"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?:Z|UTC|[+-]\d{2}:?\d{2})?"
)
_LEAST_STEP_MS, _LEAST_STEP_US = 0.3, 300.0


def is_clock(cell: str) -> bool:
    """Whether a cell is a wall-clock stamp such as ``01.05.2024 12:30:01,250``."""
    return bool(_CLOCK.fullmatch(cell.strip().strip('"')))


def clock_seconds(cells: Sequence[str]) -> Array:
    """Return wall-clock stamps as seconds, (n,), with midnight passed; NaN where there is none.

    Time zones are not looked at. Dates written with slashes are taken as day/month or as
    month/day, whichever leads forward. Without dates, a clock that falls by more than half a day
    has passed midnight.
    """
    matches = [_CLOCK.fullmatch(cell.strip().strip('"')) for cell in cells]
    time = np.array([np.nan if m is None else _of_day(m) for m in matches])
    texts = [m["date"] if m else None for m in matches]
    days = _days(texts)
    if days is not None:
        return time + days * _DAY
    known = np.flatnonzero(np.isfinite(time))
    passed = np.zeros(len(time))
    passed[known[1:]] = np.diff(time[known]) < -_DAY / 2
    return time + np.cumsum(passed) * _DAY


def _of_day(stamp: re.Match[str]) -> float:
    hour, minute, second = (int(stamp[name] or 0) for name in ("hour", "minute", "second"))
    if stamp["half"]:
        hour = hour % 12 + (12 if stamp["half"][0] in "Pp" else 0)
    if hour > 23 or minute > 59 or second > 60:
        return np.nan
    return hour * 3600.0 + minute * 60.0 + second + float(f"0.{stamp['part'] or 0}")


def _days(texts: Sequence[str | None]) -> Array | None:
    """Return the days of the dates, from the first; None unless all stamps have one."""
    distinct = list(dict.fromkeys(texts))
    if not distinct or None in distinct:
        return None
    if len(distinct) == 1:
        return np.zeros(len(texts))
    for first_is_day in (True, False):
        try:
            ordinals = [_ordinal(str(text), first_is_day) for text in distinct]
        except ValueError:
            continue
        if all(0 <= b - a <= 2 for a, b in pairwise(ordinals)):
            of_text = dict(zip(distinct, ordinals, strict=True))
            return np.array([of_text[text] - ordinals[0] for text in texts], dtype=float)
    return None


def _ordinal(text: str, first_is_day: bool) -> int:
    parts = [int(part) for part in re.split("[-./]", text)]
    if parts[0] > 31:
        year, month, day = parts
    elif first_is_day:
        day, month, year = parts
    else:
        month, day, year = parts
    return date(year + 2000 if year < 100 else year, month, day).toordinal()


def unit_by_steps(values: Array) -> TimeUnit | None:
    """Return the unit that the median step of times tells, for 3 Hz to 3 kHz; None if none does."""
    steps = np.diff(values[np.isfinite(values)])
    steps = steps[steps > 0]
    if not steps.size:
        return None
    step = float(np.median(steps))
    if step < _LEAST_STEP_MS:
        return "s"
    return "ms" if step < _LEAST_STEP_US else "us"

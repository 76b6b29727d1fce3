"""Wall clocks, and units of times by their steps."""

import numpy as np
import pytest

from handsim.recordings.columns.clock import clock_seconds, is_clock, unit_by_steps


@pytest.mark.parametrize(
    ("stamps", "steps"),
    [
        (["12:30:01.250", "12:30:01.260", "12:31:00"], [0.01, 58.74]),
        (["23:59:59,9", "00:00:00,1"], [0.2]),
        (["11:59:59 PM", "12:00:01 AM"], [2.0]),
        (["2024-05-01T12:30:01.25Z", "2024-05-02T12:30:01.25Z"], [86400.0]),
        (["28.02.2024 23:00:00", "29.02.2024 01:00:00"], [7200.0]),
        (["12/31/2024 23:59:59", "1/1/2025 00:00:01"], [2.0]),
        (["1/31/2024 10:00:00", "2/1/2024 11:00:00"], [90000.0]),
        (["30/04/2024 23:59:59", "01/05/2024 00:00:01"], [2.0]),
        (["12:30:05", "12:30:01"], [-4.0]),
    ],
)
def test_stamps(stamps: list[str], steps: list[float]) -> None:
    assert np.diff(clock_seconds(stamps)) == pytest.approx(steps)


def test_what_is_no_clock() -> None:
    assert np.isnan(clock_seconds(["25:00:00", "12:61:00", "soon"])).all()
    assert not is_clock("12.30") and not is_clock("1714550000") and is_clock('"12:30:01:250"')


def test_units_by_steps() -> None:
    for step, unit in ((0.001, "s"), (0.1, "s"), (1, "ms"), (16.7, "ms"), (1000, "us")):
        assert unit_by_steps(np.arange(10) * step) == unit
    assert unit_by_steps(np.zeros(10)) is None and unit_by_steps(np.full(3, np.nan)) is None

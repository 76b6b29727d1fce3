"""Times of frames: units found by their steps, repeats left out, nonsense refused."""

import numpy as np
import pytest

from handsim.errors import FileError
from handsim.recordings.points.clocks import clock_of_rate, clock_of_stamps


@pytest.mark.parametrize("factor", [1.0, 1e3, 1e6, 1e9])
def test_units_are_found(factor: float) -> None:
    clock = clock_of_stamps("f", (5 + np.arange(20) / 60) * factor)
    assert clock.time == pytest.approx(np.arange(20) / 60, abs=1e-9)
    assert bool(clock.notes) == (factor != 1.0)


def test_repeated_times_are_left_out_and_said() -> None:
    stamps = np.arange(40) / 30
    stamps[7] = stamps[6]
    clock = clock_of_stamps("f", stamps)
    assert np.flatnonzero(~clock.kept).tolist() == [7] and len(clock.time) == 39
    assert clock.notes == ("1 frame that repeats a time left out",)


def test_no_times() -> None:
    assert clock_of_rate(4, 120.0).time[-1] == pytest.approx(3 / 120)
    assumed = clock_of_rate(31, None)
    assert assumed.time[-1] == pytest.approx(1.0) and "30 Hz assumed" in assumed.notes[0]


@pytest.mark.parametrize(
    ("stamps", "said"),
    [
        ([0, 0.1, np.nan, 0.3], "frame 3 has no time"),
        ([0, 0.1, 0.05, 0.3], "frame 3 has time 0.05 after 0.1"),
        ([0, 0, 0, 0.1, 0.2], "2 of 5 frames repeat"),
        ([0, 10, 20, 30], None),
        ([0, 1e30, 2e30], "no believable step"),
    ],
)
def test_nonsense(stamps: list[float], said: str | None) -> None:
    if said is None:
        assert clock_of_stamps("f", np.array(stamps)).notes == ("times taken as ms",)
        return
    with pytest.raises(FileError, match=said):
        clock_of_stamps("f", np.array(stamps, dtype=float))

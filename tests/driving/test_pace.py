"""How long a movement will take, by how soon its signal came to some levels."""

import numpy as np
import pytest

from handsim.driving.pace import fitted_pace, steady_pace

RAMP = np.tile(np.linspace(0.0, 1.0, 101), (4, 1))
DURATIONS = np.array([0.5, 1.0, 2.0, 4.0])


def test_who_took_twice_as_long_to_half_way_takes_twice_as_long() -> None:
    pace = fitted_pace(RAMP, DURATIONS, np.array([0.5]))
    assert pace.duration == pytest.approx(2**0.5)
    half, whole = pace.after(0, 0.5), pace.after(0, 1.0)
    assert half is not None and whole is not None
    assert whole / half == pytest.approx(2.0, rel=0.05)
    assert half == pytest.approx(1.0, rel=0.05)
    assert (pace.least[0], pace.greatest[0]) == pytest.approx((0.25, 2.0))


def test_times_that_nobody_took() -> None:
    pace = fitted_pace(RAMP, DURATIONS, np.array([0.5]))
    assert pace.after(0, 2.1) is None
    assert pace.after(0, 0.0) == pace.after(0, float(pace.least[0]))


def test_times_that_say_nothing_change_nothing() -> None:
    rng = np.random.default_rng(0)
    steps = np.array([(np.arange(101) > n).astype(float) for n in rng.integers(5, 95, 40)])
    passed = np.argmax(steps > 0.5, axis=1)
    durations = 40.0 / passed  # all pass the level after 0.4 s
    pace = fitted_pace(steps, durations, np.array([0.5]))
    assert abs(pace.gains[0]) < 0.2
    assert pace.after(0, 0.4) == pytest.approx(pace.duration, rel=1e-3)


def test_one_recording_and_none_of_the_levels() -> None:
    one = fitted_pace(RAMP[:1], DURATIONS[2:3], np.array([0.2, 0.5, 2.0]))
    assert one.gains.tolist() == [0.0, 0.0, 0.0]
    assert one.after(1, 1.0) == pytest.approx(2.0)
    assert one.greatest[2] == 2.0
    steady = steady_pace(DURATIONS)
    assert steady.duration == pytest.approx(2**0.5)
    assert len(steady.levels) == 0

"""Filtering and cutting, on movements whose phases are known."""

import numpy as np
import pytest
from scipy import signal

from handsim.errors import InputError
from handsim.joints import N_JOINTS
from handsim.recordings.phases import (
    cut_reach_to_grasp,
    hand_speed,
    low_pass,
    reach_to_grasp,
    resample,
)


def reach(start: float, duration: float, total: float, rate: float = 100.0) -> np.ndarray:
    """All joints move by 1 rad along a minimum-jerk profile."""
    x = np.clip((np.arange(0, total, 1 / rate) - start) / duration, 0, 1)
    return np.tile((x**3 * (10 - 15 * x + 6 * x**2))[:, None], (1, N_JOINTS))


def test_resampling_hits_a_straight_line() -> None:
    time = np.array([2.0, 2.013, 2.5, 3.004])
    uniform, q = resample(time, np.column_stack([time, -2 * time]))
    np.testing.assert_allclose(np.diff(uniform), 0.01)
    assert len(uniform) == 101
    np.testing.assert_allclose(q, np.column_stack([uniform, -2 * uniform]))


def test_low_pass_halves_power_twice_at_the_cutoff_and_has_no_lag() -> None:
    time = np.arange(2000) / 100
    for frequency, gain in ((0.2, 1.0), (3.0, 0.5), (20.0, 0.0)):
        wave = np.sin(2 * np.pi * frequency * time)[:, None]
        filtered = low_pass(wave)[500:1500]
        # Forwards and backwards: the square of the Butterworth gain, 1 / (1 + (f / fc)^4).
        np.testing.assert_allclose(filtered, gain * wave[500:1500], atol=6e-3)


@pytest.mark.parametrize(("n", "d"), [(10, 22), (34, 1), (35, 3), (400, 22)])
@pytest.mark.parametrize(("rate", "cutoff"), [(100.0, 3.0), (60.0, 6.0)])
def test_low_pass_is_that_of_scipy(n: int, d: int, rate: float, cutoff: float) -> None:
    q = np.cumsum(np.random.default_rng(n).normal(size=(n, d)), axis=0)
    sections = signal.butter(2, cutoff, fs=rate, output="sos")
    reference = signal.sosfiltfilt(sections, q, axis=0, padlen=min(n - 1, int(rate / cutoff)))
    np.testing.assert_allclose(low_pass(q, rate, cutoff), reference, atol=1e-12)


def test_speed_of_a_ramp() -> None:
    ramp = np.outer(np.arange(20) / 100, np.full(N_JOINTS, 0.5))
    np.testing.assert_allclose(hand_speed(ramp), 0.5 * np.sqrt(N_JOINTS))


def test_phase_is_where_the_rule_says() -> None:
    start, duration = 1.0, 2.0
    phase = reach_to_grasp(reach(start, duration, 6.0))
    # Speed over peak is 16 x^2 (1 - x)^2: 8 % at x = 0.0766, 15 % (falling) at x = 0.8914.
    onset = 0.5 - np.sqrt(0.25 - np.sqrt(0.08) / 4)
    end = 0.5 + np.sqrt(0.25 - np.sqrt(0.15) / 4)
    assert phase.start == pytest.approx(100 * (start + onset * duration), abs=1.5)
    assert phase.stop - 1 == pytest.approx(100 * (start + end * duration), abs=1.5)


def test_an_early_pause_does_not_end_the_movement() -> None:
    small = 0.4 * reach(0.5, 1.0, 6.0)  # fast enough, but less than half of the way
    large = 0.6 * reach(2.5, 1.0, 6.0)
    phase = reach_to_grasp(small + large)
    assert 50 < phase.start < 100
    assert phase.stop > 300


def test_cut_starts_at_zero_on_an_even_grid() -> None:
    time = np.sort(np.random.default_rng(0).uniform(4.0, 10.0, 1500))
    q = np.column_stack([np.interp(time - 4.0, np.arange(0, 6, 0.01), c) for c in reach(1, 2, 6).T])
    cut_time, cut_q = cut_reach_to_grasp(time, q)
    np.testing.assert_allclose(cut_time, np.arange(len(cut_q)) / 100)
    assert 140 < len(cut_q) < 200


def test_no_movement_and_too_short_a_movement() -> None:
    with pytest.raises(InputError, match="never moves"):
        reach_to_grasp(np.ones((50, N_JOINTS)))
    with pytest.raises(InputError, match="frames"):
        reach_to_grasp(reach(0.1, 0.05, 1.0))

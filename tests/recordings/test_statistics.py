"""Figures of reaches whose duration, peak and aperture are known."""

import math

import numpy as np
import pytest

from handsim.recordings.recording import Recording
from handsim.recordings.statistics import FIGURES, median_statistics, reach_statistics
from handsim.types import HandSize


def reach(duration: float = 1.6, channels: dict[str, np.ndarray] | None = None) -> Recording:
    """All joints turn by 0.5 rad along a minimum-jerk profile."""
    time = np.arange(round(100 * duration) + 1) / 100
    x = time / time[-1]
    share = x**3 * (10 - 15 * x + 6 * x**2)
    return Recording(
        "a", time, 0.5 * np.tile(share[:, None], 22), 1, "s", "o", "t", HandSize(),
        channels={name: values(x) for name, values in (channels or {}).items()},
    )  # fmt: skip


PALM = {
    "palm_x_m": lambda x: 0.3 * x**3 * (10 - 15 * x + 6 * x**2),
    "palm_y_m": lambda x: 0 * x,
    "palm_z_m": lambda x: 0.4 * x**3 * (10 - 15 * x + 6 * x**2),
}


def test_joints_without_a_palm() -> None:
    found = reach_statistics(reach())
    assert found.duration_s == pytest.approx(1.6)
    # The peak speed of a minimum-jerk movement is 15/8 of the mean; the filter takes 2 % off.
    expected = np.rad2deg(0.5 * np.sqrt(22)) / 1.6 * 15 / 8
    assert found.peak_speed_deg_s == pytest.approx(expected, rel=0.03)
    assert found.peak_speed_at == pytest.approx(0.5, abs=0.02)
    assert math.isnan(found.peak_speed_m_s)
    assert math.isnan(found.aperture_m) and math.isnan(found.closing_s)


def test_palm_and_aperture() -> None:
    aperture = {"aperture_m": lambda x: 0.12 - 0.1 * (x - 0.75) ** 2}
    found = reach_statistics(reach(channels={**PALM, **aperture}))
    assert found.peak_speed_m_s == pytest.approx(0.5 / 1.6 * 15 / 8, rel=0.03)
    assert found.peak_speed_deg_s > 100
    assert found.aperture_m == pytest.approx(0.12, abs=1e-6)
    assert found.aperture_at == pytest.approx(0.75)
    assert found.closing_s == pytest.approx(0.4)


def test_an_aperture_that_is_mostly_missing_is_not_known() -> None:
    def holes(upto: float):
        return {"aperture_m": lambda x: np.where((x > 0.1) & (x < upto), np.nan, 0.1 + 0.01 * x)}

    assert math.isnan(reach_statistics(reach(channels=holes(0.8))).aperture_m)
    seen = reach_statistics(reach(channels=holes(0.4)))
    assert seen.aperture_m == pytest.approx(0.11) and seen.aperture_at == 1.0


def test_medians_leave_out_what_is_not_known() -> None:
    aperture = {"aperture_m": lambda x: 0.1 + 0 * x}
    each = [reach_statistics(r) for r in (reach(1.0), reach(1.2, aperture), reach(2.0))]
    medians = median_statistics(each)
    assert set(medians) == set(FIGURES)
    assert medians["duration_s"] == pytest.approx(1.2)
    assert medians["aperture_m"] == pytest.approx(0.1)
    assert math.isnan(medians["peak_speed_m_s"])
    assert math.isnan(median_statistics([])["duration_s"])


def test_too_short_a_recording_has_a_duration_only() -> None:
    short = Recording("s", np.arange(10) / 1e4, np.zeros((10, 22)), 1, "s", "o", "t", HandSize())
    found = reach_statistics(short)
    assert found.duration_s == pytest.approx(9e-4) and math.isnan(found.peak_speed_deg_s)

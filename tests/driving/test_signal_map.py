"""Maps from a signal to the phase of a movement."""

import dataclasses

import numpy as np
import pytest
from made_up import EVEN, demonstration, falling

from handsim.driving.signal_map import (
    PHASES,
    fitted_map,
    map_between,
    mean_progress,
    times_at_progress,
)
from handsim.errors import InputError
from handsim.learning.demonstration import SIGNAL_PROGRESS


def test_the_inverse_of_one_recording() -> None:
    made = fitted_map([demonstration(d=falling())], "d", rising=False, relative=False)
    assert made.ahead(-0.4) == 0.0
    assert made.ahead(-0.25) == pytest.approx(0.5, abs=0.011)
    assert made.ahead(-0.1) == pytest.approx(1.0)
    assert made.ahead(-0.5) == 0.0
    assert made.ahead(0.0) == 1.0
    assert made.level(0.25, start=0.4) == -0.25
    assert made.slack == pytest.approx(0.05 * 0.3)


def test_four_of_five_people_were_no_farther() -> None:
    """Signals that end at different places: the quantile, not the mean."""
    ends = [0.10, 0.10, 0.15, 0.20, 0.20]
    several = [demonstration(d=falling(end=end)) for end in ends]
    made = fitted_map(several, "d", rising=False, relative=False)
    assert made.ahead(-0.2) == pytest.approx(1.0, abs=0.02)  # the mean would be 0.82
    assert (np.diff(made.phase) >= 0).all()


def test_a_share_of_the_start_makes_different_starts_one() -> None:
    several = [demonstration(d=falling(start, start / 4)) for start in (0.2, 0.4, 0.8)]
    made = fitted_map(several, "d", rising=False, relative=True)
    assert made.level(0.25, start=0.4) == pytest.approx(-0.625)
    assert made.ahead(-0.625) == pytest.approx(0.5, abs=0.011)
    assert made.level(0.25, start=0.0) == -1.0  # no share of nothing: still at the start


def test_where_a_signal_stands_still_it_leads_to_the_end_of_that() -> None:
    """A hand that has arrived half way and then closes; noise there does not stop it."""
    arrived = np.maximum(falling(0.4, -0.2), 0.1) + 1e-3 * np.sin(40 * SIGNAL_PROGRESS)
    made = fitted_map([demonstration(d=arrived)], "d", rising=False, relative=False)
    assert made.ahead(-0.098) == 1.0
    assert made.ahead(-0.15) < 0.5


def test_one_wrong_value_changes_little() -> None:
    wrong = falling()
    wrong[20] = 0.1
    made = fitted_map([demonstration(d=wrong)], "d", rising=False, relative=False)
    assert made.ahead(-0.25) == pytest.approx(0.5, abs=0.02)


def test_a_switch_is_off_at_rest_and_on_at_the_end() -> None:
    """People moved a little before they pressed it; off is none the less rest."""
    pressed = (SIGNAL_PROGRESS > 0.3).astype(float)
    made = fitted_map([demonstration(s=pressed)], "s", rising=True, relative=False)
    assert made.ahead(0.0) == 0.0
    assert made.ahead(1.0) == 1.0
    assert made.behind(0.0) == 0.0


def test_it_goes_back_only_beyond_the_slack() -> None:
    made = map_between([demonstration()], rest=0.0, grasp=1.0)
    assert made.slack == pytest.approx(0.05)
    assert made.behind(0.5) == pytest.approx(0.55)
    assert made.behind(0.02) == pytest.approx(0.04)  # the slack ends at rest, so that 0 is reached
    assert made.behind(0.0) == 0.0


def test_the_slack_is_what_recorded_signals_go_back() -> None:
    hump = falling(0.4, 0.1) + 0.05 * (np.abs(SIGNAL_PROGRESS - 0.9) < 0.05)
    made = fitted_map([demonstration(d=hump)] * 3, "d", rising=False, relative=False)
    assert made.slack == pytest.approx(0.05, abs=0.004)
    wild = np.where(np.arange(101) % 2, 0.4, 0.1)
    made = fitted_map([demonstration(d=wild)] * 3, "d", rising=False, relative=False)
    assert made.slack == pytest.approx(0.5 * (made.levels[-1] - made.levels[0]))


def test_phases_are_fractions_of_the_time() -> None:
    """A signal that follows progress, of people who are a quarter along after half the time."""
    slow_start = [demonstration(d, EVEN**2, s=SIGNAL_PROGRESS) for d in (1.0, 2.0)]
    assert times_at_progress(slow_start[1])[25] == pytest.approx(1.0, abs=0.01)
    made = fitted_map(slow_start, "s", rising=True, relative=False)
    assert made.ahead(0.25) == pytest.approx(0.5, abs=0.01)
    assert made.curve[50] == pytest.approx(0.25, abs=0.01)
    assert made.pace.duration == pytest.approx(2**0.5)


def test_progress_is_the_mean_of_people() -> None:
    curve = mean_progress([demonstration(2.0, EVEN**2), demonstration(1.0)])
    assert curve[50] == pytest.approx((0.25 + 0.5) / 2)
    assert (curve[0], curve[-1]) == (0.0, 1.0)


def test_files_without_timing_count_as_minimum_jerk() -> None:
    older = dataclasses.replace(demonstration(2.0), progress=None)
    assert mean_progress([older])[[25, 50]] == pytest.approx([0.1035, 0.5], abs=1e-3)
    assert times_at_progress(older)[50] == pytest.approx(1.0)


def test_progress_is_linear_between_rest_and_grasp() -> None:
    made = map_between([demonstration(1.0, EVEN**2)], 0.0, 1.0)
    assert made.ahead(0.25) == pytest.approx(0.5, abs=0.01)
    assert np.interp(made.ahead(0.6), PHASES, made.curve) == pytest.approx(0.6, abs=1e-3)
    still = map_between([demonstration(1.0, 0 * EVEN)], 0.0, 1.0)
    assert np.isfinite(still.phase).all()


def test_falling_ranges() -> None:
    made = map_between([demonstration()], rest=0.4, grasp=0.2, channel="d")
    assert not made.rising
    assert made.ahead(made.level(0.3, 0.0)) == pytest.approx(0.5)


@pytest.mark.parametrize("rest, grasp", [(1.0, 1.0), (np.nan, 1.0), (0.0, np.inf)])
def test_ranges_that_are_none(rest: float, grasp: float) -> None:
    with pytest.raises(InputError, match="two different finite numbers"):
        map_between([demonstration()], rest, grasp)

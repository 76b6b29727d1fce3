"""Progress that follows a signal: speed limit, hysteresis, hold, release."""

import numpy as np
import pytest
from made_up import EVEN, demonstration, falling

from handsim.driving.driver import DriverRule, DriverState, SignalDriver
from handsim.driving.signal_map import fitted_map, map_between
from handsim.errors import InputError

DT = 0.01


def driver(smoothing: float = 0.0, speed: float = 1.0, duration: float = 1.0) -> SignalDriver:
    """Driven by a signal from 0 at rest to 1, at most in ``duration`` [s], evenly."""
    return SignalDriver(
        DriverRule(map_between([demonstration(duration)], 0.0, 1.0), smoothing, speed)
    )


def driven(one: SignalDriver, values) -> np.ndarray:
    return np.array([one.step(float(value), DT) for value in values])


def test_it_follows_a_slow_signal() -> None:
    ramp = np.linspace(0.0, 1.0, 500)
    np.testing.assert_allclose(driven(driver(), ramp), ramp, atol=1e-9)


def test_it_is_no_faster_than_people_by_a_factor() -> None:
    for speed in (1.0, 2.0):
        progress = driven(driver(speed=speed), np.ones(120))
        steps = np.diff(progress, prepend=0.0)
        assert steps.max() == pytest.approx(speed * DT)
        assert progress[int(50 / speed) - 1] == pytest.approx(0.5)
        assert progress[-1] == 1.0


def test_the_limit_is_that_of_people_at_the_same_progress() -> None:
    slow_start = EVEN**2
    rule = DriverRule(map_between([demonstration(1.0, slow_start)], 0.0, 1.0), 0.0, 1.0)
    progress = driven(SignalDriver(rule), np.ones(100))
    assert progress[49] == pytest.approx(0.25, abs=0.01)


def test_progress_is_that_of_this_movement_where_it_is_given() -> None:
    rule = DriverRule(driver().rule.map, 0.0, 1.0, curve=np.linspace(0.0, 1.0, 101) ** 2)
    assert driven(SignalDriver(rule), np.ones(50))[-1] == pytest.approx(0.25)
    with pytest.raises(InputError, match="curve of shape"):
        DriverRule(driver().rule.map, curve=np.ones(7))


def paced() -> DriverRule:
    """By people of whom the slow took twice as long as the fast, all along."""
    several = [demonstration(d, d=np.maximum(falling(0.4, -0.2), 0.1)) for d in (0.8, 1.2, 1.6)]
    return DriverRule(fitted_map(several, "d", rising=False, relative=False), 0.0, 1.0)


def closing_time(one: SignalDriver, approach_s: float) -> float:
    """Time from the arrival of a signal to that of the hand."""
    n = int(approach_s / DT)
    driven(one, np.linspace(0.4, 0.1, n))
    after = driven(one, np.full(400, 0.09))
    return DT * int(np.searchsorted(after, 0.999))


def test_who_comes_soon_closes_soon() -> None:
    fast, slow = (closing_time(SignalDriver(paced()), approach) for approach in (0.4, 0.8))
    assert slow / fast > 1.3  # at the usual pace the fast one, which lags behind, would take longer


def test_who_waits_first_closes_as_usual() -> None:
    """Waiting at rest is no part of the movement, and nobody took so long to begin."""
    one = SignalDriver(paced())
    driven(one, np.full(500, 0.4))
    assert one.state.elapsed == 0.0
    assert closing_time(one, 0.4) == pytest.approx(closing_time(SignalDriver(paced()), 0.4))
    late = SignalDriver(paced())
    driven(late, np.full(500, 0.39))
    assert late.state.elapsed > 4
    driven(late, [0.1])
    assert late.state.duration is None


def test_the_pace_is_that_of_one_movement() -> None:
    one = SignalDriver(paced())
    closing_time(one, 0.4)
    assert one.state.duration is not None and one.state.passed == 9
    driven(one, np.full(400, 0.4))
    assert (one.state.passed, one.state.duration) == (0, None)


def test_small_returns_are_ignored_and_great_ones_followed() -> None:
    one = driver()
    driven(one, np.full(200, 0.6))
    assert one.progress == pytest.approx(0.6)
    assert (driven(one, 0.6 + 0.04 * np.sin(np.arange(300))).min()) == pytest.approx(0.6)
    one.reset()
    driven(one, np.full(200, 0.6))
    back = driven(one, np.full(200, 0.4))
    assert back[-1] == pytest.approx(0.45)  # up to the slack of 0.05
    assert np.diff(back).min() >= -DT - 1e-12  # nor is it faster on the way back
    assert driven(one, [0.42] * 100)[-1] == pytest.approx(0.45)  # and waits for more than that
    assert driven(one, [0.5] * 100)[-1] == pytest.approx(0.5)


def test_noise_within_the_slack_moves_it_one_way_only() -> None:
    rng = np.random.default_rng(0)
    noisy = np.linspace(0.1, 0.9, 400) + rng.uniform(-0.02, 0.02, 400)
    assert np.diff(driven(driver(), noisy)).min() >= 0.0


def test_it_is_held_while_the_signal_is_missing() -> None:
    one = driver()
    driven(one, np.full(200, 0.6))
    held = driven(one, np.full(50, np.nan))
    assert (held == held[0]).all()
    assert held[0] == pytest.approx(0.6)
    assert one.state.unseen == pytest.approx(0.5)
    assert one.step(1.0, DT) <= 0.6 + DT + 1e-12  # the time unseen is no run-up
    assert one.state.unseen == 0.0
    assert driver().step(np.nan, DT) == 0.0
    assert driver().step(np.inf, DT) == 0.0


def test_let_go_it_returns_to_the_start() -> None:
    one = driver()
    driven(one, np.ones(150))
    returned = driven(one, np.zeros(150))
    assert returned[49] == pytest.approx(0.5)
    assert returned[-1] == 0.0
    assert driven(one, np.ones(150))[-1] == 1.0


def test_smoothing_is_causal_and_catches_up_after_a_gap() -> None:
    one = driver(smoothing=0.1, duration=1e-2)
    one.step(0.0, 0.0)
    assert one.step(1.0, 0.1) == pytest.approx(0.5)  # dt / (tau + dt)
    one.step(np.nan, 0.7)
    one.step(1.0, 0.1)
    assert one.state.value == pytest.approx(0.5 + 0.5 * 0.8 / 0.9)


def test_a_share_is_of_the_value_when_the_movement_began() -> None:
    several = [demonstration(d=falling(start, start / 4)) for start in (0.2, 0.4, 0.8)]
    rule = DriverRule(fitted_map(several, "d", rising=False, relative=True), 0.0, 1.0)
    one = SignalDriver(rule)
    driven(one, [0.3, 0.4, 0.6])  # moves away first
    assert one.progress == 0.0
    assert one.state.start == 0.6
    assert driven(one, np.linspace(0.6, 0.375, 300))[-1] == pytest.approx(0.5, abs=0.02)
    driven(one, [0.65])
    assert one.state.start == 0.6  # on its way, it is that of this movement
    assert driven(one, [0.65] * 300)[-1] == 0.0
    one.state = one.state._replace(phase=1e-9)  # as a smoothed signal leaves it
    driven(one, [0.7])
    assert one.state.start == 0.7  # back at the start, a new movement begins


def test_the_rule_is_pure_and_the_driver_deterministic() -> None:
    rng = np.random.default_rng(1)
    signal = np.cumsum(rng.normal(0.0, 0.05, 400))
    signal[rng.integers(0, 400, 40)] = np.nan
    rule = driver(smoothing=0.02).rule
    first, second = SignalDriver(rule), SignalDriver(rule)
    assert driven(first, signal).tolist() == driven(second, signal).tolist()
    before = first.state
    assert rule.after(before, 0.3, DT) == rule.after(before, 0.3, DT)
    assert first.state is before
    first.reset()
    assert first.state == DriverState()


@pytest.mark.parametrize("dt", [-0.01, np.nan, np.inf])
def test_times_that_are_none(dt: float) -> None:
    with pytest.raises(InputError, match="time step"):
        driver().step(0.5, dt)


@pytest.mark.parametrize("field", [{"smoothing": -1.0}, {"speed": 0.0}, {"speed": np.nan}])
def test_rules_that_are_none(field: dict) -> None:
    with pytest.raises(InputError, match="give a number from"):
        DriverRule(driver().rule.map, **field)

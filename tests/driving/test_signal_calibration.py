"""Which map a signal has, and which signals have none."""

import numpy as np
import pytest
from made_up import demonstration, falling

from handsim.driving.driver import DriverRule, SignalDriver
from handsim.driving.signal_calibration import calibrate_signal
from handsim.errors import InputError, UnknownNameError
from handsim.learning.demonstration import SIGNAL_PROGRESS
from handsim.recordings.signals import ENVELOPE, signals_of


def test_the_direction_is_found() -> None:
    several = [demonstration(d=falling(), e=-falling()) for _ in range(4)]
    down, up = calibrate_signal(several, "d"), calibrate_signal(several, "e")
    assert (down.rising, up.rising) == (False, True)
    assert down.explained == pytest.approx(1.0, abs=1e-3)
    assert down.n_recordings == 4
    assert (np.diff(up.phase) >= 0).all()


def test_shares_where_starts_differ_and_values_where_ends_agree() -> None:
    """0.2 m is half way from 0.4 m and a quarter from 0.8; or it is one place for all."""
    shares = [demonstration(d=falling(start, start / 4)) for start in (0.2, 0.3, 0.4, 0.6, 0.8)]
    assert calibrate_signal(shares, "d").relative
    same_end = [
        demonstration(d=np.minimum(falling(0.4, 0.05), start)) for start in np.linspace(0.2, 0.4, 6)
    ]
    assert not calibrate_signal(same_end, "d").relative


def test_recordings_without_the_channel_are_left_out() -> None:
    some = [demonstration(d=falling()), demonstration(), demonstration(d=falling())]
    assert calibrate_signal(some, "d").n_recordings == 2
    assert calibrate_signal(some[:1], "d").explained == pytest.approx(1.0, abs=1e-3)


def test_signals_that_tell_nothing_are_refused_with_how_little() -> None:
    rng = np.random.default_rng(0)
    several = [demonstration(noise=rng.normal(size=101), flat=np.ones(101)) for _ in range(8)]
    with pytest.raises(InputError, match=r"noise says too little .*: -?[0-9] % .* 8 recordings"):
        calibrate_signal(several, "noise")
    with pytest.raises(InputError, match=r"flat says .*: -?0 % .* at least 10 % .* --range"):
        calibrate_signal(several, "flat")


def test_what_is_not_there_is_named() -> None:
    with pytest.raises(UnknownNameError, match="did you mean distance_m"):
        calibrate_signal([demonstration(distance_m=falling())], "distence_m")
    with pytest.raises(InputError, match="hold no channels"):
        calibrate_signal([demonstration()], "distance_m")


def muscles(rng: np.random.Generator, duration: float = 1.5) -> tuple[np.ndarray, np.ndarray]:
    """Envelope (n,) at 500 Hz of 8 muscles, noise whose variance rises with time, and times."""
    time = np.arange(int(500 * duration)) / 500
    strength = 0.05 + 0.95 * time / duration
    noise = rng.normal(size=(len(time), 8)) * np.sqrt(strength)[:, None]
    channels = {f"emg_{i + 1:02}": column for i, column in enumerate(noise.T)}
    return signals_of(time, channels)[ENVELOPE], time


def test_muscle_activity_drives() -> None:
    """Noise of a variance that rises with progress; one trial that the map was not found from."""
    rng = np.random.default_rng(3)
    several = []
    for _ in range(10):
        value, time = muscles(rng)
        over_progress = np.interp(SIGNAL_PROGRESS, time / time[-1], value)
        several.append(demonstration(1.5, **{ENVELOPE: over_progress}))
    made = calibrate_signal(several, ENVELOPE)
    assert made.rising
    assert made.explained is not None and made.explained > 0.85
    value, time = muscles(rng)
    driver = SignalDriver(DriverRule(made))
    driven = np.array([driver.step(v, 1 / 500) for v in value])
    assert np.sqrt(np.mean((driven - time / time[-1]) ** 2)) < 0.12
    assert driven[-1] > 0.85
    resting = 0.05 * np.abs(rng.normal(size=1500))
    assert [driver.step(v, 1 / 500) for v in resting][-1] == 0.0  # let go

"""Signals that are derived from the channels of a recording."""

import numpy as np
import pytest

from handsim.recordings.signals import envelope, low_passed, signals_of

TIME = np.arange(4) / 100


def place(name: str, x: float, y: float, z: float) -> dict[str, np.ndarray]:
    return {
        f"{name}_{axis}_m": np.full(4, value) for axis, value in zip("xyz", (x, y, z), strict=True)
    }


def test_the_distance_from_palm_to_object() -> None:
    palm = place("palm", 0.0, 0.0, 0.0)
    both = palm | place("object", 0.3, 0.4, 1.2) | place("lamp", 9.0, 9.0, 9.0)
    both["object_x_m"][1] = np.nan
    distance = signals_of(TIME, both)["distance_m"]
    np.testing.assert_allclose(distance[[0, 2, 3]], 1.3)
    assert np.isnan(distance[1])


def test_without_an_object_the_only_other_thing_is_meant() -> None:
    palm = place("palm", 0.0, 0.0, 0.0) | place("elbow", 1.0, 1.0, 1.0)
    handle, lamp = place("handle", 0.0, 3.0, 4.0), place("lamp", 1.0, 1.0, 1.0)
    np.testing.assert_allclose(signals_of(TIME, palm | handle)["distance_m"], 5.0)
    assert "distance_m" not in signals_of(TIME, palm)
    assert "distance_m" not in signals_of(TIME, palm | handle | lamp)
    assert "distance_m" not in signals_of(TIME, handle)


def test_what_was_recorded_under_a_derived_name_stays() -> None:
    channels = place("palm", 0, 0, 0) | place("object", 1, 0, 0) | {"distance_m": np.full(4, 7.0)}
    assert signals_of(TIME, channels)["distance_m"].tolist() == [7.0] * 4


def test_the_envelope_is_rectified_and_low_passed() -> None:
    time = np.arange(2000) / 1000
    beat = np.where(np.arange(2000) % 2, 1.0, -1.0)
    after = envelope(time, np.column_stack([beat, 3.0 * beat]))
    np.testing.assert_allclose(after, 2.0)
    step = np.where(time < 1.0, 0.0, 1.0)[:, None]
    risen = envelope(time, step)
    assert risen[999] == 0.0  # causal
    assert risen[1000 + 100] == pytest.approx(1 - np.exp(-1), abs=0.01)  # 0.1 s
    assert signals_of(time, {"emg_1": beat})["emg_envelope"][5] == 1.0


def test_gaps_of_muscle_activity_are_gaps() -> None:
    activity = np.ones((50, 2))
    activity[10:20, 0] = np.nan
    after = envelope(np.arange(50) / 100, activity)
    assert np.isnan(after[10:20]).all()
    np.testing.assert_allclose(np.delete(after, range(10, 20)), 1.0)


def test_the_low_pass_takes_steps_of_any_length() -> None:
    assert low_passed(0.0, 1.0, 0.1, 0.1) == 0.5
    assert low_passed(0.0, 1.0, 0.1, 0.0) == 1.0
    assert low_passed(0.2, 1.0, 0.0, 0.0) == 0.2

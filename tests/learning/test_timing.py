"""The natural time law."""

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.timing import NaturalTiming, minimum_jerk


def straight(z: np.ndarray, z_goal: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(z_goal - z)
    return (z_goal - z) / length if length > 0 else 0 * z


def test_minimum_jerk_profile() -> None:
    time = np.linspace(-0.5, 3.0, 3501)
    s = minimum_jerk(time, 2.0)
    assert (s[time <= 0] == 0).all() and (s[time >= 2] == 1).all()
    np.testing.assert_allclose(s + minimum_jerk(2.0 - time, 2.0), 1.0, atol=1e-12)
    speed = np.gradient(s, time)
    assert speed.max() == pytest.approx(1.875 / 2.0, rel=1e-4)  # 15/8 of the mean


def closed_loop(timing: NaturalTiming, z: np.ndarray, seconds: float, push_at: float = -1.0):
    states, dt = [z.copy()], 0.002
    for i in range(int(seconds / dt)):
        if i == int(push_at / dt):
            z = z + np.array([0.0, np.deg2rad(20.0)])
        z = z + dt * timing.velocity(z, i * dt)
        states.append(z.copy())
    return np.array(states)


def test_closed_loop_follows_the_profile_and_arrives_in_time() -> None:
    start, goal = np.array([1.0, 0.5]), np.zeros(2)
    path = np.linspace(start, goal, 60)
    timing = NaturalTiming.along(path, goal, 2.0, straight)
    states = closed_loop(timing, start, 2.0)
    covered = 1 - np.linalg.norm(states, axis=1) / np.linalg.norm(start)
    np.testing.assert_allclose(covered, minimum_jerk(0.002 * np.arange(1001), 2.0), atol=0.01)
    assert np.linalg.norm(states[-1]) < np.deg2rad(1.0)


def test_a_push_is_made_up_for() -> None:
    start, goal = np.array([1.0, 0.5]), np.zeros(2)
    timing = NaturalTiming.along(np.linspace(start, goal, 60), goal, 2.0, straight)
    states = closed_loop(timing, start, 2.2, push_at=0.9)
    assert np.linalg.norm(states[-1]) < np.deg2rad(1.0)


def test_length_left_beyond_the_path_and_where_it_turns_away() -> None:
    goal = np.zeros(2)
    detour = np.array([[1.0, 0.0], [1.5, 0.0], [1.5, 1.0], [0.0, 1.0], [0.0, 0.0]])
    timing = NaturalTiming.along(detour, goal, 1.0, straight)
    assert (np.diff(timing.distance) > 0).all() and (np.diff(timing.left) > 0).all()
    at_half = timing._rate(0.5)
    far = np.linalg.norm(timing.velocity(np.array([5.0, 0.0]), 0.5)) / at_half
    assert far == pytest.approx(timing.left[-1] + 5.0 - timing.distance[-1])


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_bad_durations(duration: float) -> None:
    with pytest.raises(InputError, match="positive number of seconds"):
        NaturalTiming.along(np.eye(2), np.zeros(2), duration, straight)

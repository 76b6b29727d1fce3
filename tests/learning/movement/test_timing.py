"""Velocities of closed loops: along a flow, and along a guide."""

import numpy as np
import pytest

from handsim.learning.guide.field import GuidedField
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk
from handsim.learning.movement.timing import FieldTiming, GuidedTiming, Timing

DT = 0.002


def straight(z: np.ndarray, z_goal: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(z_goal - z)
    return (z_goal - z) / length if length > 0 else 0 * z


def closed_loop(
    timing: Timing, z: np.ndarray, seconds: float, push_at: float = -1.0, late: int = 0
) -> np.ndarray:
    """Integrate velocities of readings that are ``late`` steps old."""
    states = [z.copy()]
    for i in range(int(seconds / DT)):
        if i == int(push_at / DT):
            z = z + np.array([0.0, np.deg2rad(20.0)])
        z = z + DT * timing.velocities(states[max(0, i - late)][None], i * DT)[0]
        states.append(z.copy())
    return np.array(states)


def test_closed_loop_follows_the_profile_and_arrives_in_time() -> None:
    start, goal = np.array([1.0, 0.5]), np.zeros(2)
    path = np.linspace(start, goal, 60)
    timing = FieldTiming.along(path, goal, ProgressLaw(2.0), straight)
    states = closed_loop(timing, start, 2.0)
    covered = 1 - np.linalg.norm(states, axis=1) / np.linalg.norm(start)
    np.testing.assert_allclose(covered, minimum_jerk(DT * np.arange(1001), 2.0), atol=0.01)
    assert np.linalg.norm(states[-1]) < np.deg2rad(1.0)


def test_a_push_is_made_up_for() -> None:
    start, goal = np.array([1.0, 0.5]), np.zeros(2)
    timing = FieldTiming.along(np.linspace(start, goal, 60), goal, ProgressLaw(2.0), straight)
    states = closed_loop(timing, start, 2.2, push_at=0.9)
    assert np.linalg.norm(states[-1]) < np.deg2rad(1.0)


def test_length_left_beyond_the_path_and_where_it_turns_away() -> None:
    goal = np.zeros(2)
    detour = np.array([[1.0, 0.0], [1.5, 0.0], [1.5, 1.0], [0.0, 1.0], [0.0, 0.0]])
    timing = FieldTiming.along(detour, goal, ProgressLaw(1.0), straight)
    assert (np.diff(timing.distance) > 0).all() and (np.diff(timing.left) > 0).all()
    far = np.linalg.norm(timing.velocities(np.array([[5.0, 0.0]]), 0.5)) / timing.law.closing(0.5)
    assert far == pytest.approx(timing.left[-1] + 5.0 - timing.distance[-1])


def retracing() -> np.ndarray:
    """A path that goes out and comes back over itself before it goes to the side."""
    out = np.linspace([0.0, 0.0], [1.0, 0.0], 50)
    back = np.linspace([1.0, 0.0], [0.5, 0.0], 26)[1:]
    aside = np.linspace([0.5, 0.0], [0.5, 0.5], 26)[1:]
    return np.vstack([out, back, aside])


def guided() -> GuidedTiming:
    box = np.full(2, 2.0)
    return GuidedTiming(
        GuidedField.leading(retracing(), -box, box, np.full(2, 0.2), 4.0, 2.0), ProgressLaw(2.0)
    )


def test_a_guide_that_goes_back_over_itself_is_followed_in_time() -> None:
    timing = guided()
    states = closed_loop(timing, np.zeros(2), 2.0)
    wanted = timing.field.guide.at(minimum_jerk(DT * np.arange(1001), 2.0))
    assert np.abs(states - wanted).max() < np.deg2rad(1.0)


def test_a_push_off_the_guide_is_made_up_for_even_when_readings_are_40_ms_old() -> None:
    timing = guided()
    on_time = closed_loop(timing, np.zeros(2), 2.2, push_at=0.9)
    late = closed_loop(timing, np.zeros(2), 2.2, push_at=0.9, late=20)
    for states in (on_time, late):
        assert np.linalg.norm(states[-1] - timing.field.z_goal) < np.deg2rad(1.5)
        assert np.linalg.norm(np.diff(states[500:], axis=0), axis=1).max() < DT * 6.0
    off = np.linalg.norm(on_time - timing.field.guide.at(minimum_jerk(DT * np.arange(1101), 2.0)),
                         axis=1)  # fmt: skip
    assert off[451] == pytest.approx(np.deg2rad(20.0), rel=0.05)
    assert (np.diff(off[460:900]) < 1e-4).all()  # it only comes nearer

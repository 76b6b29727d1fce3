"""Averaging of recordings between like ends."""

import numpy as np
import pytest

from handsim.learning.direction.averaging import averaged
from handsim.navigation.paths import path_error

S = np.linspace(0, 1, 100)[:, None]


def arch(start: np.ndarray, goal: np.ndarray, height: float) -> np.ndarray:
    return start + S * (goal - start) + height * np.sin(np.pi * S) * np.array([0.0, 0.0, 1.0])


def test_ends_stay_where_they_were_recorded() -> None:
    rng = np.random.default_rng(0)
    paths = [np.cumsum(rng.normal(size=(50, 3)), axis=0) for _ in range(6)]
    for before, after in zip(paths, averaged(paths, 5.0), strict=True):
        np.testing.assert_allclose(after[[0, -1]], before[[0, -1]], atol=1e-12)
        assert path_error(after, before) > 0.1


def test_chance_is_averaged_out() -> None:
    """The same movement with chance about it comes nearer to what is common to all."""
    rng = np.random.default_rng(1)
    start, goal = np.zeros(3), np.array([1.0, 0.0, 0.0])
    heights = 0.5 + 0.1 * rng.normal(size=40)
    paths = averaged([arch(start, goal, h) for h in heights], 0.2)
    tops = np.array([path[:, 2].max() for path in paths])
    assert tops.std() < 0.05 * heights.std()
    assert tops.mean() == pytest.approx(heights.mean(), abs=0.01)


@pytest.mark.parametrize("moved", ["start", "goal"])
def test_movements_between_other_ends_are_left_alone(moved: str) -> None:
    start, goal, away = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 5.0, 0.0])
    other = (away, goal) if moved == "start" else (start, away)
    paths = [arch(start, goal, 0.5), arch(*other, -0.5)]
    for before, after in zip(paths, averaged(paths, 0.5), strict=True):
        assert path_error(after, before) < 0.01
    assert path_error(averaged(paths, 50.0)[0], paths[0]) > 0.1


def test_a_recording_counts_twice_where_it_has_company() -> None:
    start, goal = np.zeros(3), np.array([1.0, 0.0, 0.0])
    high, low = averaged([arch(start, goal, 0.6), arch(start, goal, 0.0)], 0.1)
    assert high[:, 2].max() == pytest.approx(0.4, abs=1e-3)
    assert low[:, 2].max() == pytest.approx(0.2, abs=1e-3)


def test_no_reach_leaves_recordings_as_they_are() -> None:
    paths = [arch(np.zeros(3), np.ones(3), 0.5)] * 2
    assert averaged(paths, 0.0) is paths


def test_many_recordings_go_in_portions(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    ends = rng.uniform(0, 1, (30, 2, 3))
    paths = [arch(a, b, h) for (a, b), h in zip(ends, rng.normal(size=30), strict=True)]
    whole = averaged(paths, 0.5)
    monkeypatch.setattr("handsim.learning.direction.averaging._AT_ONCE", 7)
    np.testing.assert_allclose(averaged(paths, 0.5), whole, atol=1e-12)
    assert np.abs(np.array(whole) - paths).max() > 0.1

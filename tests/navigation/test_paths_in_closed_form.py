"""When a path has arrived, got stuck or is given up, and between which ends it lies."""

import numpy as np
import pytest

from handsim.navigation.flow import ARRIVAL, STEP, follow
from handsim.navigation.paths import N_COMPARED, arc_length, between_ends, path_error


def towards(target: np.ndarray):
    """Return the field of unit vectors towards a place, whatever the destination."""

    def directions(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        away = target - z
        return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)

    return directions


def test_what_is_compared_and_when_a_path_has_arrived() -> None:
    """As the paper: 100 points. 4 deg is what a glove of 1 deg steps leaves of 22 joints."""
    assert N_COMPARED == 100
    assert np.rad2deg([ARRIVAL, STEP]) == pytest.approx([4.0, 1.0])


@pytest.mark.parametrize(("off_deg", "arrives"), [(3.9, True), (4.1, False), (7.9, False)])
def test_a_path_arrives_within_four_degrees(off_deg: float, arrives: bool) -> None:
    """The flow ends at a place beside the destination, where it turns on the spot."""
    goal, beside = np.array([1.0, 0.0]), np.array([1.0, np.deg2rad(off_deg)])
    path = follow(towards(beside), np.array([[0.0, np.deg2rad(off_deg)]]), goal)[0]
    assert path.arrived is arrives
    assert path.reason == ("arrived" if arrives else "stuck")
    assert np.array_equal(path.points[-1], goal) is arrives
    last = path.points[-2 if arrives else -1]
    assert np.linalg.norm(last - beside) < 2 * STEP


def test_arc_length_is_that_of_all_dimensions_together() -> None:
    path = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 4.0], [0.0, 8.0]])
    np.testing.assert_allclose(arc_length(path), [0.0, 5.0, 5.0, 10.0])


def test_the_error_is_the_root_of_the_mean_square() -> None:
    """Two lines that open from 0 to an apartness of (3, 4) h: 5 h s at s, s^2 is a third."""
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    opened = np.array([[0.0, 0.0, 0.0], [1.0, 0.03, 0.04]])
    s = np.linspace(0, 1, 100)
    assert path_error(opened, line) == pytest.approx(0.05 * np.sqrt(np.mean(s**2)))
    assert path_error(line, opened) == path_error(opened, line)


def test_ends_are_moved_and_what_is_between_by_its_share() -> None:
    s = np.linspace(0.0, 1.0, 100)[:, None]
    line = np.outer(np.linspace(0, 1, 7) ** 2, [2.0, 0.0])
    start, goal = np.array([0.0, 0.3]), np.array([3.0, -0.1])
    moved = between_ends(line, start, goal)
    assert moved.shape == (100, 2)
    np.testing.assert_array_equal(moved[[0, -1]], [start, goal])
    np.testing.assert_allclose(moved, s * [2.0, 0.0] + (1 - s) * [0.0, 0.3] + s * [1.0, -0.1])


def orbit(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Round and round the origin."""
    return np.column_stack([-z[:, 1], z[:, 0]]) / np.linalg.norm(z, axis=1, keepdims=True)


@pytest.mark.parametrize(("far", "expected"), [(1.0, 8 * np.pi / 2), (3.0, 8 * np.hypot(1, 3))])
def test_a_path_is_given_up_after_eight_times_its_distance_or_a_right_angle(
    far: float, expected: float
) -> None:
    goal = np.array([0.0, far]) if far > 1 else np.array([0.0, 0.0])
    path = follow(orbit, np.array([[1.0, 0.0]]), goal)[0]
    assert path.reason == "too long" and not path.arrived
    assert arc_length(path.points)[-1] == pytest.approx(expected, rel=0.01)
    short = follow(orbit, np.array([[1.0, 0.0]]), goal, longest=2.0)[0]
    assert arc_length(short.points)[-1] == pytest.approx(expected / 4, rel=0.01)


def test_all_paths_are_given_the_length_of_the_farthest() -> None:
    starts, goals = np.array([[1.0, 0.0]] * 2), np.array([[0.0, 0.0], [0.0, 3.0]])
    for path in follow(orbit, starts, goals):
        assert arc_length(path.points)[-1] == pytest.approx(8 * np.hypot(1, 3), rel=0.01)


def test_steps_are_of_a_degree_and_shorter_near_the_destination() -> None:
    """From 20.2 steps away 19 whole ones, then half of the 1.2 that are left, and it is near."""
    goal = np.array([20.2 * STEP, 0.0])
    path = follow(towards(goal), np.array([[0.0, 0.0]]), goal)[0]
    steps = np.diff(arc_length(path.points)) / STEP
    np.testing.assert_allclose(steps, [*[1.0] * 19, 0.6, 0.6], rtol=1e-9)
    assert path.reason == "arrived"


def test_a_slow_path_is_not_stuck_and_a_trapped_one_is_after_fifty_steps() -> None:
    """It drifts to and fro: a fifth of its steps onwards is movement, a twentieth is none."""

    def drifting(share: float):
        def directions(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
            across = np.where(z[:, 1] > 0, -1.0, 1.0)
            return np.column_stack([np.full(len(z), share), across]) / np.hypot(share, 1.0)

        return directions

    goal, start = np.array([0.0, 3.0]), np.array([[0.0, 0.0]])
    assert follow(drifting(0.4), start, goal)[0].reason == "too long"
    stuck = follow(drifting(0.02), start, goal)[0]
    assert stuck.reason == "stuck"
    assert len(stuck.points) == 51


def test_paths_end_each_on_its_own() -> None:
    """One arrives at once, one later, one is caught: none changes the others."""
    trap = np.array([0.0, 1.0])

    def directions(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        caught = goals[:, 1:] > 2.0
        away = np.where(caught, trap, goals) - z
        return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)

    starts = np.array([[0.005, 0.0], [1.0, 0.0], [0.0, 0.5], [0.3, 0.4]])
    goals = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 3.0], [0.0, 0.0]])
    together = follow(directions, starts, goals)
    assert [path.reason for path in together] == ["arrived", "arrived", "stuck", "arrived"]
    assert len(together[0].points) == 2
    np.testing.assert_array_equal(together[0].points, [starts[0], goals[0]])
    for path, start, goal in zip(together, starts, goals, strict=True):
        alone = follow(directions, start[None], goal[None])[0]
        np.testing.assert_array_equal(path.points, alone.points)
    assert arc_length(together[1].points)[-1] == pytest.approx(1.0)
    assert arc_length(together[3].points)[-1] == pytest.approx(0.5)

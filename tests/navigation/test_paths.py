"""Paths: arc length, path error in closed form, following known flows."""

import numpy as np
import pytest

from handsim.navigation.flow import ARRIVAL, follow
from handsim.navigation.paths import arc_length, at_arc_length, path_error


def circle(angle: float, n: int = 400) -> np.ndarray:
    t = np.linspace(0.0, angle, n)
    return np.column_stack([np.cos(t), np.sin(t)])


def test_arc_length_and_even_points_of_a_circle() -> None:
    quarter = circle(np.pi / 2)
    assert arc_length(quarter)[-1] == pytest.approx(np.pi / 2, rel=1e-5)
    middle = at_arc_length(quarter, np.array([0.5]))[0]
    np.testing.assert_allclose(middle, [np.sqrt(0.5)] * 2, atol=1e-5)


def test_path_error_in_closed_form_whatever_the_sampling() -> None:
    line = np.outer(np.linspace(0, 1, 7) ** 2, [3.0, 0.0])
    shifted = np.outer(np.linspace(0, 1, 31), [3.0, 0.0]) + [0.0, 0.4]
    assert path_error(line, shifted) == pytest.approx(0.4)
    twice = np.outer(np.linspace(0, 1, 9), [6.0, 0.0])
    # Mean square of 3 s over s in [0, 1] at 100 points.
    s = np.linspace(0, 1, 100)
    assert path_error(line, twice) == pytest.approx(3 * np.sqrt(np.mean(s**2)))


def straight(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
    away = goals - z
    return away / np.linalg.norm(away, axis=1, keepdims=True)


def test_straight_flow_arrives_straight() -> None:
    starts = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 1.0], [0.001, 0.0, 0.0]])
    for path, start in zip(follow(straight, starts, np.zeros(3)), starts, strict=True):
        assert path.arrived and path.reason == "arrived"
        np.testing.assert_array_equal(path.points[[0, -1]], [start, np.zeros(3)])
        assert path_error(path.points, np.array([start, np.zeros(3)])) < 1e-9


def test_circular_flow_is_followed_to_second_order() -> None:
    def around(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        turned = np.column_stack([-z[:, 1], z[:, 0]])
        return turned / np.linalg.norm(turned, axis=1, keepdims=True)

    errors = []
    for step in (0.1, 0.05):
        path = follow(around, np.array([[1.0, 0.0]]), np.array([-1.0, 0.0]), step)[0]
        there = path.points[round(2.4 / step)]
        errors.append(np.linalg.norm(there - [np.cos(2.4), np.sin(2.4)]))
    assert errors[0] < 0.005
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_a_trap_and_an_orbit_are_results_with_reasons() -> None:
    trap = np.array([0.5, 0.0])

    def trapped(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return straight(z, np.broadcast_to(trap, z.shape))

    stuck = follow(trapped, np.array([[0.0, 0.8]]), np.array([3.0, 0.0]))[0]
    assert not stuck.arrived and stuck.reason == "stuck"
    assert np.linalg.norm(stuck.points[-1] - trap) < 2 * ARRIVAL

    def orbit(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return np.column_stack([-z[:, 1], z[:, 0]]) / np.linalg.norm(z, axis=1, keepdims=True)

    lost = follow(orbit, np.array([[1.0, 0.0]]), np.array([3.0, 0.0]))[0]
    assert not lost.arrived and lost.reason == "too long"

"""Destinations and starts at the boundary of the workspace."""

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.learning.controller import GraspController


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


def corners(controller, inset: float):
    """The corners of the box of destinations and the middles of its faces, moved inwards."""
    low, high = controller.reach
    middle, half = (low + high) / 2, (high - low) / 2
    n = len(low)
    signs = np.array(np.meshgrid(*[[-1, 1]] * n)).reshape(n, -1).T
    return middle + np.vstack([signs, np.eye(n), -np.eye(n)]) * half * (1 - inset)


@pytest.mark.parametrize("inset", [1e-6, 1e-3, 0.05])
def test_just_inside_there_is_a_movement_or_a_reason(controller, inset):
    start = controller.demonstrations[0].q_start
    for goal in corners(controller, inset):
        made = controller.postures(start, z_goal=goal, rate=20.0)
        assert np.isfinite(made.q).all()
        assert made.reason in ("arrived", "stuck", "too long", "clipped")
        assert made.arrived == (made.reason == "arrived")
        away = np.rad2deg(made.goal_distance)
        assert away <= 4 if made.arrived else made.reason != "clipped" or away > 4


@pytest.mark.parametrize("inset", [1e-12, 0.0, -1e-9, -0.1, -1e6])
def test_on_the_boundary_and_beyond_there_is_none(controller, inset):
    start = controller.demonstrations[0].q_start
    for goal in corners(controller, inset):
        with pytest.raises(InputError, match=r"outside the workspace|not positive"):
            controller.postures(start, z_goal=goal)


@pytest.mark.parametrize("inset", [0.0, -0.5, -5.0])
def test_starts_at_the_boundary_and_beyond_come_inside(controller, inset):
    goal = controller.demonstrations[0].z_goal
    for start in corners(controller, inset):
        path = controller.path(start, goal)
        assert np.isfinite(path.points).all()
        assert path.arrived or path.reason in ("stuck", "too long")


def test_values_that_are_no_numbers_are_refused(controller):
    one = controller.demonstrations[0]
    for value in (np.nan, np.inf):
        with pytest.raises(InputError):
            controller.postures(np.full(22, value), one.q_goal)
        with pytest.raises(InputError):
            controller.postures(one.q_start, np.full(22, value))

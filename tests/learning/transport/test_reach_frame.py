import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.transport.reach_frame import ReachFrame, rise_of

START, GOAL = np.array([0.1, 0.2, 0.4]), np.array([0.4, 0.6, 0.3])


def test_the_destination_is_the_origin_and_the_start_is_level_behind_it() -> None:
    frame = ReachFrame.of(START, GOAL)
    assert frame.inside(GOAL) == pytest.approx(np.zeros(3))
    distance = np.sqrt(0.25 + 0.01)
    assert frame.inside(START) == pytest.approx(np.array([-0.5, 0, 0.1]) / distance)
    assert frame.inside(GOAL + [0, 0, 0.1]) == pytest.approx([0, 0, 0.1 / distance])  # up is up


def test_there_and_back() -> None:
    places = np.random.default_rng(0).normal(size=(5, 3))
    for rises in ((-np.pi / 2, np.pi / 2), (0.0, 0.1)):
        frame = ReachFrame.of(START, GOAL, rises)
        assert frame.outside(frame.inside(places)) == pytest.approx(places)
        assert frame.axes.T @ frame.axes == pytest.approx(np.eye(3))
        assert np.linalg.det(frame.axes) == pytest.approx(1.0)


def test_reaches_that_differ_by_place_heading_and_length_are_one() -> None:
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    path = START + np.linspace(0, 1, 9)[:, None] ** [1, 2, 3] * (GOAL - START)
    other = 2.5 * path @ turn.T + [1, 2, 3]
    one, two = (ReachFrame.of(p[0], p[-1]).inside(p) for p in (path, other))
    assert one == pytest.approx(two)


def test_steeper_than_any_learned_is_turned_into_the_steepest() -> None:
    down = ReachFrame.of(np.array([0, 0, 0.3]), np.array([0, 0, 0.1]), (-0.5, 0.2))
    start = down.inside(np.array([0, 0, 0.3]))
    assert rise_of(np.array([start, [0, 0, 0]])) == pytest.approx(-0.5)
    assert np.linalg.norm(start) == pytest.approx(1.0)
    within = ReachFrame.of(START, GOAL, (-0.5, 0.2))
    assert within.axes == pytest.approx(ReachFrame.of(START, GOAL).axes)


def test_a_reach_of_nothing_has_no_frame() -> None:
    with pytest.raises(InputError, match="4 mm has no direction"):
        ReachFrame.of(START, START + [0, 0, 0.004])

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.movement.progress import minimum_jerk
from handsim.learning.transport.transport import Transport, learn_transport
from handsim.learning.transport.walls import Ball, Plane
from handsim.navigation.paths import at_arc_length, path_error

UP = np.array([0.0, 0.0, 1.0])


def arc(seed: int, n: int = 60) -> np.ndarray:
    """A reach of some 25 cm that bends to its left and goes up by 4 cm on its way."""
    rng = np.random.default_rng(seed)
    start = rng.normal(scale=0.02, size=3)
    heading = rng.uniform(-0.4, 0.4)
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    length, s = rng.uniform(0.2, 0.3), np.linspace(0.0, 1.0, n)[:, None]
    bump = np.sin(np.pi * s)
    return start + length * (s * (ahead - 0.2 * UP) + bump * (0.12 * left + 0.16 * UP))


def timed(path: np.ndarray) -> np.ndarray:
    """The same path with minimum jerk, at equal steps of time."""
    return at_arc_length(path, minimum_jerk(np.linspace(0, 1, len(path)), 1.0))


@pytest.fixture(scope="module")
def transport() -> Transport:
    paths = [timed(arc(seed)) for seed in range(8)]
    times = [np.linspace(2.0, 3.0 + 0.1 * i, len(path)) for i, path in enumerate(paths)]
    return learn_transport(paths, times)


@pytest.mark.parametrize("seed", [20, 21, 22])
def test_a_new_reach_is_bent_as_those_learned(transport, seed) -> None:
    path = arc(seed)
    made = transport.reach(path[0], path[-1])
    assert made.path.arrived
    assert made.proved
    assert made.path.points[[0, -1]] == pytest.approx(path[[0, -1]])
    assert path_error(made.path.points, path) < 0.4 * path_error(path[[0, -1]], path)


def test_every_start_is_proved_to_arrive(transport) -> None:
    assert transport.certificate.certified
    assert transport.certificate.supremum.upper < 2


def test_time_is_the_mean_of_the_recordings(transport) -> None:
    assert transport.duration == pytest.approx(1.35)
    path = arc(20)
    made = transport.reach(path[0], path[-1], duration=2.0)
    places = made.at(np.array([0.0, 1.0, 2.0, 3.0]))
    assert places[[0, 2, 3]] == pytest.approx(path[[0, -1, -1]])
    way = np.linalg.norm(places[1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    assert way == pytest.approx(0.5, abs=0.1)


def test_a_table_is_kept_off_and_changes_nothing_of_the_proof(transport) -> None:
    start, goal = np.array([-0.25, 0.0, 0.012]), np.array([0.0, 0.0, 0.02])
    table = Plane(np.zeros(3), UP, 0.06)
    made = transport.reach(start, goal, [table])
    assert made.path.arrived
    assert made.proved
    assert made.n_walls == 1
    assert made.path.points[:, 2].min() > 0.005
    free = transport.reach(start, goal)
    assert made.path.points[:, 2].mean() > free.path.points[:, 2].mean()


def test_a_thing_in_the_way_is_gone_around_without_a_proof(transport) -> None:
    start, goal = np.array([-0.3, 0.0, 0.05]), np.array([0.0, 0.0, 0.05])
    middle = transport.reach(start, goal).at(np.array([0.5 * transport.duration]))[0]
    ball = Ball(middle + [0.0, 0.01, 0.0], 0.03, 0.04)
    made = transport.reach(start, goal, [ball])
    assert made.path.arrived
    assert not made.proved
    assert np.linalg.norm(made.path.points - ball.centre, axis=1).min() > 0.03


def test_what_is_reached_for_is_no_obstacle(transport) -> None:
    goal = np.array([0.0, 0.0, 0.05])
    made = transport.reach(np.array([-0.3, 0.0, 0.05]), goal, [Ball(goal, 0.04, 0.02)])
    assert made.n_walls == 0
    assert made.path.arrived


def test_a_palm_in_a_loop_arrives_and_answers_a_push(transport) -> None:
    start, goal = np.array([0.05, -0.25, 0.1]), np.array([0.0, 0.0, 0.05])
    made = transport.reach(start, goal, duration=1.0)
    place, step = start.copy(), 0.01
    for k in range(110):
        if k == 40:
            in_time = made.at(np.array([k * step]))[0]
            assert np.linalg.norm(place - in_time) < 0.01
            place = place + [0.03, 0.0, 0.0]
        place = place + step * made.velocity(place, k * step)
    assert np.linalg.norm(place - goal) < 0.005


def test_straight_down_is_a_reach_too(transport) -> None:
    made = transport.reach(np.array([0.0, 0.0, 0.3]), np.array([0.0, 0.0, 0.1]))
    assert made.path.arrived


@pytest.mark.parametrize(
    ("paths", "times", "said"),
    [
        ([], [], "0 paths"),
        ([np.zeros((5, 3))], [], "1 paths and 0"),
        ([np.zeros((5, 2))], [np.arange(5.0)], "shape"),
        ([np.zeros((5, 3))], [np.arange(4.0)], "shape"),
        ([np.full((5, 3), np.nan)], [np.arange(5.0)], "gaps"),
        ([np.zeros((5, 3))], [np.arange(5.0)], "no direction"),
        ([np.arange(15.0).reshape(5, 3)], [np.zeros(5)], "time"),
    ],
)
def test_paths_that_teach_nothing_are_refused(paths, times, said) -> None:
    with pytest.raises(InputError, match=said):
        learn_transport(paths, times)

import numpy as np
import pytest

from handsim.learning.transport.walls import Ball, Plane, WalledObstacle, keep_off
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle

UP = np.array([0.0, 0.0, 1.0])
GOAL = np.zeros(3)
TABLE = Plane(np.array([0.0, 0.0, -0.4]), UP, 0.3)
BALL = Ball(np.array([-1.2, 0.0, 0.02]), 0.3, 0.3)


@pytest.fixture(scope="module")
def learned() -> ExponentialObstacle:
    basis = TensorBasis.uniform([-4, -4, -4], [2, 4, 4], (6, 6, 6))
    c = 0.1 * np.random.default_rng(0).normal(size=basis.n_coefficients)
    return ExponentialObstacle(TensorBSpline(basis, c), np.full(3, 0.2))


def test_derivatives_are_those_of_differences(learned) -> None:
    obstacle, h = WalledObstacle(learned, (TABLE, BALL)), 1e-5
    z = np.array([[-1.0, 0.2, -0.3], [-0.8, 0.1, 0.1], [-1.2, 0.35, 0.1], [-2.0, 0.0, 1.0]])
    _, grad, hess = obstacle.log_jets(z, 4.0, 2)
    for i in range(3):
        step = h * np.eye(3)[i]
        more, less = (obstacle.log_jets(z + s * step, 4.0, 2) for s in (1, -1))
        assert (more[0] - less[0]) / (2 * h) == pytest.approx(grad[:, i], rel=1e-5, abs=1e-6)
        assert (more[1] - less[1]) / (2 * h) == pytest.approx(hess[:, i], rel=1e-4, abs=1e-5)
    assert obstacle.evaluator(4.0)(z[0].tolist())[1:] == pytest.approx(grad[0].tolist())


@pytest.mark.parametrize("walls", [(TABLE,), (BALL,), (TABLE, BALL), ()])
def test_one_point_at_a_time_says_the_same(learned, walls) -> None:
    obstacle = WalledObstacle(learned, walls)
    z = np.random.default_rng(3).uniform(-0.8, 0.8, (200, 3)) + BALL.centre
    z = np.concatenate([z, [BALL.centre], [BALL.centre + 1e-9]])
    value, grad, _ = obstacle.log_jets(z, 4.0, 1)
    one = np.array([obstacle.evaluator(4.0)(each) for each in z.tolist()])
    np.testing.assert_allclose(one[:, 0], value, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(one[:, 1:], grad, rtol=1e-9, atol=1e-9)
    if walls:
        apart = np.abs(value - learned.log_jets(z, 4.0, 0)[0]) > 0.01
        assert 10 < apart.sum() < 190, "in the layers and beyond them"


def test_beyond_the_layers_nothing_has_changed(learned) -> None:
    z = np.array([[-1.0, 1.0, 0.0], [0.5, 0.0, 1.0]])
    plain, walled = (o.log_jets(z, 4.0, 1)[1] for o in (learned, WalledObstacle(learned, (TABLE,))))
    assert walled.tolist() == plain.tolist()


def test_paths_keep_off_the_table_and_around_the_ball(learned) -> None:
    starts = np.array([[-2.5, 0.3, -0.35], [-2.5, 0.0, 0.05], [-2.5, -0.5, 0.8]])
    field = NavigationFunction(WalledObstacle(learned, (TABLE, BALL)), 4.0)
    for found in follow(field.directions, starts, GOAL[None]):
        assert found.arrived
        assert (TABLE.distance(found.points)[0] > 0).all()
        assert (BALL.distance(found.points)[0] > 0).all()
    without = follow(NavigationFunction(learned, 4.0).directions, starts[1:2], GOAL[None])[0]
    assert (BALL.distance(without.points)[0] < 0).any()  # the ball is in the way


def test_in_the_layer_of_a_plane_what_descends_descends(learned) -> None:
    z = np.random.default_rng(1).uniform([-3, -2, -0.399], [1, 2, -0.1], (500, 3))
    plain, walled = (o.log_jets(z, 4.0, 1)[1] for o in (learned, WalledObstacle(learned, (TABLE,))))
    assert (((z - GOAL) * (walled - plain)).sum(axis=1) <= 0).all()
    assert TABLE.keeps_descent
    assert not BALL.keeps_descent


def test_a_wall_moves_with_the_frame() -> None:
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    origin, unit = np.array([0.3, -0.2, 0.1]), 0.5
    z = np.random.default_rng(3).normal(size=(10, 3))
    for wall in (TABLE, BALL):
        moved = wall.moved(turn, origin, unit)
        there = (z - origin) @ turn / unit
        assert moved.distance(there)[0] * unit == pytest.approx(wall.distance(z)[0])
        assert moved.width * unit == pytest.approx(wall.width)


def test_layers_leave_the_destination_free() -> None:
    low = Plane(np.array([0.0, 0.0, -0.1]), UP, 0.3)
    inside = Ball(np.array([0.0, 0.1, 0.0]), 0.2, 0.1)
    near = Ball(np.array([0.0, 0.25, 0.0]), 0.2, 0.1)
    kept = keep_off(GOAL, (TABLE, low, inside, near))
    assert [type(wall) for wall in kept] == [Plane, Plane, Ball]
    assert [wall.width for wall in kept] == pytest.approx([0.3, 0.09, 0.045])

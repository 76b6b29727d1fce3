"""The proof for one destination: planted critical points, closed forms, roll-outs, boxes."""

from collections.abc import Callable

import numpy as np
import pytest

from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.certificate import certify
from handsim.navigation.critical_points import critical_points, grid
from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, Obstacle, SplineObstacle
from handsim.navigation.proof import destination
from handsim.navigation.proof.destination import certify_destination

WIDTH = 0.2
K = 3.0
SHAPES = {1: (8,), 2: (8, 7), 3: (6, 5, 7)}


def basis(n: int, degree: int = 3) -> TensorBasis:
    return TensorBasis.uniform(-np.ones(n), 2 * np.ones(n), SHAPES[n], degree)


def random_chi(n: int, seed: int, scale: float) -> TensorBSpline:
    rng = np.random.default_rng(seed)
    return TensorBSpline(basis(n), scale * rng.normal(size=basis(n).shape))


def navigation(chi: TensorBSpline, metric: DestinationMetric | None = None) -> NavigationFunction:
    width = np.full(chi.coefficients.ndim, WIDTH)
    return NavigationFunction(ExponentialObstacle(chi, width), K, metric)


def random_metric(n: int, seed: int) -> DestinationMetric:
    half = 0.6 * np.random.default_rng(seed).normal(size=(2, n, n))
    return DestinationMetric(np.full((1, n), 0.1), half + np.swapaxes(half, 1, 2), 1.0)


def rows(chi: TensorBSpline, z: np.ndarray) -> np.ndarray:
    """Gradient and Hessian at a point as a linear function of the coefficients."""
    n, size = len(z), chi.coefficients.size
    made = np.empty((n + n * n, size))
    for i in range(size):
        _, gradient, hessian = TensorBSpline(chi.basis, np.eye(size)[i]).jets(z[None], 2)
        made[:, i] = np.concatenate([gradient[0], hessian[0].ravel()])
    return made


def planted(
    before: NavigationFunction, goal: np.ndarray, z: np.ndarray, bends: np.ndarray
) -> NavigationFunction:
    """Change chi such that ln beta / k - ln gamma_d has a critical point at z.

    The eigenvalues of its Hessian there become ``bends``. phi falls with it: negative ones are
    a minimum of phi.
    """
    obstacle = before.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    chi, n = obstacle.chi, len(z)
    rng = np.random.default_rng(len(z))
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    _, grad_0, hess_0 = obstacle.closure(z[None])
    metric, away = before.metrics(goal), z - goal
    pull, gamma = metric @ away, away @ metric @ away
    gradient = 2 * pull / gamma - grad_0[0] / before.k
    of_gamma = 2 * metric / gamma - 4 * np.outer(pull, pull) / gamma**2
    hessian = turn @ np.diag(bends) @ turn.T + of_gamma - np.diag(hess_0[0]) / before.k
    linear = rows(chi, z)
    c = chi.coefficients.ravel()
    for _ in range(3):  # refined: to the last bits
        missing = np.concatenate([gradient, hessian.ravel()]) - linear @ c
        c = c + np.linalg.lstsq(linear, missing, rcond=1e-10)[0]
    made = ExponentialObstacle(TensorBSpline(chi.basis, c), obstacle.width)
    return NavigationFunction(made, before.k, before.metric)


def place(where: str, n: int, rng: np.random.Generator, goal: np.ndarray) -> np.ndarray:
    """A point of some kind, away from the destination."""
    lower, upper = basis(n).lower, basis(n).upper
    while True:
        z = rng.uniform(lower + WIDTH, upper - WIDTH)
        if where == "knot":
            i = rng.integers(n)
            z[i] = rng.choice(basis(n).axes[i].breaks[1:-1])
        elif where == "crossing":
            z = np.array([rng.choice(axis.breaks[1:-1]) for axis in basis(n).axes])
        elif where == "layer":
            z[rng.integers(n)] = rng.choice([lower[0] + 0.3 * WIDTH, upper[0] - 0.7 * WIDTH])
        elif where == "face":
            z[rng.integers(n)] = rng.choice([lower[0] + 1e-4 * WIDTH, upper[0] - 1e-4 * WIDTH])
        elif where == "edge of the layer":
            z[rng.integers(n)] = rng.choice([lower[0] + WIDTH, upper[0] - WIDTH])
        elif where == "corner":
            z = rng.choice([lower[0] + 0.2 * WIDTH, upper[0] - 0.4 * WIDTH], size=n)
        if np.linalg.norm(z - goal) > 0.4:
            return z


PLACES = ("inside", "knot", "crossing", "layer", "face", "edge of the layer", "corner")
EXCESS = (1e-9, 1e-7, 1e-5, 1e-3, 1.0)


def violation(
    where: str, excess: float, n: int, with_metric: bool, seed: int
) -> tuple[NavigationFunction, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    goal = rng.uniform(-0.3, 0.6, n)
    metric = random_metric(n, seed) if with_metric else None
    before = navigation(random_chi(n, seed, 0.05), metric)
    z = place(where, n, rng, goal)
    return planted(before, goal, z, np.full(n, -excess)), goal, z


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("excess", EXCESS)
@pytest.mark.parametrize("seed", range(2))
def test_a_planted_minimum_is_never_certified(where: str, excess: float, seed: int) -> None:
    """However flat it is: eigenvalues of the Hessian down to 1e-9."""
    with_metric = bool(seed % 2)
    made, goal, z = violation(where, excess, 2, with_metric, seed)
    _, gradient, hessian = made.jets(z[None], goal, 2)
    assert np.abs(gradient).max() < 1e-9 * max(1.0, np.abs(hessian).max())
    proof = certify_destination(made, goal)
    assert not proof.certified and not proof.everywhere
    assert "not decided" in proof.reason and len(proof.undecided)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("depth", [0.1, 0.6, 0.95])
def test_minima_in_the_closing_layer_of_any_face_are_seen(
    axis: int, side: str, depth: float
) -> None:
    """There chi leads outwards and the layer holds against it."""
    goal, z = np.array([0.3, 0.2]), np.array([0.9, 1.0])
    z[axis] = -1 + depth * WIDTH if side == "lower" else 2 - depth * WIDTH
    made = planted(navigation(random_chi(2, 0, 0.05)), goal, z, np.full(2, -1e-3))
    assert not certify_destination(made, goal).certified
    saddle = planted(navigation(random_chi(2, 0, 0.05)), goal, z, np.array([1.0, -1.0]))
    assert not certify_destination(saddle, goal).everywhere


@pytest.mark.slow
@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("excess", EXCESS)
@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("with_metric", [False, True])
@pytest.mark.parametrize("seed", range(3, 6))
def test_six_hundred_planted_minima(
    where: str, excess: float, n: int, with_metric: bool, seed: int
) -> None:
    if n == 1 and where in ("crossing", "corner"):
        pytest.skip("on a line they are knots and faces")
    made, goal, _ = violation(where, excess, n, with_metric and n > 1, seed)
    assert not certify_destination(made, goal).certified
    assert not certify_destination(made, goal - 1e-3, goal + 1e-3).certified


@pytest.mark.parametrize("where", ["inside", "crossing", "layer"])
@pytest.mark.parametrize("excess", [1e-9, 1e-3, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_planted_saddle_is_not_overlooked(where: str, excess: float, seed: int) -> None:
    """It may be told unstable, but every start is never said to arrive."""
    rng = np.random.default_rng(seed)
    goal = rng.uniform(-0.3, 0.6, 2)
    z = place(where, 2, rng, goal)
    before = navigation(random_chi(2, seed, 0.05))
    made = planted(before, goal, z, np.array([excess, -3.0]))
    assert not certify_destination(made, goal).everywhere


@pytest.mark.parametrize("seed", range(6))
def test_for_one_destination_of_a_box_alone(seed: int) -> None:
    """A minimum that only a destination inside the box has, not its corners."""
    rng = np.random.default_rng(seed)
    goal = rng.uniform(-0.2, 0.5, 2)
    z = place("inside", 2, rng, goal)
    made = planted(navigation(random_chi(2, seed, 0.05)), goal, z, np.full(2, -1e-3))
    assert not certify_destination(made, goal - [0.02, 0.05], goal + [0.03, 0.01]).certified


@pytest.mark.parametrize("seed", range(8))
def test_the_turned_condition_alone_does_not_certify_a_minimum(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        destination._Problem, "_separated", lambda self, cells, _: np.zeros(len(cells.origin), bool)
    )
    made, goal, _ = violation(PLACES[seed % 6], 1e-6, 2, bool(seed % 2), seed)
    assert not certify_destination(made, goal).certified


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e308])
@pytest.mark.parametrize("where", ["chi", "low", "high", "k", "metric", "width"])
def test_what_is_no_number_proves_nothing(value: float, where: str) -> None:
    flat, goal = np.zeros(basis(2).shape), np.array([0.1, 0.2])
    metric = DestinationMetric(goal[None], np.zeros((2, 2, 2)), 1.0)
    width, high = np.full(2, WIDTH), goal.copy()
    if where == "chi":
        flat[2, 3] = value
    elif where == "low":
        goal = np.array([value, 0.2])
    elif where == "high":
        high = np.array([0.1, value])
    elif where == "metric":
        metric = DestinationMetric(goal[None], np.full((2, 2, 2), value), 1.0)
    elif where == "width":
        width = np.array([value, WIDTH])
    made = NavigationFunction(ExponentialObstacle(TensorBSpline(basis(2), flat), width), K, metric)
    if where == "k":
        object.__setattr__(made, "k", value)
    with np.errstate(all="ignore"):
        proof = certify_destination(made, goal, high)
    assert not proof.certified or (where == "k" and value == 1e308)


def shaped(function: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> TensorBSpline:
    """A spline near a function of x and y: its values where the coefficients belong."""
    b = TensorBasis.uniform(-np.ones(2), 2 * np.ones(2), (14, 14))
    x, y = (np.array([k[i + 1 : i + 4].mean() for i in range(14)]) for k in b.knots)
    return TensorBSpline(b, function(*np.meshgrid(x, y, indexing="ij")))


def bump(height: float) -> TensorBSpline:
    """A bump of chi away from the destination (0.5, 0): a trap where it is high, or else a hill."""
    return shaped(lambda x, y: height * np.exp(-0.5 * ((x - 0.5) ** 2 + (y - 1.2) ** 2) / 0.2))


def twist(strength: float) -> TensorBSpline:
    """chi = strength * (x - 0.5) y: paths from two corners first lead away from (0.5, 0)."""
    return shaped(lambda x, y: strength * (x - 0.5) * y)


FIELDS = {
    "a slight bump": (bump(0.3), (True, True, True)),
    "a twist": (twist(0.42), (False, True, True)),
    "a hill and a saddle before it": (bump(-3.0), (False, True, False)),
    "a trap": (bump(6.0), (False, False, False)),
}
"""chi, and whether it meets the descent condition, is certified, and for every start."""


@pytest.mark.parametrize("name", FIELDS)
def test_what_is_proved_is_so_and_more_than_by_the_descent_condition(name: str) -> None:
    goal, (chi, expected) = np.array([0.5, 0.0]), FIELDS[name]
    made = navigation(chi)
    proof = certify_destination(made, goal)
    descends = certify(made, goal[None]).certified
    assert (descends, proof.certified, proof.everywhere) == expected
    kinds = {point.kind for point in critical_points(made, goal, grid(made, 12))}
    assert ("minimum" in kinds) is not proof.certified
    assert bool(kinds) is not proof.everywhere
    starts = np.random.default_rng(0).uniform(-1, 2, (100, 2))
    assert all(path.arrived for path in follow(made.directions, starts, goal)) is proof.certified


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_what_the_closing_layer_alone_holds_back_is_a_trap(axis: int, side: str) -> None:
    """chi leads out of the workspace, and v is nowhere zero: only the layer makes a minimum."""

    def beyond_the_face(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        along, across = (x, y) if axis == 0 else (y, x)
        depth = along + 1 if side == "lower" else 2 - along
        return 2.0 * np.exp(-0.5 * ((depth + 0.2) ** 2 + (across - 0.5) ** 2) / 0.1)

    made, goal = navigation(shaped(beyond_the_face)), np.full(2, 0.5)
    start = goal.copy()
    start[axis] = -0.97 if side == "lower" else 1.97
    assert not follow(made.directions, start[None], goal)[0].arrived
    assert not certify_destination(made, goal).certified


def test_each_of_the_tests_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    goal, made = np.array([0.5, 0.0]), navigation(twist(0.42))
    assert certify_destination(made, goal).everywhere

    def nothing(problem: object, cells: destination.Cells, *rest: object) -> np.ndarray:
        return np.zeros(len(cells.origin), dtype=bool)

    for test, alone in (("_descends_turned", True), ("_separated", False), ("_descends", False)):
        with monkeypatch.context() as without:
            without.setattr(destination._Problem, test, nothing)
            assert certify_destination(made, goal).certified is alone, test
    with monkeypatch.context() as without:
        without.setattr(destination._Problem, "unstable", nothing)
        assert not certify_destination(navigation(bump(-3.0)), goal).certified


def test_the_turned_condition_proves_what_the_descent_condition_does_not() -> None:
    """Away from the closing layer."""
    goal = np.array([0.5, 0.0])
    chi = shaped(lambda x, y: 5.0 * np.exp(-0.5 * ((x - 0.9) ** 2 + (y - 0.9) ** 2) / 0.2))
    made = navigation(chi)
    problem = destination._Problem(
        ExponentialObstacle(chi, np.full(2, WIDTH)), goal, goal, np.eye(2), True
    )
    cells = destination.Cells.of(chi).halved()
    slopes = destination.gradients(cells.coefficients, cells.size)
    plain = problem._descends(cells, slopes, np.eye(2))
    turned = problem._descends_turned(cells, slopes)
    assert (turned & ~plain).sum() > 3
    for where in np.flatnonzero(turned & ~plain):  # no zero there, by samples
        z = cells.origin[where] + cells.size[where] * np.random.default_rng(0).random((500, 2))
        assert np.linalg.norm(made.jets(z, goal, 1)[1], axis=1).min() > 1e-6
    layers = np.logical_or(*problem._in_layers(cells)).any(axis=1)
    assert not (turned & layers).any()


@pytest.mark.parametrize("seed", range(3))
def test_a_box_is_proved_as_its_destinations_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    made, middle = navigation(random_chi(2, seed, 0.12)), rng.uniform(-0.2, 0.6, 2)
    for half in (0.3, 0.1, 0.03):
        proof = certify_destination(made, middle - half, middle + half)
        if proof.certified:
            break
    assert proof.certified and proof.everywhere
    for goal in rng.uniform(middle - half, middle + half, (10, 2)):
        assert certify_destination(made, goal).everywhere


@pytest.mark.parametrize("seed", range(4))
def test_directions_that_serve_the_fields_of_a_box_serve_its_destinations(seed: int) -> None:
    rng = np.random.default_rng(seed)
    chi = random_chi(2, seed, 0.5)
    low, high = rng.uniform(-0.3, 0.1, 2), rng.uniform(0.3, 0.6, 2)
    obstacle = ExponentialObstacle(chi, np.full(2, WIDTH))
    problem = destination._Problem(obstacle, low, high, np.eye(2), True)
    cells = destination.Cells.of(chi).halved().halved()
    fields = problem.fields(cells, destination.gradients(cells.coefficients, cells.size))
    at_origin = np.array([each[:, :, 0, 0] for each in fields])  # (fields, N, n)
    gradient = chi.jets(cells.origin, 1)[1]
    served = 0
    for d in rng.normal(size=(20, 2)):
        least = (at_origin @ d).min(axis=0)
        for goal in rng.uniform(low, high, (20, 2)):
            away = cells.origin - goal
            v = (away**2).sum(axis=1)[:, None] * gradient - 2 * away
            assert (v @ d >= least - 1e-12)[least > 0].all()
        served += (least > 0).sum()
    assert served > 100


def test_what_cannot_be_proved_says_why() -> None:
    goal, flat = np.array([0.1, 0.2]), TensorBSpline(basis(2), np.zeros(basis(2).shape))
    assert (
        "obstacle"
        in certify_destination(NavigationFunction(SplineObstacle(flat), 2.0), goal).reason
    )
    made = navigation(flat)
    assert certify_destination(made, goal).everywhere
    for axis, edge in ((0, -0.8), (1, 1.8)):
        for outwards, certified in ((0.0, True), (1e-9, False)):
            at = goal.copy()
            at[axis] = edge + (-outwards if edge < 0 else outwards)
            proof = certify_destination(made, at)
            assert proof.certified is certified
            assert ("closing layer" in proof.reason) is not certified
    assert "empty" in certify_destination(made, goal, goal - 0.1).reason
    kinked = TensorBSpline(basis(2, 1), np.zeros(basis(2, 1).shape))
    assert "kinks" in certify_destination(navigation(kinked), goal).reason
    other: Obstacle = SplineObstacle(flat)
    assert not certify_destination(NavigationFunction(other, 2.0), goal).certified


def test_metrics_have_to_be_positive_definite(monkeypatch: pytest.MonkeyPatch) -> None:
    made = navigation(TensorBSpline(basis(2), np.zeros(basis(2).shape)), random_metric(2, 0))
    goal = np.array([0.1, 0.2])
    assert certify_destination(made, goal).everywhere
    for matrix in ([[1.0, 2.0], [2.0, 1.0]], [[1.0, 0.0], [0.0, 0.0]], [[1.0, 0.1], [0.0, 1.0]]):
        monkeypatch.setattr(
            NavigationFunction, "metrics", lambda self, z, matrix=matrix: np.array(matrix)
        )
        assert "positive definite" in certify_destination(made, goal).reason


def test_unstable_points_need_two_derivatives() -> None:
    """With a double knot chi has one, and a saddle is no longer told from a trap."""
    goal, chi = np.array([0.5, 0.0]), bump(-3.0)
    proof = certify_destination(navigation(chi), goal)
    assert proof.certified and not proof.everywhere
    quadratic = TensorBasis.uniform(-np.ones(2), 2 * np.ones(2), (14, 14), 2)
    coarse = navigation(TensorBSpline(quadratic, chi.coefficients))
    assert not certify_destination(coarse, goal).certified


def test_a_spent_budget_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    goal, made = np.array([0.5, 0.0]), navigation(bump(-3.0))
    assert certify_destination(made, goal).certified
    for name in ("_MOST_NUMBERS", "_MOST_HALVINGS"):
        with monkeypatch.context() as with_less:
            with_less.setattr(destination, name, 0)
            proof = certify_destination(made, goal)
            assert not proof.certified and "not decided" in proof.reason

"""The direction learner: round trips, constraints, determinism, bad input, real data."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import check_grad

from handsim.errors import InputError
from handsim.learning.direction import learner as direction_fit
from handsim.learning.direction.descent import DescentCondition, box_corners
from handsim.learning.direction.learner import (
    DirectionLearner,
    recorded_samples,
    rolled_out_samples,
)
from handsim.learning.fit.lbfgs import Minimum
from handsim.learning.learn import learn_controller
from handsim.learning.scores import evaluate, leave_one_out
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.certificate import certify
from handsim.navigation.flow import ARRIVAL, FlowPath, follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import path_error
from handsim.navigation.workspace import knot_counts, lay_basis
from handsim.recordings.importers.import_files import import_recordings

REAL = Path(__file__).parents[3] / "../shared/data/reach_to_grasp"
REAL_FILES = [REAL / f"{letter}_R2G_SUBJECTbyOBJECT_raw.mat" for letter in "Xt"]
real_data = pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared")


def followed(learner: DirectionLearner, paths: list) -> list[FlowPath]:
    starts, goals = (np.array([path[i] for path in paths]) for i in (0, -1))
    return follow(learner.navigation_.directions, starts, goals)


def ratio(rollouts: list[FlowPath], paths: list) -> float:
    errors = [path_error(r.points, p) for r, p in zip(rollouts, paths, strict=True)]
    return float(np.sum(errors) / np.sum([path_error(p[[0, -1]], p) for p in paths]))


def test_curved_paths_are_reproduced(paths: list) -> None:
    learner = DirectionLearner().fit(paths)
    rollouts = followed(learner, paths)
    assert all(r.arrived for r in rollouts)
    assert ratio(rollouts, paths) < 0.2
    assert learner.cost_end_ < 0.5 * learner.cost_start_
    history = learner.history_
    assert len(history.cost) == len(history.change) == learner.n_iterations_ > 60
    assert (np.diff(history.cost[:60]) <= 1e-12).all()  # the first fit only falls


def test_a_known_field_is_found_again() -> None:
    """Paths made by a known obstacle; the learner's field has their directions."""
    space = TensorBasis.uniform([-1.5, -1.5], [1.5, 1.5], (9, 9))
    bumps = 0.4 * np.random.default_rng(3).normal(size=space.shape)
    truth = NavigationFunction(
        ExponentialObstacle(TensorBSpline(space, bumps), np.full(2, 0.05)), 4.0
    )
    rng = np.random.default_rng(4)
    starts = rng.uniform(-1, 1, (60, 2))
    goals = np.repeat(rng.uniform(-0.9, 0.9, (3, 2)), 20, axis=0)
    paths = [r.points for r in follow(truth.directions, starts, goals) if r.arrived]
    assert len(paths) > 50
    exact = {
        "certified": False,
        "smoothness": 1e-8,
        "descent": 0.0,
        "n_iterations": 300,
        "n_refinements": 2,
    }
    learner = DirectionLearner(averaging=0.0, **exact).fit(paths)
    assert ratio(followed(learner, paths), paths) < 0.15
    with_distance_itself = DirectionLearner(averaging=0.0, metric_ridge=None, **exact).fit(paths)
    assert with_distance_itself.navigation_.metric is None
    assert ratio(followed(with_distance_itself, paths), paths) < 0.15


@pytest.mark.parametrize("n", [1, 2, 4, 5])
def test_any_number_of_dimensions(n: int) -> None:
    rng = np.random.default_rng(0)
    s = np.linspace(0, 1, 40)[:, None]
    paths = [s * rng.normal(size=n) + 0.1 * rng.normal(size=n) for _ in range(4)]
    rollouts = followed(DirectionLearner(n_refinements=1, n_iterations=20).fit(paths), paths)
    assert all(r.arrived for r in rollouts)


def test_same_seed_same_bits(paths: list) -> None:
    first, again, other = (
        DirectionLearner(n_refinements=1, seed=seed).fit(paths).navigation_.obstacle
        for seed in (1, 1, 2)
    )
    for one in (first, again, other):
        assert isinstance(one, ExponentialObstacle)
    np.testing.assert_array_equal(first.chi.coefficients, again.chi.coefficients)
    assert np.abs(first.chi.coefficients - other.chi.coefficients).max() > 1e-6


def test_certified_learning_is_proved_and_costs_little(paths: list) -> None:
    free, bound = (DirectionLearner(certified=flag).fit(paths) for flag in (False, True))
    goals = np.array([path[-1] for path in paths])
    assert certify(bound.navigation_, goals).certified
    assert not certify(free.navigation_, goals).certified
    assert ratio(followed(bound, paths), paths) < 0.6
    obstacle = bound.navigation_.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    low, high = obstacle.lower + obstacle.width, obstacle.upper - obstacle.width
    assert certify(bound.navigation_, np.array([low, high])).certified
    rng = np.random.default_rng(0)
    starts = rng.uniform(obstacle.lower, obstacle.upper, (100, 3))
    ends = rng.uniform(low, high, (100, 3))
    assert all(r.arrived for r in follow(bound.navigation_.directions, starts, ends))


def test_phi_is_below_its_limit_at_the_starts(paths: list) -> None:
    navigation = DirectionLearner(n_refinements=0, n_iterations=10).fit(paths).navigation_
    starts, goals = (np.array([path[i] for path in paths]) for i in (0, -1))
    assert navigation.jets(starts, goals, 0)[0].max() == pytest.approx(0.9)


def test_gradients_of_cost_and_condition(paths: list) -> None:
    space, _ = lay_basis(paths, (7, 7, 7))
    goals = np.array([path[-1] for path in paths])
    rng = np.random.default_rng(0)
    points = rng.uniform(space.lower, space.upper, (300, 3))
    condition = DescentCondition(space, goals, points, 0.5, 10.0)
    c = rng.normal(size=space.n_coefficients)
    assert condition(c)[0] > 1e-3
    scale = np.linalg.norm(condition(c)[1])
    assert check_grad(lambda x: condition(x)[0], lambda x: condition(x)[1], c) < 1e-5 * scale
    condition.tighten(c)
    assert condition.shift.max() > 0
    scale = np.linalg.norm(condition(c)[1])
    assert check_grad(lambda x: condition(x)[0], lambda x: condition(x)[1], c) < 1e-5 * scale


def test_restored_coefficients_meet_the_condition() -> None:
    space = TensorBasis.uniform([-1.0, -1.0], [1.0, 1.0], (8, 8))
    goals = np.array([[0.1, 0.2], [-0.3, 0.0]])
    condition = DescentCondition(space, goals, np.zeros((1, 2)), 2.0, 1.0)
    c = 3 * np.random.default_rng(1).normal(size=64)
    navigation = NavigationFunction(
        ExponentialObstacle(TensorBSpline(space, condition.restored(c)), np.full(2, 0.1)), 2
    )
    assert certify(navigation, goals).certified
    small = 1e-3 * c
    np.testing.assert_array_equal(condition.restored(small), small)


def test_a_condition_that_holds_everywhere_has_no_points_left() -> None:
    space = TensorBasis.uniform([-1.0, -1.0], [1.0, 1.0], (8, 8))
    condition = DescentCondition(space, np.array([[0.1, 0.2]]), np.zeros((9, 2)), 2.0, 1.0)
    flat = np.zeros(64)
    condition.tighten(flat)
    assert len(condition.points) == 0
    value, slope = condition(flat)
    assert value == 0 and slope.shape == (64,) and not slope.any()


def test_samples_lead_along_back_and_ahead() -> None:
    line = np.outer(np.linspace(0, 2, 50), [1.0, 0.0])
    samples = recorded_samples([line], np.random.default_rng(0))
    np.testing.assert_allclose(np.linalg.norm(samples.vectors, axis=1), 1.0)
    assert samples.points[:, 0].max() <= 0.97 * 2 + 1e-9
    aside = samples.points[:, 1]
    assert np.deg2rad(5) < np.abs(aside).max() <= np.deg2rad(15)
    np.testing.assert_allclose(
        samples.vectors[:, 1] / samples.vectors[:, 0], -1.5 / np.deg2rad(100) * aside, atol=1e-12
    )
    parallel = FlowPath(line + [0.0, 0.3], False, "stuck")
    back = rolled_out_samples([parallel], [line])
    assert (back.vectors[:, 1] < 0).all() and (back.vectors[:, 0] > 0).all()


def test_the_cost_has_the_gradient_it_says(paths: list, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of every part: directions, descent condition, smoothness, ridge, metric."""
    checked = []

    def check(cost, x, *_, **__) -> Minimum:
        rng = np.random.default_rng(len(checked))
        here = x + 0.5 * rng.normal(size=x.shape)  # so rough that the descent condition fails
        gradient = cost(here)[1]
        for scale in (1.0, 0.0):
            along = rng.normal(size=x.shape)
            along[:-10] *= scale  # the metric's parameters come last
            ahead, behind = cost(here + 1e-6 * along)[0], cost(here - 1e-6 * along)[0]
            assert (ahead - behind) / 2e-6 == pytest.approx(gradient @ along, rel=1e-4)
        checked.append(here)
        return Minimum(x, cost(x)[0], ())

    monkeypatch.setattr(direction_fit, "minimise", check)
    learner = DirectionLearner(
        shape=(8,) * paths[0].shape[1], smoothness=0.1, ridge=0.1, descent=10.0, metric_ridge=0.1,
        n_refinements=1,
    )  # fmt: skip
    learner.fit(paths)
    assert len(checked) == 2


def test_destinations_share_their_metric_over_three_quarters_of_their_spread(paths: list) -> None:
    goals = np.array([path[-1] for path in paths])
    spread = np.sqrt(np.mean(np.sum((goals - goals.mean(axis=0)) ** 2, axis=1)))
    learner = DirectionLearner(n_iterations=1, n_refinements=0).fit(paths)
    assert learner.navigation_.metric.reach == pytest.approx(0.75 * spread)


def test_knots_follow_the_variance() -> None:
    variance = np.array([1.0, 0.25, 0.04])
    by_rule = {rule: knot_counts(variance, 3, rule) for rule in ("variance", "deviation", "equal")}
    assert by_rule["equal"][0] == by_rule["equal"][2]
    first, second, third = (np.array(by_rule["deviation"]) - 3)[:3]
    assert second / first == pytest.approx(0.5, abs=0.1)
    assert third / first == pytest.approx(0.25, abs=0.1)
    assert by_rule["variance"][0] > by_rule["deviation"][0]
    assert all(np.prod(counts) <= 1700 for counts in by_rule.values())


def test_box_corners() -> None:
    corners = box_corners(np.array([[0.0, 5.0], [1.0, 2.0]]))
    assert sorted(map(tuple, corners)) == [(0, 2), (0, 5), (1, 2), (1, 5)]


def test_workspace_reaches_more_than_a_knot_beyond(paths: list) -> None:
    space, width = lay_basis(paths)
    points = np.vstack(paths)
    cell = np.array([knots[4] - knots[3] for knots in space.knots])
    assert ((points.min(0) - space.lower) > 1.1 * cell).all()
    assert ((space.upper - points.max(0)) > 1.1 * cell).all()
    assert (width < points.min(0) - space.lower).all()


def test_bad_input(paths: list) -> None:
    with pytest.raises(InputError, match="0 paths"):
        DirectionLearner().fit([])
    with pytest.raises(InputError, match="2 or more"):
        DirectionLearner(k=1.5).fit(paths)
    flat = [path * [1.0, 1.0, 0.0] for path in paths]
    with pytest.raises(InputError, match="component 3"):
        DirectionLearner().fit(flat)
    with pytest.raises(InputError, match="coefficients"):
        DirectionLearner(shape=(9, 9)).fit(paths)


def test_of_many_recordings_every_few_points_are_samples() -> None:
    line = np.linspace(0.0, 1.0, 80)[:, None]  # in one dimension there is no corridor
    rng = np.random.default_rng(0)
    some, many = (recorded_samples([line] * n, rng).points for n in (100, 2000))
    assert len(some) == 100 * 29
    assert 0.9 * 6000 < len(many) <= 6000
    # Other ones of each recording, so that no part of the movements is left out.
    np.testing.assert_allclose(np.unique(many.round(9)), np.unique(some.round(9)))
    led = rolled_out_samples([FlowPath(0.5 * line, True, "arrived")] * 2000, [line] * 2000)
    assert 0.9 * 6000 < len(led.points) <= 6000


@pytest.mark.parametrize("n", [1, 2, 3])
def test_only_the_outermost_destinations_count(n: int) -> None:
    basis = TensorBasis.uniform([-2.0] * n, [2.0] * n, (7,) * n)
    rng = np.random.default_rng(0)
    goals, points = rng.normal(size=(200, n)) / 2, rng.uniform(-2, 2, (300, n))
    condition = DescentCondition(basis, goals, points, 1.0, 1.0)
    assert len(condition.goals) < 100
    c = rng.normal(size=basis.n_coefficients)
    gradient = TensorBSpline(basis, c).jets(points, 1)[1]
    here = np.einsum("ij,ij->i", points, gradient)
    worst = np.max(here[:, None] - gradient @ goals.T, axis=1)
    assert condition(c)[0] == pytest.approx(np.mean(np.maximum(worst - 1.0, 0.0) ** 2))
    if n > 1:  # all on one plane
        goals[:, 0] = 0.3
        assert len(DescentCondition(basis, goals, points, 1.0, 1.0).goals) == 200


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
def test_real_recordings_of_subject_4() -> None:
    recordings = import_recordings(REAL_FILES, "west-rtg", 4)
    learned = learn_controller(recordings)
    controller, summary = learned.controller, learned.summary
    assert summary["n_recordings"] == 20 and summary["n_coefficients"] > 1000
    found = evaluate(controller, recordings)
    assert found.n_arrived == 20
    assert found.ratio < 0.60


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
@pytest.mark.slow
def test_real_recordings_of_four_subjects() -> None:
    found = []
    for subject in (1, 2, 3, 4):
        recordings = import_recordings(REAL_FILES, "west-rtg", subject)
        found.append(evaluate(learn_controller(recordings).controller, recordings))
    assert [one.n_arrived for one in found] == [20] * 4
    ratios = [one.ratio for one in found]
    assert np.mean(ratios) < 0.67 and max(ratios) < 0.75
    error, repeat = (
        np.mean([getattr(f, k) for f in found]) for k in ("path_error_deg", "repeatability_deg")
    )
    assert error < 0.85 * repeat


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
@pytest.mark.slow
def test_real_movements_left_out() -> None:
    found = []
    for subject in (1, 2, 3, 4):
        recordings = import_recordings(REAL_FILES, "west-rtg", subject)
        found.append(leave_one_out(recordings, lambda rest: learn_controller(rest).controller))
    assert [one.n_arrived for one in found] == [20] * 4
    assert np.mean([one.ratio for one in found]) <= 0.80


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
@pytest.mark.slow
@pytest.mark.parametrize("subject", [1, 2, 3, 4])
def test_certified_on_real_recordings(subject: int) -> None:
    recordings = import_recordings(REAL_FILES, "west-rtg", subject)
    controller = learn_controller(recordings, certified=True).controller
    goals = np.array([d.z_goal for d in controller.demonstrations])
    navigation = controller.navigation
    assert certify(navigation, goals).certified
    assert evaluate(controller, recordings).ratio < 0.80
    rng = np.random.default_rng(0)
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    starts, ends = rng.uniform(low, high, (500, 3)), rng.uniform(low, high, (500, 3))
    rollouts = follow(navigation.directions, starts, ends)
    assert all(
        np.linalg.norm(r.points[-1] - e) < ARRIVAL for r, e in zip(rollouts, ends, strict=True)
    )

"""The learner for any data: drawn curves, other units and dimensions, real handwriting."""

from pathlib import Path

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError

import handsim
from handsim.errors import InputError
from handsim.learning.general.candidates import best_proved, straight
from handsim.learning.general.convergence import convergence
from handsim.learning.general.learner import NavigationLearner, _checked
from handsim.learning.general.potential import Remaining, canyon, cost_to_go
from handsim.learning.general.refinement import tried
from handsim.navigation.flow import follow
from handsim.navigation.paths import arc_length
from handsim.types import Array

HANDWRITING = Path(__file__).parents[3] / "../shared/data/handwriting"
real_data = pytest.mark.skipif(not HANDWRITING.is_dir(), reason="no handwriting in ../shared")
S = np.linspace(0.0, 1.0, 60)[:, None]


def hooks(n: int = 3, seed: int = 0) -> list[Array]:
    """Curves that first lead away from where they end: three quarters of an ellipse, and home."""
    rng = np.random.default_rng(seed)
    angle = np.pi * (0.1 + 1.5 * S)
    made = []
    for _ in range(n):
        size = 1.0 + 0.06 * rng.normal(size=2)
        path = np.hstack([30 * size[0] * np.cos(angle), 20 * size[1] * np.sin(angle)])
        made.append(path - path[-1])
    return made


@pytest.fixture(scope="module")
def learner() -> NavigationLearner:
    return NavigationLearner(n_refinements=1).fit(hooks())


def random_starts(learner: NavigationLearner, n: int) -> Array:
    """Starts in the workspace, scaled."""
    obstacle = learner.navigation_.obstacle
    return np.random.default_rng(5).uniform(
        obstacle.lower, obstacle.upper, (n, len(obstacle.lower))
    )


def test_hooks_are_followed_and_proved(learner: NavigationLearner) -> None:
    scores = learner.evaluate(hooks())
    assert scores.certified and scores.n_arrived == scores.n_paths == 3
    assert scores.ratio is not None and scores.ratio < 0.15
    assert scores.ratio == pytest.approx(scores.path_error / scores.straight_error)
    assert np.mean([each["path_error"] for each in scores.per_path]) == scores.path_error
    assert 25 < scores.straight_error < 40  # in the unit of the paths
    assert learner.certificate_.certified and len(learner.certificate_.reasons) == 1
    assert learner.evaluate(hooks(4, seed=9)).ratio < 0.35  # curves not learned from


def test_random_starts_in_the_workspace_arrive(learner: NavigationLearner) -> None:
    goal = (learner.goals_[0] - learner.centre_) * learner.scale_
    paths = follow(learner.navigation_.directions, random_starts(learner, 200), goal)
    assert sum(path.arrived for path in paths) == 200


def test_units_and_origins_do_not_matter(learner: NavigationLearner) -> None:
    other = NavigationLearner(n_refinements=1).fit([1024.0 * path - 4096.0 for path in hooks()])
    assert other.origin_ == learner.origin_
    assert other.scale_ == pytest.approx(learner.scale_ / 1024)
    z = np.array([[3.0, 4.0], [-20.0, 5.0]])
    np.testing.assert_allclose(other.velocity(1024.0 * z - 4096.0), learner.velocity(z), atol=1e-6)
    a, b = other.path(1024.0 * z[1] - 4096.0), learner.path(z[1])
    assert a.arrived and b.arrived
    np.testing.assert_allclose((a.points + 4096.0) / 1024.0, b.points, atol=1e-4)


def test_lengths_are_scaled_by_the_mean_length(learner: NavigationLearner) -> None:
    lengths = [arc_length(path)[-1] for path in hooks()]
    assert learner.scale_ == pytest.approx(2.5 / np.mean(lengths))
    points = np.vstack(hooks())
    np.testing.assert_allclose(learner.centre_, (points.min(axis=0) + points.max(axis=0)) / 2)


def test_velocities_are_unit_vectors_along_the_path(learner: NavigationLearner) -> None:
    z = hooks()[0][:1]
    for _ in range(3000):  # of 0.05 each, some 100 in all
        velocity = learner.velocity(z)
        assert velocity.shape == z.shape
        assert np.linalg.norm(velocity) == pytest.approx(1.0)
        z = z + 0.05 * velocity
        if np.linalg.norm(z[0] - learner.goals_[0]) < 0.1:
            break
    assert np.linalg.norm(z[0] - learner.goals_[0]) < 0.1
    here = hooks()[0][10:14]
    np.testing.assert_array_equal(learner.velocity(here[3]), learner.velocity(here)[3])
    np.testing.assert_array_equal(learner.velocity(learner.goals_[0]), 0.0)


def test_destinations_may_be_given() -> None:
    moved = np.array([2.0, -3.0])
    for goals in (moved, np.tile(moved, (2, 1))):
        ends = [path[-1] for path in _checked(hooks(2), goals)]
        np.testing.assert_allclose(ends, np.tile(moved, (2, 1)), atol=1e-9)
    learner = NavigationLearner(n_refinements=0).fit(hooks(2), goals=moved)
    np.testing.assert_allclose(learner.goals_, moved[None], atol=1e-9)
    assert np.abs(learner.path([0.0, 20.0]).points[-1] - moved).max() < 1e-9


def test_several_destinations_are_each_proved() -> None:
    bend = np.sin(np.pi * S) * [0.2, -0.3]
    paths = [S * [1.0, 0.4] + bend, 0.1 + S * [-0.5, 0.8] - bend, S * [0.9, 0.5] + bend]
    learner = NavigationLearner(n_refinements=0).fit(paths)
    assert learner.goals_.shape == (3, 2)
    assert learner.certificate_.certified and len(learner.certificate_.reasons) == 3
    scores = learner.evaluate(paths)
    assert scores.n_arrived == 3 and scores.ratio < 0.6
    with pytest.raises(InputError, match="3 destinations were learned; say which"):
        learner.velocity([0.0, 0.0])
    assert learner.path([0.0, 0.0], learner.goals_[1]).arrived


@pytest.mark.parametrize("n", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_other_dimensions(n: int) -> None:
    turn = 2.0 * np.pi * S * 0.7
    helix = np.hstack([np.cos(turn), np.sin(turn), 2.0 * S])[:, -n:]
    paths = [helix * (1.0 + 0.05 * i) - (0.05 * i) * helix[-1] for i in range(3)]
    learner = NavigationLearner(n_refinements=0).fit(paths)
    scores = learner.evaluate(paths)
    assert scores.certified and scores.n_arrived == 3
    assert n == 1 or scores.ratio < 0.4
    goal = (learner.goals_[0] - learner.centre_) * learner.scale_
    paths = follow(learner.navigation_.directions, random_starts(learner, 50), goal)
    assert all(path.arrived for path in paths)


@pytest.mark.slow
@pytest.mark.parametrize("n", [4, 5])
def test_most_dimensions(n: int) -> None:
    rng = np.random.default_rng(n)
    side = rng.normal(size=(2, n))
    paths = [S * side[0] + np.sin(np.pi * S) * side[1] * (1 + 0.1 * i) - side[0] for i in range(3)]
    scores = NavigationLearner(n_refinements=0).fit(paths).evaluate(paths)
    assert scores.certified and scores.n_arrived == 3 and scores.ratio < 0.7


def test_what_is_not_proved_is_shrunk_or_left() -> None:
    """A field with no proof at all gives way to straight lines; a trap is shrunk away."""
    learner = NavigationLearner(n_refinements=0, certified=False).fit(hooks())
    inside = [(path - learner.centre_) * learner.scale_ for path in hooks()]
    level = straight(inside, 4.0)
    field = tried(learner.navigation_, inside, "learned")
    assert best_proved([field, level], inside, lambda _: False) is None
    asked = []

    def all_but_the_first(navigation: handsim.NavigationFunction) -> bool:
        asked.append(navigation)
        return navigation is not field.navigation

    found = best_proved([level, field], inside, all_but_the_first)
    assert found is not None and found.origin == "learned, x 0.97"
    assert found.error < 0.1 * level.error
    assert asked[0] is field.navigation and asked[1] is level.navigation
    goals = [inside[0][-1]]
    assert convergence(level.navigation, goals).everywhere


def test_wishes_are_those_of_the_docstring() -> None:
    paths = [path / 30 for path in hooks(2)]
    remaining = Remaining(paths)
    lengths = [arc_length(path)[-1] for path in paths]
    assert remaining.mean_length == pytest.approx(np.mean(lengths))
    np.testing.assert_allclose(remaining.left[:, 0], np.mean(lengths), rtol=0.1)
    assert (np.diff(remaining.left[0]) < 0).all() and remaining.left[0, -1] == 0
    wishes = canyon(remaining, 0.05, 0.4, np.random.default_rng(0))
    potential = wishes.values - 2 * np.log(np.linalg.norm(wishes.points - remaining.goal, axis=1))
    apart = remaining.distances(wishes.points)
    nearest = np.argmin(apart, axis=1)
    depth = 0.4 * (apart.min(axis=1) / (0.05 * remaining.mean_length)) ** 2
    np.testing.assert_allclose(
        potential, -2 * np.log(remaining.left.ravel()[nearest]) - depth, atol=1e-9
    )
    assert wishes.weights.sum() == pytest.approx(1.0)
    basis = straight(paths, 4.0).navigation.obstacle.chi.basis
    grid, on_paths = cost_to_go(remaining, basis, 12.0)
    assert grid.weights.sum() == pytest.approx(0.02) and on_paths.weights.sum() == pytest.approx(1)
    assert (remaining.distances(grid.points).min(axis=1) > 0.3).any()  # beyond the paths too


def test_what_cannot_be_learned_is_refused() -> None:
    for wrong, match in (
        ([], "0 paths"),
        ([np.zeros((5, 6)) + S[:5]], "6 dimensions; give 1 to 5"),
        ([np.zeros((5, 2))], "do not move"),
        ([np.array([[0.0, np.nan], [1.0, 1.0]])], "finite"),
        ([np.hstack([S, 0 * S])], "do not move along component 2"),
    ):
        with pytest.raises(InputError, match=match):
            NavigationLearner().fit(wrong)
    with pytest.raises(InputError, match="goals of shape"):
        NavigationLearner().fit(hooks(), goals=[1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="n_refinements"):
        NavigationLearner(n_refinements=-1).fit(hooks())
    with pytest.raises(InputError, match="k = 1"):
        NavigationLearner(k=1.0).fit(hooks())


def test_what_cannot_be_asked_is_refused(learner: NavigationLearner) -> None:
    for call, match in (
        (lambda: learner.velocity([1.0, 2.0, 3.0]), "points of shape"),
        (lambda: learner.velocity([1.0, np.inf]), "points of shape"),
        (lambda: learner.velocity([1.0, 2.0], [1.0]), "destination of shape"),
        (lambda: learner.velocity([1.0, 2.0], [1e3, 1e3]), "outside"),
        (lambda: learner.path([[1.0, 2.0]]), "give one point"),
        (lambda: learner.evaluate([np.zeros((4, 3))]), "points of shape"),
    ):
        with pytest.raises(InputError, match=match) as raised:
            call()
        assert "\n" not in str(raised.value)


def test_scikit_learns_contract() -> None:
    learner = NavigationLearner(k=3.0)
    assert clone(learner).get_params() == learner.get_params()
    with pytest.raises(NotFittedError, match="call fit first"):
        _ = learner.certificate_
    with pytest.raises(NotFittedError):
        learner.velocity([0.0, 0.0])
    assert handsim.NavigationLearner is NavigationLearner


@real_data
@pytest.mark.parametrize("shape", ["BendedLine"])
def test_handwriting_that_leads_away_from_its_end(shape: str) -> None:
    paths = list(np.load(HANDWRITING / f"{shape}.npz")["pos"].astype(float))
    scores = NavigationLearner(n_refinements=0).fit(paths).evaluate(paths)
    assert scores.certified and scores.n_arrived == 7 and scores.ratio < 0.4


@real_data
@pytest.mark.slow
def test_all_handwriting_is_learned_and_proved() -> None:
    ratios = []
    for file in sorted(HANDWRITING.glob("*.npz")):
        paths = list(np.load(file)["pos"].astype(float))
        learner = NavigationLearner().fit(paths)
        scores = learner.evaluate(paths)
        assert scores.certified and scores.n_arrived == scores.n_paths, file.stem
        goal = (learner.goals_[0] - learner.centre_) * learner.scale_
        found = follow(learner.navigation_.directions, random_starts(learner, 200), goal)
        assert all(path.arrived for path in found), file.stem
        ratios.append(scores.ratio)
    assert np.mean(ratios) < 0.30

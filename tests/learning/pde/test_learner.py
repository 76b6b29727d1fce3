"""The paper's learner: its functional, its solvers, round trips, what it reaches on real data."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import check_grad

from handsim.errors import InputError
from handsim.learning.fit.designs import JetDesign
from handsim.learning.fit.field_samples import FieldSamples
from handsim.learning.pde.learner import PDELearner, descend
from handsim.learning.pde.problem import (
    Functional,
    beside,
    boundary_points,
    forward_differences,
    measured_speeds,
    remaining_speeds,
    switch,
    vanishing_on_boundary,
)
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import SplineObstacle
from handsim.navigation.paths import arc_length, path_error
from handsim.recordings.importers.import_files import import_recordings

REAL = Path(__file__).parents[3] / "../shared/data/reach_to_grasp"
REAL_FILES = [REAL / f"{letter}_R2G_SUBJECTbyOBJECT_raw.mat" for letter in "Xt"]
real_data = pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared")


def rolled_out(learner: PDELearner, paths: list) -> tuple[float, int]:
    """Ratio of path errors to straight lines, and arrivals."""
    starts, goals = (np.array([path[i] for path in paths]) for i in (0, -1))
    rollouts = follow(learner.navigation_.directions, starts, goals)
    errors = [path_error(r.points, p) for r, p in zip(rollouts, paths, strict=True)]
    straight = [path_error(p[[0, -1]], p) for p in paths]
    return float(np.sum(errors) / np.sum(straight)), sum(r.arrived for r in rollouts)


def functional(weights: tuple[float, float, float, float], k: float) -> tuple[Functional, int]:
    rng = np.random.default_rng(0)
    basis = TensorBasis.uniform([-1.0, -1.0], [1.0, 1.0], (7, 8))
    points, goals = rng.uniform(-0.9, 0.9, (2, 30, 2))
    asked = FieldSamples(points, rng.normal(size=(30, 2)), goals)
    return Functional(basis, asked, goals[:3], k, weights, 0.4), basis.n_coefficients


@pytest.mark.parametrize(
    "weights", [(1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, 0), (0, 0, 0, 1.0)]
)
@pytest.mark.parametrize("k", [2.0, 3.0])
def test_gradient_of_each_part_of_the_functional(weights: tuple, k: float) -> None:
    cost, n = functional(weights, k)
    c = np.random.default_rng(1).normal(size=n)  # beta of both signs, also below -gamma^k
    assert cost(c)[0] > 1e-3
    scale = np.linalg.norm(cost(c)[1])
    assert check_grad(lambda x: cost(x)[0], lambda x: cost(x)[1], c) < 1e-5 * scale


def test_parts_add_up_to_the_functional() -> None:
    weights = (1.0, 2.0, 3.0, 4.0)
    cost, n = functional(weights, 2.0)
    c = np.random.default_rng(1).normal(size=n)
    parts = cost.parts(c)
    assert all(value > 0 for value in parts.values())
    total = sum(w * parts[name] for w, name in zip(weights, parts, strict=True)) / 30
    assert cost(c)[0] == pytest.approx(total)


def test_the_pde_holds_on_a_navigation_function() -> None:
    """u = -grad phi for a known beta satisfies Eq. (8): J_PDE vanishes at its coefficients."""
    rng = np.random.default_rng(2)
    basis = TensorBasis.uniform([-1.0] * 3, [1.0] * 3, (7, 7, 7))
    c = 1.0 + 0.2 * rng.normal(size=basis.n_coefficients)
    phi = NavigationFunction(SplineObstacle(TensorBSpline(basis, c)), 2.0)
    points, goals = rng.uniform(-0.9, 0.9, (2, 50, 3))
    asked = FieldSamples(points, -phi.jets(points, goals, 1)[1], goals)
    exact = Functional(basis, asked, goals, 2.0, (1.0, 1.0, 1.0, 0.0), 0.1)
    assert exact.parts(c)["J_PDE"] < 1e-18
    assert exact.parts(1.01 * c)["J_PDE"] > 1e-3


def test_switch_is_positive_and_twice_differentiable() -> None:
    x = np.linspace(-2, 2, 401)
    value, slope = switch(x)
    assert (value >= 0).all() and (value[x >= 0] == 0).all() and value[0] == 8
    np.testing.assert_allclose(np.gradient(value, x)[1:-1], slope[1:-1], atol=2e-3)


def test_velocities_are_forward_differences_and_the_last_frame_is_the_destination() -> None:
    time = np.array([0.0, 0.1, 0.3, 0.4])
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [1.5, 2.0]])
    points, velocities, goal = forward_differences(time, path)
    np.testing.assert_array_equal(points, path[:3])
    np.testing.assert_allclose(velocities, [[10, 0], [0, 10], [5, 0]])
    np.testing.assert_array_equal(goal, path[3])


def test_time_scale_keeps_the_path_integral_of_speed_below_one(paths: list) -> None:
    asked = remaining_speeds(paths, 0.9, 0.0)
    lengths = [arc_length(path)[-1] for path in paths]
    speed = np.linalg.norm(asked.vectors, axis=1).reshape(len(paths), -1)
    integrals = [
        np.trapezoid(s, np.linspace(0, length, len(s)))
        for s, length in zip(speed, lengths, strict=True)
    ]
    assert max(integrals) == pytest.approx(0.9, rel=1e-6)
    times = [np.arange(len(path)) / 50 for path in paths]
    measured = measured_speeds(paths, times, 0.9, 0.04)
    assert np.linalg.norm(measured.vectors, axis=1).min() > 0


def test_corridor_leads_back(paths: list) -> None:
    on_path = remaining_speeds(paths, 0.9, 0.04)
    aside = beside(on_path, np.random.default_rng(0))
    offset = aside.points - np.tile(on_path.points, (4, 1))
    turned = aside.vectors - np.tile(on_path.vectors, (4, 1))
    assert np.linalg.norm(offset, axis=1).max() > 0.05
    far = np.linalg.norm(offset, axis=1) > 0.02
    assert (np.sum(offset * turned, axis=1)[far] < 0).all()


def test_boundary_stays_closed_by_construction() -> None:
    basis = TensorBasis.uniform([-1.0] * 2, [1.0] * 2, (9, 8))
    faces = boundary_points(basis)
    assert ((np.abs(faces) == 1).any(axis=1)).all() and len(faces) == 24
    inner = vanishing_on_boundary(basis)
    c = np.random.default_rng(0).normal(size=basis.n_coefficients)
    on_faces = JetDesign(basis, faces)
    assert np.abs(on_faces(c * inner)[0]).max() < 1e-12
    assert np.abs(on_faces(c * ~inner)[0]).max() > 0.1


def test_gradient_descent_never_rises_and_reaches_a_bowl() -> None:
    scales = np.array([1.0, 4.0, 30.0])
    values = []

    def bowl(x: np.ndarray) -> tuple[float, np.ndarray]:
        return float(0.5 * scales @ (x - 1) ** 2), scales * (x - 1)

    x = np.array([5.0, -3.0, 2.0])
    for _ in range(300):
        x = descend(bowl, x, 1, 1.0)
        values.append(bowl(x)[0])
    assert (np.diff(values) <= 0).all()
    np.testing.assert_allclose(x, 1.0, atol=1e-3)


def test_both_solvers_lower_j_and_record_how(paths: list) -> None:
    for solver in ("lbfgs", "gradient"):
        learner = PDELearner(solver=solver, n_iterations=30, shape=(9, 9, 9)).fit(paths)
        cost = np.array([learner.cost_start_, *learner.history_.cost])
        assert (np.diff(cost) <= 0).all()
        assert learner.cost_end_ == pytest.approx(cost[-1])
        assert cost[-1] < 0.7 * cost[0]
        assert len(learner.coefficients_history_) == learner.n_iterations_ == 30
        assert learner.closed_ and learner.boundary_beta_ < 1e-12
        assert set(learner.parts_) == {"J_PDE", "J_sp", "J_dp", "J_bn"}


def test_one_curved_path_is_reproduced(paths: list) -> None:
    learner = PDELearner().fit(paths[3:4])
    ratio, arrived = rolled_out(learner, paths[3:4])
    assert ratio < 0.2 and arrived == 1
    assert learner.positive_ and learner.closed_


def test_bad_input(paths: list) -> None:
    with pytest.raises(InputError, match="0 paths"):
        PDELearner().fit([])
    with pytest.raises(InputError, match="2 or more"):
        PDELearner(k=1.0).fit(paths)
    with pytest.raises(InputError, match="no times"):
        PDELearner(speed="measured").fit(paths)


@pytest.fixture(scope="module")
def real_paths() -> list:
    recordings = import_recordings(REAL_FILES, "west-rtg", 4)
    subspace = PostureSubspace(3).fit(np.vstack([r.q for r in recordings]))
    return [subspace.transform(r.q) for r in recordings]


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
@pytest.mark.slow
def test_single_real_trials(real_paths: list) -> None:
    ratios = [rolled_out(PDELearner().fit([path]), [path])[0] for path in real_paths]
    assert np.median(ratios) < 0.40


@real_data
@pytest.mark.real_data
@pytest.mark.filterwarnings("ignore::handsim.recordings.plausibility.PlausibilityWarning")
@pytest.mark.slow
@pytest.mark.parametrize("n_iterations", [250, 500, 1000])
def test_screwdriver_trials_whatever_the_number_of_iterations(
    real_paths: list, n_iterations: int
) -> None:
    screwdriver = real_paths[8:12]
    learner = PDELearner(n_iterations=n_iterations).fit(screwdriver)
    ratio, arrived = rolled_out(learner, screwdriver)
    assert ratio < 0.60 and arrived == 4
    assert learner.positive_ and learner.closed_

"""Scores in closed form, critical points and the inspection of what was learned."""

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.bspline import TensorBasis, TensorBSpline
from handsim.learning.controller import GraspController, demonstrations_of
from handsim.learning.critical import certification, grid, not_arriving
from handsim.learning.inspection import (
    cumulative_variance,
    eigengrasps,
    flow_lattice,
    slice_through,
)
from handsim.learning.learn import learn_controller
from handsim.learning.navigation import ExponentialObstacle, NavigationFunction
from handsim.learning.paths import path_error
from handsim.learning.scores import evaluate, leave_one_out, repeatability
from handsim.learning.subspace import PostureSubspace
from handsim.motion.recording import RecordingSet


@pytest.fixture(scope="module")
def flat(recordings: RecordingSet) -> GraspController:
    """Constant beta: straight lines."""
    subspace = PostureSubspace(3).fit(np.vstack([r.q for r in recordings]))
    z = subspace.transform(np.vstack([r.q for r in recordings]))
    basis = TensorBasis.uniform(z.min(0) - 1, z.max(0) + 1, (7, 7, 7))
    obstacle = ExponentialObstacle(TensorBSpline(basis, np.zeros((7, 7, 7))), np.full(3, 0.1))
    return GraspController(
        subspace, NavigationFunction(obstacle, 2.0), demonstrations_of(recordings, subspace)
    )


def test_straight_lines_score_one(flat: GraspController, recordings: RecordingSet) -> None:
    found = evaluate(flat, recordings)
    assert found["ratio"] == pytest.approx(1.0, abs=1e-6)
    assert found["n_arrived"] == found["n_recordings"] == len(found["per_recording"]) == 9
    assert found["variance_explained"] > 0.99
    row = found["per_recording"][4]
    path = flat.subspace.transform(recordings[4].q)
    assert row["name"] == recordings[4].name and row["arrived"]
    expected = np.rad2deg(path_error(path[[0, -1]], path))
    assert row["straight_error_deg"] == pytest.approx(expected)
    assert 5 < found["direction_error_deg"] < 90
    assert [entry["n_recordings"] for entry in found["per_object"]] == [3, 3, 3]
    errors = [entry["path_error_deg"] for entry in found["per_object"]]
    assert np.mean(errors) == pytest.approx(found["path_error_deg"])


def test_learning_beats_straight_lines_also_on_what_is_left_out(recordings: RecordingSet) -> None:
    few = RecordingSet(recordings.recordings[:3])
    learned = evaluate(learn_controller(few, n_components=2).controller, few)
    assert learned["n_arrived"] == 3 and learned["ratio"] < 0.3
    assert learned["direction_error_deg"] < 15
    calls: list[float] = []
    left = leave_one_out(
        few, lambda r: learn_controller(r, n_components=2).controller, calls.append
    )
    assert left["n_recordings"] == 3 and calls[-1] == 1.0 and len(calls) == 3
    assert left["ratio"] < 0.8
    with pytest.raises(InputError, match="at least 2"):
        leave_one_out(RecordingSet(recordings.recordings[:1]), lambda r: learned)


def test_repeatability_moves_the_ends() -> None:
    line = np.outer(np.linspace(0, 1, 30), [2.0, 0.0, 0.0])
    assert repeatability(line, [line + [0.0, 1.0, 2.0], 1.7 * line]) == pytest.approx(0, abs=1e-12)
    s = np.linspace(0, 1, 2000)
    bent = np.column_stack([2 * s, 0.01 * np.sin(np.pi * s), 0 * s])
    assert repeatability(line, [bent]) == pytest.approx(0.01 / np.sqrt(2), rel=0.02)
    assert repeatability(line, []) is None


def test_certification_of_straight_lines(flat: GraspController) -> None:
    found = certification(flat, per_dimension=3)
    assert found["certified"] and found["k_min"] == 2.0 and found["other_minima"] == []
    assert found["starts"] == found["arrivals"] == 27 * 9
    assert found["n_minima"] == 9 and found["n_saddles"] == found["n_maxima"] == 0


def test_certification_names_traps_and_lost_starts(flat: GraspController) -> None:
    basis = flat.navigation.obstacle.chi.basis  # type: ignore[attr-defined]
    trap = flat.demonstrations[0].z_start + 0.5
    axes = [np.array([t[i + 1 : i + 4].mean() for i in range(7)]) for t in basis.knots]
    far = np.sum((np.stack(np.meshgrid(*axes, indexing="ij"), -1) - trap) ** 2, axis=-1)
    well = ExponentialObstacle(TensorBSpline(basis, 40 * np.exp(-far)), np.full(3, 0.1))
    navigation = NavigationFunction(well, 2.0)
    trapped = GraspController(flat.subspace, navigation, flat.demonstrations[:1])
    found = certification(trapped, per_dimension=3)
    assert not found["certified"] and found["k_min"] is None
    assert found["n_minima"] >= 2 and found["other_minima"]
    assert found["arrivals"] < found["starts"] == 27
    assert len(found["lost_starts"]) == found["starts"] - found["arrivals"]
    place = np.deg2rad(found["other_minima"][0]["z_deg"])
    goal = trapped.demonstrations[0].z_goal
    assert np.linalg.norm(navigation.value_and_gradient(place, goal)[1]) < 1e-2
    lost, paths = not_arriving(navigation, goal, grid(navigation, 3))
    assert len(lost) == len(paths) == len(found["lost_starts"])


def test_slices_hold_the_fields(flat: GraspController) -> None:
    goal = flat.demonstrations[0].z_goal
    cut = slice_through(flat.navigation, goal, (0, 2), resolution=15)
    assert cut.phi.shape == cut.ln_beta.shape == (15, 15) and cut.flow.shape == (15, 15, 2)
    z = np.array([cut.first[4], goal[1], cut.second[9]])
    phi, gradient = flat.navigation.value_and_gradient(z, goal)
    assert cut.phi[4, 9] == pytest.approx(phi)
    np.testing.assert_allclose(cut.flow[4, 9], -gradient[[0, 2]] / np.linalg.norm(gradient))
    assert cut.ln_beta[4, 9] == pytest.approx(
        flat.navigation.obstacle.evaluator(2.0)(z.tolist())[0]
    )
    for bad in ((0, 0), (0, 3)):
        with pytest.raises(InputError, match="two different"):
            slice_through(flat.navigation, goal, bad)
    points, flow, value = flow_lattice(flat.navigation, goal, 4)
    assert points.shape == flow.shape == (64, 3) and value.shape == (64,)
    np.testing.assert_allclose(np.linalg.norm(flow, axis=1), 1.0)


def test_eigengrasps_and_variances(recordings: RecordingSet) -> None:
    q = np.vstack([r.q for r in recordings])
    subspace = PostureSubspace(3).fit(q)
    ends = eigengrasps(subspace, 2.0)
    assert ends.shape == (3, 2, 22)
    np.testing.assert_allclose(ends.mean(axis=1), np.tile(subspace.mean_, (3, 1)))
    spread = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    np.testing.assert_allclose(spread, 4 * np.sqrt(subspace.explained_variance_))
    fractions = cumulative_variance(q)
    assert fractions.shape == (22,) and fractions[-1] == pytest.approx(1.0)
    np.testing.assert_allclose(fractions[:3], np.cumsum(subspace.explained_variance_ratio_))

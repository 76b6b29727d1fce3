"""Controllers remember how they were learned, and are told apart by what they do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import read_archive, write_archive
from handsim.learning.controller import SCHEMA, GraspController
from handsim.learning.learn import learn_controller, learn_like
from handsim.learning.options import (
    LEARNERS,
    METHODS,
    check_options,
    learner_with,
    options_of,
    usual_options,
)
from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.recordings.recording import RecordingSet

UNUSUAL = {
    "shape": (9, 9), "degree": 3, "k": 3.5, "smoothness": 1e-4, "ridge": 2e-5, "descent": 500.0,
    "margin": 0.3, "certified": False, "metric_ridge": None, "averaging": 0.1, "n_refinements": 1,
    "n_iterations": 12, "knot_rule": "equal", "seed": 7,
}  # fmt: skip
"""No option of the direction learner at its usual value, but those that cost time."""


@pytest.fixture(scope="module")
def few(recordings: RecordingSet) -> RecordingSet:
    return RecordingSet(recordings.recordings[3:6])


@pytest.fixture(scope="module")
def unusual(few: RecordingSet) -> GraspController:
    return learn_controller(few, n_components=2, options=UNUSUAL).controller


def tampered(controller: GraspController, folder: Path, **changes: object) -> Path:
    """Write a controller whose options are others."""
    controller.save(folder / "c.npz")
    metadata, arrays = read_archive(folder / "c.npz", "controller", SCHEMA)
    metadata = {key: value for key, value in metadata.items() if key not in ("kind", "schema")}
    metadata["options"] |= changes
    write_archive(folder / "c.npz", "controller", SCHEMA, metadata, arrays)
    return folder / "c.npz"


@pytest.mark.parametrize("method", METHODS)
def test_every_option_of_a_learner_is_kept(method: str) -> None:
    learner = LEARNERS[method]()
    assert set(options_of(learner)) == set(vars(learner)) == set(usual_options(method))
    assert "seed" in options_of(learner)


def test_the_file_holds_all_options_and_the_seed(unusual: GraspController, tmp_path: Path) -> None:
    assert dict(unusual.options) == UNUSUAL
    unusual.save(tmp_path / "c.npz")
    assert dict(GraspController.load(tmp_path / "c.npz").options) == UNUSUAL


@pytest.mark.parametrize("name", ["seed", "shape", "metric_ridge", "averaging", "n_iterations"])
def test_learned_alike_is_learned_with_every_option(
    name: str, unusual: GraspController, few: RecordingSet, tmp_path: Path
) -> None:
    unusual.save(tmp_path / "c.npz")
    again = learn_like(GraspController.load(tmp_path / "c.npz"), few)
    np.testing.assert_array_equal(coefficients(again), coefficients(unusual))
    other = {key: value for key, value in UNUSUAL.items() if key != name}
    assert learn_controller(few, 2, options=other).controller != unusual


def test_options_stand_above_the_seed_and_the_seed_matters(few: RecordingSet) -> None:
    quick = {"n_iterations": 5, "n_refinements": 0}
    first, second = (learn_controller(few, 2, seed=s, options=quick).controller for s in (0, 1))
    assert first.options["seed"] == 0 and second.options["seed"] == 1
    assert first != second
    assert learn_controller(few, 2, seed=1, options={**quick, "seed": 0}).controller == first


def test_summary_tells_the_options(few: RecordingSet) -> None:
    summary = learn_controller(few, 2, options=UNUSUAL).summary
    assert summary["options"] == UNUSUAL
    assert summary["certified"] is False


def test_an_option_from_the_future_is_named(unusual: GraspController, tmp_path: Path) -> None:
    path = tampered(unusual, tmp_path, curl=0.5)
    with pytest.raises(FileError, match=r"c.npz: option curl = 0.5 .* update handsim"):
        GraspController.load(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [("seed", "one"), ("knot_rule", 3), ("certified", 1), ("shape", "9"), ("shape", [9, "a"]),
     ("smoothness", True), ("margin", float("nan")), ("ridge", [1.0])],
)  # fmt: skip
def test_values_of_another_kind_are_refused(
    name: str, value: object, unusual: GraspController, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=f"option {name} = "):
        check_options("direction", {name: value})
    with pytest.raises(FileError):  # what is not a number is no JSON either
        GraspController.load(tampered(unusual, tmp_path, **{name: value}))


def test_unknown_methods_and_options() -> None:
    with pytest.raises(UnknownNameError, match="direction"):
        learner_with("directions", {})
    with pytest.raises(InputError, match="option metric_ridge"):
        learner_with("pde", {"metric_ridge": 1.0})
    assert learner_with("pde", {"weights": [1.0, 2.0, 3.0, 4.0]}).weights == (1.0, 2.0, 3.0, 4.0)
    assert learner_with("direction", {"shape": None, "metric_ridge": None}).metric_ridge is None


def test_files_of_earlier_schemas_tell_what_they_know() -> None:
    folder = Path(__file__).parents[1] / "data" / "schemas"
    first = GraspController.load(folder / "controller-1.npz")
    assert first.options["metric_ridge"] is None and first.options["averaging"] == 0.0
    second = GraspController.load(folder / "controller-2.npz")
    assert dict(second.options) == {"k": second.navigation.k, "certified": second.certified}


def coefficients(controller: GraspController) -> np.ndarray:
    assert isinstance(controller.navigation.obstacle, ExponentialObstacle)
    return controller.navigation.obstacle.chi.coefficients


def with_coefficients(controller: GraspController, c: np.ndarray) -> GraspController:
    obstacle = controller.navigation.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    changed = replace(obstacle, chi=TensorBSpline(obstacle.chi.basis, c))
    navigation = NavigationFunction(changed, controller.navigation.k, controller.navigation.metric)
    return replace(controller, navigation=navigation)


def test_the_last_bits_do_not_make_another_controller(unusual: GraspController) -> None:
    c = coefficients(unusual)
    noise = 1e-13 * np.random.default_rng(0).uniform(-1, 1, c.shape)
    same = with_coefficients(unusual, c * (1 + noise))
    assert same == unusual and hash(same) == hash(unusual)
    assert replace(unusual, options={}, method="direction") == unusual


def test_a_hundredth_of_one_coefficient_makes_another(unusual: GraspController) -> None:
    c = coefficients(unusual).copy()
    typical = np.unravel_index(np.argsort(np.abs(c), axis=None)[c.size // 2], c.shape)
    c[typical] *= 1.01
    changed = with_coefficients(unusual, c)
    assert changed != unusual and hash(changed) != hash(unusual)
    slower = replace(unusual, navigation=replace(unusual.navigation, k=3.6))
    renamed = replace(unusual, demonstrations=(replace(unusual.demonstrations[0], name="x"),))
    assert len({unusual, changed, slower, renamed, unusual}) == 4
    assert unusual != "a controller"

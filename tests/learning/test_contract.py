"""What every learner keeps: scikit-learn's contract, one way to fit, one way into a controller."""

import inspect
import pickle
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from sklearn.base import BaseEstimator, clone
from sklearn.exceptions import NotFittedError
from sklearn.pipeline import make_pipeline
from sklearn.utils import estimator_checks
from sklearn.utils.validation import check_is_fitted

from handsim.errors import FileError, HandsimError, InputError, UnknownNameError
from handsim.learning.base import Estimator, Learner
from handsim.learning.controller import GraspController
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.general.learner import NavigationLearner
from handsim.learning.learn import learn_controller, learn_like
from handsim.learning.options import LEARNERS
from handsim.learning.pde.learner import PDELearner
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.workspace import lay_basis
from handsim.recordings.recording import RecordingSet
from handsim.types import Array, Progress


class Straight(BaseEstimator):
    """A learner of another package: constant beta, whose flow is straight."""

    def __init__(
        self, k: float = 3.0, words: tuple[str, ...] = ("a",), weights: Array | None = None
    ) -> None:
        self.k = k
        self.words = words
        self.weights = weights

    def fit(
        self,
        paths: Sequence[Array],
        times: Sequence[Array] | None = None,
        *,
        progress: Progress | None = None,
    ) -> Self:
        assert times is not None and [len(t) for t in times] == [len(p) for p in paths]
        basis, width = lay_basis(list(paths))
        chi = TensorBSpline(basis, np.zeros(basis.shape))
        self.navigation_ = NavigationFunction(ExponentialObstacle(chi, width), self.k)
        return self


QUICK = {"shape": (7, 7), "n_iterations": 2}
LEARNERS_HERE: dict[str, Learner] = {
    "direction": DirectionLearner(**QUICK, n_refinements=1, certified=True),
    "pde": PDELearner(shape=(9, 9), n_iterations=2, weights=(1.0, 2.0, 3.0, 0.0)),
    "foreign": Straight(k=4.0),
}
"""Learners with parameters that are no defaults, and none that costs time."""
OWN = {name: LEARNERS_HERE[name] for name in LEARNERS}
ESTIMATORS: dict[str, Any] = {
    **OWN,
    "subspace": PostureSubspace(2),
    "navigation": NavigationLearner(k=3.0, n_refinements=0),
}

each_learner = pytest.mark.parametrize("learner", LEARNERS_HERE.values(), ids=LEARNERS_HERE)
each_own = pytest.mark.parametrize("learner", OWN.values(), ids=OWN)
each_estimator = pytest.mark.parametrize("estimator", ESTIMATORS.values(), ids=ESTIMATORS)


@pytest.fixture
def data() -> list[Array]:
    """Two curved paths in two dimensions."""
    s = np.linspace(0.0, 1.0, 40)[:, None]
    bend = np.sin(np.pi * s) * [0.2, -0.3]
    return [s * [1.0, 0.4] + bend, 0.1 + s * [-0.5, 0.8] - bend]


def fitted(estimator: Any, data: list[Array]) -> Any:
    """A fitted copy of a learner or of the subspace."""
    copy = clone(estimator)
    if isinstance(copy, PostureSubspace):
        return copy.fit(np.random.default_rng(0).normal(size=(40, 22)))
    if isinstance(copy, NavigationLearner):
        return learned_once()
    return copy.fit(data, [np.arange(len(path)) / 40 for path in data])


@cache
def learned_once() -> NavigationLearner:
    """It takes seconds."""
    s = np.linspace(0.0, 1.0, 40)[:, None]
    return clone(ESTIMATORS["navigation"]).fit([np.hstack([1 - s, np.sin(np.pi * s)])])


def learned_names(estimator: Any) -> set[str]:
    return {name for name in vars(estimator) if name.endswith("_")}


def test_all_learners_of_the_package_are_checked_here() -> None:
    assert set(OWN) == set(LEARNERS)
    assert {type(learner) for learner in OWN.values()} == set(LEARNERS.values())
    assert {type(estimator) for estimator in ESTIMATORS.values()} == set(Estimator.__subclasses__())


@each_estimator
@pytest.mark.parametrize(
    "check",
    [
        "check_parameters_default_constructible",
        "check_no_attributes_set_in_init",
        "check_get_params_invariance",
        "check_set_params",
        "check_estimator_repr",
        "check_estimator_cloneable",
        "check_valid_tag_types",
        "check_estimator_tags_renamed",
    ],
)
def test_what_scikit_learn_checks_without_data(estimator: Any, check: str) -> None:
    if not hasattr(estimator_checks, check):
        pytest.skip("not in this version of scikit-learn")
    getattr(estimator_checks, check)(type(estimator).__name__, estimator)


@each_estimator
def test_the_constructor_stores_what_it_is_given_and_nothing_else(estimator: Any) -> None:
    kind = type(estimator)
    marks = {name: object() for name in inspect.signature(kind).parameters}
    made = kind(**marks)
    assert vars(made) == marks == made.get_params()


@each_estimator
def test_a_copy_has_the_same_parameters_and_is_not_fitted(
    estimator: Any, data: list[Array]
) -> None:
    done = fitted(estimator, data)
    copy = clone(done)
    assert learned_names(done) and not learned_names(copy)
    assert copy.get_params() == done.get_params() == estimator.get_params()
    check_is_fitted(done)
    with pytest.raises(NotFittedError):
        check_is_fitted(copy)


@each_estimator
def test_parameters_are_changed_by_name_and_unknown_ones_refused(estimator: Any) -> None:
    copy = clone(estimator)
    name, value = next(iter(copy.get_params().items()))
    marker = object()
    assert copy.set_params(**{name: marker}) is copy
    assert copy.get_params()[name] is marker and getattr(estimator, name) == value
    before = copy.get_params()
    with pytest.raises(ValueError, match="no parameter absent") as raised:
        copy.set_params(**{name: value}, absent=1)
    assert isinstance(raised.value, InputError) and "\n" not in str(raised.value)
    assert copy.get_params() == before


@each_estimator
def test_repr_is_a_short_call_that_makes_the_same(estimator: Any) -> None:
    kind = type(estimator)
    assert repr(kind()) == f"{kind.__name__}()"
    again = eval(repr(estimator), {kind.__name__: kind})
    assert again.get_params() == estimator.get_params()
    assert "\n" not in repr(estimator)


def test_repr_shows_what_is_no_default() -> None:
    assert repr(PostureSubspace(2)) == "PostureSubspace(n_components=2)"
    assert repr(DirectionLearner(k=4.0, seed=3)) == "DirectionLearner(seed=3)"
    assert repr(DirectionLearner(shape=np.zeros(2))).startswith("DirectionLearner(shape=array(")  # type: ignore[arg-type]


@each_estimator
def test_nothing_that_fit_sets_is_there_before(estimator: Any, data: list[Array]) -> None:
    names = learned_names(fitted(estimator, data))
    assert len(names) >= 4
    assert names == {name for name in type(estimator).__annotations__ if name.endswith("_")}
    for name in names:
        assert not hasattr(clone(estimator), name)
        with pytest.raises(NotFittedError, match=f"no {name} yet; call fit first") as raised:
            getattr(clone(estimator), name)
        assert isinstance(raised.value, HandsimError)
    with pytest.raises(AttributeError, match="no attribute 'absent'"):
        _ = clone(estimator).absent


def test_a_subspace_that_is_not_fitted_cannot_be_used() -> None:
    for use in (
        lambda: PostureSubspace().transform(np.zeros(22)),
        lambda: PostureSubspace().inverse_transform(np.zeros(3)),
        lambda: PostureSubspace().to_arrays(),
    ):
        with pytest.raises(NotFittedError):
            use()


def test_the_subspace_works_in_a_pipeline() -> None:
    q = np.random.default_rng(0).normal(size=(40, 22))
    pipeline = make_pipeline(PostureSubspace(4), PostureSubspaceScale())
    np.testing.assert_array_equal(
        pipeline.fit(q).transform(q), 2.0 * PostureSubspace(4).fit(q).transform(q)
    )


class PostureSubspaceScale(BaseEstimator):
    """The next step of a pipeline."""

    def fit(self, z: Array, y: None = None) -> Self:
        self.factor_ = 2.0
        return self

    def transform(self, z: Array) -> Array:
        return self.factor_ * z


@each_estimator
def test_pickles_come_back(estimator: Any, data: list[Array]) -> None:
    done = fitted(estimator, data)
    again = pickle.loads(pickle.dumps(done))
    assert again.get_params() == done.get_params()
    assert learned_names(again) == learned_names(done)


@each_learner
def test_all_are_fitted_alike(learner: Learner) -> None:
    def shape(kind: type) -> list[tuple]:
        parameters = inspect.signature(kind.fit).parameters.values()  # type: ignore[attr-defined]
        return [(p.name, p.kind, p.default) for p in parameters]

    assert shape(type(learner)) == shape(Learner)


@each_learner
def test_fit_returns_the_learner_and_leaves_its_parameters_alone(
    learner: Learner, data: list[Array]
) -> None:
    copy, before = clone(learner), learner.get_params()
    kept = [path.copy() for path in data]
    assert copy.fit(data, [np.arange(len(path)) / 40 for path in data]) is copy
    assert copy.get_params() == before
    for path, same in zip(data, kept, strict=True):
        np.testing.assert_array_equal(path, same)
    assert isinstance(copy.navigation_, NavigationFunction)
    assert copy.navigation_.k == before["k"]


@each_own
def test_fit_takes_lists_and_tells_its_progress(learner: Learner, data: list[Array]) -> None:
    told: list[float] = []
    once = clone(learner).fit(data, progress=told.append)
    assert told == sorted(told) and told[-1] == 1.0
    lists: Any = tuple(path.tolist() for path in data)
    again = clone(learner).fit(lists)
    z, goal = data[0][5], data[0][-1]
    np.testing.assert_array_equal(
        once.navigation_.direction(z, goal), again.navigation_.direction(z, goal)
    )


@each_own
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"k": 1.5}, "k = 1.5; give 2 or more"),
        ({"k": None}, "k = None of"),
        ({"seed": "one"}, "seed = 'one' of .*; give something like 0"),
        ({"seed": -1}, "seed = -1 of .*; give 0 or more"),
        ({"n_iterations": 2.5}, "n_iterations = 2.5"),
        ({"n_iterations": -1}, "n_iterations = -1"),
        ({"smoothness": np.nan}, "smoothness = nan"),
        ({"smoothness": -1e-5}, "smoothness = -1e-05"),
        ({"degree": 0}, "degree = 0"),
        ({"shape": "9"}, "shape = '9'"),
        ({"shape": (9, True)}, "shape = "),
        ({"knot_rule": "evenly"}, "unknown knot_rule 'evenly'; did you mean"),
    ],
)
def test_parameters_are_checked_when_fitted(
    learner: Learner, changes: dict[str, Any], words: str, data: list[Array]
) -> None:
    copy = clone(learner).set_params(**changes)
    with pytest.raises(InputError, match=words) as raised:
        copy.fit(data)
    assert "\n" not in str(raised.value)
    assert not learned_names(copy)


@pytest.mark.parametrize(
    ("learner", "words"),
    [
        (PDELearner(solver="newton"), "unknown solver 'newton'"),  # type: ignore[arg-type]
        (PDELearner(speed="slow"), "unknown speed 'slow'"),  # type: ignore[arg-type]
        (PDELearner(weights=(1.0, 2.0)), "give 4, of J_PDE"),  # type: ignore[arg-type]
        (PDELearner(corridor=1), "corridor = 1"),  # type: ignore[arg-type]
        (DirectionLearner(certified=None), "certified = None"),  # type: ignore[arg-type]
        (DirectionLearner(averaging=-0.1), "averaging = -0.1"),
    ],
)
def test_parameters_of_one_learner_are_checked_too(
    learner: Learner, words: str, data: list[Array]
) -> None:
    with pytest.raises(InputError, match=words):
        learner.fit(data)


def test_numbers_of_numpy_are_numbers(data: list[Array]) -> None:
    learner = DirectionLearner(
        k=np.float64(4.0),
        seed=np.int64(1),
        shape=[np.int64(7), 7],
        n_iterations=np.int32(2),  # type: ignore[arg-type]
    )
    assert learner.fit(data).n_coefficients_ == 49


@each_own
@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda data: [], "0 paths"),
        (lambda data: [data[0], data[1][:, :1]], "path 1 of shape"),
        (lambda data: [data[0], data[1][:1]], "path 1 of shape"),
        (lambda data: [data[0].ravel()], "path 0 of shape"),
        (lambda data: [np.where(data[0] > 0.5, np.nan, data[0])], "finite"),
    ],
)
def test_paths_are_checked_when_fitted(
    learner: Learner, spoil: Any, words: str, data: list[Array]
) -> None:
    with pytest.raises(InputError, match=words):
        clone(learner).fit(spoil(data))


def test_measured_speeds_need_a_time_for_each_point(data: list[Array]) -> None:
    learner = PDELearner(speed="measured", shape=(9, 9), n_iterations=1)
    times = [np.arange(len(path)) / 40 for path in data]
    assert learner.fit(data, times).n_iterations_ == 1
    for wrong in (times[:1], [times[0], times[1][:-1]]):
        with pytest.raises(InputError, match="one time for each point"):
            learner.fit(data, wrong)


@pytest.fixture(scope="module")
def few(recordings: RecordingSet) -> RecordingSet:
    return recordings[3:6]


@each_learner
def test_a_controller_is_learned_with_any_learner(
    learner: Learner, few: RecordingSet, tmp_path: Path
) -> None:
    copy = clone(learner)
    learned = learn_controller(few, 2, copy)
    controller, summary = learned.controller, learned.summary
    assert controller.navigation is copy.navigation_
    assert summary["method"] == controller.method
    assert summary["options"] == dict(controller.options)
    assert summary["seconds"] > 0
    controller.save(tmp_path / "c.npz")
    loaded = GraspController.load(tmp_path / "c.npz")
    assert loaded == controller
    assert loaded.method == controller.method and loaded.options == controller.options
    again = learn_like(loaded, few, learner)
    assert again == controller
    assert not learned_names(learner)


@each_own
def test_a_learner_by_name_and_as_an_object_are_one(learner: Learner, few: RecordingSet) -> None:
    method = next(name for name, own in OWN.items() if own is learner)
    by_name = learn_controller(few, 2, method, options=learner.get_params()).controller  # type: ignore[arg-type]
    as_object = learn_controller(few, 2, clone(learner)).controller
    assert as_object == by_name
    assert (as_object.method, as_object.options) == (by_name.method, by_name.options)
    assert as_object.method == method and as_object.certified == by_name.certified


def test_a_learner_of_another_package_is_known_by_its_class(
    few: RecordingSet, tmp_path: Path
) -> None:
    learner = Straight(k=np.float64(5.0), words=("b", "c"), weights=np.zeros(3))
    learned = learn_controller(few, 2, learner)
    controller, summary = learned.controller, learned.summary
    assert controller.method == f"{Straight.__module__}.Straight"
    # An array is nothing that a file keeps among the options.
    assert dict(controller.options) == {"k": 5.0, "words": ("b", "c")}
    assert summary["n_coefficients"] is summary["iterations"] is summary["cost_end"] is None
    controller.save(tmp_path / "c.npz")
    loaded = GraspController.load(tmp_path / "c.npz")
    with pytest.raises(InputError, match=r"learned by .*\.Straight, which is not part") as raised:
        learn_like(loaded, few)
    assert "\n" not in str(raised.value)
    with pytest.raises(InputError, match="is not of method"):
        learn_like(loaded, few, DirectionLearner())
    slower = learn_like(loaded, few, Straight(k=2.5))
    assert slower.navigation.k == 2.5 and slower != loaded


def test_options_belong_to_the_learner_that_is_given(few: RecordingSet) -> None:
    asked: dict[str, Any]
    for asked in ({"k": 3.0}, {"certified": True}, {"seed": 1}, {"options": {"ridge": 0.0}}):
        with pytest.raises(InputError, match="to the learner itself"):
            learn_controller(few, 2, Straight(), **asked)


def test_an_unknown_method_is_no_class(few: RecordingSet, tmp_path: Path) -> None:
    from dataclasses import replace

    controller = learn_controller(few, 2, Straight()).controller
    for method in ("directions", "a..b", ".a", ""):
        replace(controller, method=method).save(tmp_path / "c.npz")
        with pytest.raises(FileError, match="unknown method"):
            GraspController.load(tmp_path / "c.npz")
        with pytest.raises(UnknownNameError):
            learn_controller(few, 2, method)  # type: ignore[arg-type]


def test_loading_a_controller_does_not_import_scikit_learn() -> None:
    code = (
        "import sys, handsim; from handsim.learning import learn; "
        "handsim.GraspController.load(handsim.data_folder('assets') / 'controller.npz'); "
        "print(sorted(name for name in sys.modules if name.partition('.')[0] == 'sklearn'))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"

"""Whether progress pays as a coordinate is found by leaving out, and stands in the controller."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.files import read_archive, write_archive
from handsim.learning.controller import SCHEMA, GraspController
from handsim.learning.demonstration import Demonstration
from handsim.learning.guide.choice import LeftOut, asked_of_progress
from handsim.learning.guide.chord_field import ChordField
from handsim.learning.guide.field import GuidedField
from handsim.learning.guide.gaussian_process import left_out_means, predicted, regression_weights
from handsim.learning.guide.predictor import GuideSettings, PathPredictor
from handsim.learning.learn import Learned, learn_controller, learn_like
from handsim.learning.movement.progress import minimum_jerk
from handsim.navigation.paths import at_arc_length, path_error
from handsim.recordings.recording import RecordingSet

S = np.linspace(0.0, 1.0, 100)
SETTINGS = GuideSettings()
QUICK = {"n_iterations": 6, "n_refinements": 1}


def demonstrated(points: np.ndarray) -> Demonstration:
    path = at_arc_length(points, S)
    progress = minimum_jerk(np.linspace(0.0, 1.0, 51), 1.0)
    return Demonstration(
        "d", "t", "cup", np.zeros(22), np.zeros(22), path[0], path[-1], 0.19, 0.085, 1.0, {},
        path, progress,
    )  # fmt: skip


def retracing(rng: np.random.Generator) -> Demonstration:
    """The hand reaches beyond its destination and comes back another way."""
    start, goal = rng.normal(0, 0.05, 3), np.array([0.5, 0.0, 0.0]) + rng.normal(0, 0.05, 3)
    out = start + S[:, None] * (np.array([1.0, 0.3, 0.0]) - start)
    return demonstrated(np.vstack([out, out[-1] + S[1:, None] * (goal - out[-1])]))


def whimsical(rng: np.random.Generator) -> Demonstration:
    """Each time another detour at first, more or less far; then the same wave at the same place."""
    start, goal = rng.normal(0, 0.05, 3), np.array([1.0, 0.0, 0.0]) + rng.normal(0, 0.05, 3)
    size = 0.6 * rng.choice([-1.0, 1.0]) * rng.uniform()
    detour, wave = size * bump(0.25, 0.04), 0.6 * (bump(0.6, 0.05) - bump(0.75, 0.05))
    aside = np.column_stack([np.zeros(100), detour, wave])
    return demonstrated(start + S[:, None] * (goal - start) + aside)


def bump(middle: float, width: float) -> np.ndarray:
    return np.exp(-0.5 * ((S - middle) / width) ** 2)


def total_error(found: Sequence[np.ndarray], shown: list[Demonstration]) -> float:
    """Sum of errors at equal steps of the paths' own lengths."""
    apart = [at_arc_length(a, S) - d.path for a, d in zip(found, shown, strict=True)]
    return float(sum(np.sqrt(np.mean(np.sum(each**2, axis=1))) for each in apart))


def made(kind, count: int = 16) -> list[Demonstration]:
    rng = np.random.default_rng(0)
    return [kind(rng) for _ in range(count)]


def test_left_out_in_closed_form_is_learned_again_without() -> None:
    rng = np.random.default_rng(1)
    root, values = rng.normal(size=(9, 9)), rng.normal(size=(9, 4))
    kernel = root @ root.T
    found = left_out_means(kernel, 0.3, values)
    for i in range(9):
        rest = np.delete(np.arange(9), i)
        weights = regression_weights(kernel[np.ix_(rest, rest)], 0.3, values[rest])
        np.testing.assert_allclose(found[i], predicted(kernel[rest, i], weights), atol=1e-10)


@pytest.mark.parametrize("by_progress", [True, False])
def test_guides_left_out_are_those_of_the_others(by_progress: bool) -> None:
    shown, settings = made(whimsical), replace(SETTINGS, progress=by_progress)
    found = PathPredictor.of(shown, settings).left_out()
    for i in (0, 7):
        others = PathPredictor.of(shown[:i] + shown[i + 1 :], settings)
        wanted = others.path(shown[i].z_start, shown[i].z_goal, "cup")
        assert path_error(found[i], wanted) < 0.02  # the ends' spread and mean are those of all


def test_people_who_retrace_have_progress_and_those_of_many_whims_do_not() -> None:
    back, whim = LeftOut.of(made(retracing), SETTINGS), LeftOut.of(made(whimsical), SETTINGS)
    assert back.progress_pays and back.with_progress < 0.5 * back.without_progress
    assert not whim.progress_pays and whim.without_progress < 0.95 * whim.with_progress


def test_figures_are_ratios_of_errors_left_out() -> None:
    shown = made(retracing)
    found = PathPredictor.of(shown, SETTINGS).left_out()
    straight = [d.z_start + S[:, None] * (d.z_goal - d.z_start) for d in shown]
    wanted = total_error(found, shown) / total_error(straight, shown)
    assert LeftOut.of(shown, SETTINGS).with_progress == pytest.approx(wanted)
    assert LeftOut.of(shown, replace(SETTINGS, progress=False)) == LeftOut.of(shown, SETTINGS)


def test_one_recording_and_equal_figures_take_progress() -> None:
    one = LeftOut.of(made(retracing, 1), SETTINGS)
    assert one.with_progress == pytest.approx(1.0) and one.progress_pays
    still = demonstrated(np.linspace([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 100))
    assert LeftOut.of([still, still], SETTINGS).progress_pays


def test_of_very_many_recordings_some_are_left_out() -> None:
    few, many = made(retracing, 3), made(retracing, 3) * 200
    assert LeftOut.of(few * 200, SETTINGS) == LeftOut.of(many[::3], SETTINGS)


def test_short_chords_bend_less_and_paths_begin_and_end_where_asked() -> None:
    asked = PathPredictor.of(made(whimsical), replace(SETTINGS, progress=False))
    start = np.array([0.5, 0.0, 0.0])
    bends = []
    for reach in (0.5, 0.1, 0.01, 0.0):
        goal = start + np.array([reach, 0.0, 0.0])
        path = asked.path(start, goal, "cup")
        np.testing.assert_array_equal(path[[0, -1]], [start, goal])
        np.testing.assert_allclose(path[:, 0], start[0] + reach * S, atol=1e-12)
        bends.append(np.abs(path[:, 1:]).max())
    assert bends[0] > bends[1] > 5 * bends[2] > 0.0 == bends[3]


@pytest.fixture(scope="module")
def learned(recordings: RecordingSet) -> Learned:
    few = RecordingSet(recordings.recordings[:6])
    return learn_controller(few, n_components=2, options=QUICK)


def test_learning_decides_and_tells(learned: Learned) -> None:
    controller, summary = learned.controller, learned.summary
    wanted = LeftOut.of(controller.demonstrations, SETTINGS)
    assert controller.left_out == wanted and summary["left_out"] == vars(wanted)
    assert controller.guide.progress is summary["by_progress"] is wanted.progress_pays
    assert asked_of_progress(controller.guide, controller.left_out) is None


def test_the_field_is_that_of_the_choice_and_the_file_keeps_it(
    learned: Learned, tmp_path: Path
) -> None:
    for progress, kind in ((True, GuidedField), (False, ChordField)):
        guide = replace(learned.controller.guide, progress=progress)
        controller = replace(learned.controller, guide=guide)
        goal = controller.demonstrations[0]
        field = controller.field(goal.z_start, goal.z_goal, goal.object)
        assert type(field) is kind and field.proven
        assert controller.path(goal.z_start, goal.z_goal, goal.object).arrived
        assert controller.postures(goal.q_start, goal.q_goal).arrived
        controller.save(tmp_path / "c.npz")
        read = GraspController.load(tmp_path / "c.npz")
        assert read.guide == guide and read.left_out == controller.left_out and read == controller
    assert controller != learned.controller or not learned.controller.guide.progress


def test_figures_and_progress_that_is_usual_do_not_make_another_controller(
    learned: Learned, tmp_path: Path
) -> None:
    guide = replace(learned.controller.guide, progress=True)
    controller = replace(learned.controller, guide=guide)
    assert replace(controller, left_out=None).digest == controller.digest
    replace(controller, left_out=None).save(tmp_path / "c.npz")
    metadata, _ = read_archive(tmp_path / "c.npz", "controller", SCHEMA)
    assert "progress" not in metadata["guide"] and "left_out" not in metadata
    assert GraspController.load(tmp_path / "c.npz").guide == guide


def test_what_was_asked_for_is_asked_for_again(recordings: RecordingSet) -> None:
    few = RecordingSet(recordings.recordings[:6])
    for asked in (True, False):
        found = learn_controller(few, 2, by_progress=asked, options=QUICK).controller
        assert found.guide.progress is asked
        pays = found.left_out.progress_pays
        assert asked_of_progress(found.guide, found.left_out) is (None if asked is pays else asked)
        for figures in (found.left_out, None):  # None: a file of an earlier version
            again = learn_like(replace(found, left_out=figures), few)
            assert again.guide.progress is asked
    with pytest.raises(InputError, match="without a guide"):
        learn_controller(few, 2, guided=False, by_progress=True)
    plain = learn_controller(few, 2, guided=False, options=QUICK)
    assert plain.summary["by_progress"] is None is plain.controller.left_out


@pytest.mark.parametrize(
    ("part", "value"),
    [("guide", {"progress": 1.0}), ("guide", {"progress": "yes"}),
     ("left_out", {"with_progress": -0.1}), ("left_out", {"without_progress": True})],
)  # fmt: skip
def test_damaged_choices_are_refused(
    learned: Learned, tmp_path: Path, part: str, value: dict[str, object]
) -> None:
    learned.controller.save(tmp_path / "c.npz")
    metadata, arrays = read_archive(tmp_path / "c.npz", "controller", SCHEMA)
    metadata = {key: kept for key, kept in metadata.items() if key not in ("kind", "schema")}
    metadata[part] = dict(metadata[part]) | value
    write_archive(tmp_path / "c.npz", "controller", SCHEMA, metadata, arrays)
    with pytest.raises(FileError, match="not a whole controller"):
        GraspController.load(tmp_path / "c.npz")

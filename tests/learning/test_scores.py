"""Scores in closed form, critical points and the inspection of what was learned."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.certification import _AT_ONCE, _lost_paths, certify, not_arriving
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.learn import learn_controller
from handsim.learning.movement.progress import ProgressLaw
from handsim.learning.scores import (
    direction_error,
    evaluate,
    leave_one_out,
    repeatability,
    roll_out,
    variance_explained,
)
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.critical_points import grid
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import path_error
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize


def straight(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
    away = goals - z
    return away / np.linalg.norm(away, axis=1, keepdims=True)


def controller(directions: Any = straight, mean: Any = 0.0) -> Any:
    """Follow the given directions; the subspace is three joints about ``mean``."""
    subspace = PostureSubspace(3)
    subspace.components_, subspace.mean_ = np.eye(22)[:3], np.zeros(22) + mean

    def path(z_start: np.ndarray, z_goal: np.ndarray, grasped: Any = None) -> FlowPath:
        return follow(directions, z_start[None], z_goal[None])[0]

    return SimpleNamespace(
        subspace=subspace,
        navigation=SimpleNamespace(directions=directions, obstacle=None, k=2.0, metric=None),
        path=path,
        field=lambda *query: None,
        predictor=None,
        progress=lambda z_start, z_goal, duration, grasped: ProgressLaw(duration),
        clipped=lambda q: q,
    )


S = np.linspace(0.0, 1.0, 2001)[:, None]


def arc(height: float, length: float = 1.0, tilt: float = 0.0) -> np.ndarray:
    """Half a sine, in three dimensions, from the origin along the first to ``length``."""
    return np.hstack([length * S, height * np.sin(np.pi * S) + tilt * S, 0 * S])


def recorded(z: np.ndarray, name: str, subject: str = "a", thing: str = "cup", task: str = "lift",
             outside: float = 0.0) -> Recording:  # fmt: skip
    """Return a recording with a path in the subspace, and a fourth joint ``outside`` it [rad]."""
    q = np.hstack([z, np.full((len(z), 1), outside), np.zeros((len(z), 18))])
    return Recording(
        name, np.arange(len(z)) / 100, q, 1, subject, thing, task, HandSize(0.19, 0.085)
    )


def rms(height: float) -> float:
    """Path error of a flat half sine against its chord [deg]: height / sqrt(2), at 100 points."""
    return float(np.rad2deg(height * np.sqrt(0.5 * 99 / 100)))


def test_errors_of_arcs_against_straight_lines_in_closed_form() -> None:
    few = RecordingSet((recorded(arc(0.02), "one"), recorded(arc(0.05), "two", thing="pen")))
    found = evaluate(controller(), few)
    for row, height in zip(found.per_recording, (0.02, 0.05), strict=True):
        assert row["path_error_deg"] == pytest.approx(rms(height), rel=0.01)
        assert row["straight_error_deg"] == pytest.approx(rms(height), rel=0.01)
        assert row["repeatability_deg"] is None and row["arrived"] is True
    assert found.ratio == pytest.approx(1.0, abs=1e-6)
    assert found.path_error_deg == pytest.approx((rms(0.02) + rms(0.05)) / 2, rel=0.01)
    assert found.repeatability_deg is None
    assert [(e["object"], e["n_recordings"]) for e in found.per_object] == [
        ("cup", 1),
        ("pen", 1),
    ]
    for entry, height in zip(found.per_object, (0.02, 0.05), strict=True):
        assert entry["path_error_deg"] == pytest.approx(rms(height), rel=0.01)


def test_the_ratio_is_of_what_is_followed_to_the_straight_line() -> None:
    """A flow towards the chord and on: on the arc's chord its error stays that of the chord.

    One that goes round the other side has twice the error, as both arcs lie apart by twice theirs.
    """

    def other_side(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        slope = -0.05 * np.pi * np.cos(np.pi * z[:, 0])
        along = np.column_stack([np.ones(len(z)), slope, np.zeros(len(z))])
        return along / np.linalg.norm(along, axis=1, keepdims=True)

    found = evaluate(controller(other_side), RecordingSet((recorded(arc(0.05), "one"),)))
    assert found.n_arrived == 1
    assert found.ratio == pytest.approx(2.0, rel=0.01)
    assert found.path_error_deg == pytest.approx(2 * found.straight_error_deg, rel=0.01)


def test_those_that_do_not_arrive_are_counted_and_scored_as_they_are() -> None:
    def away(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return np.tile([-1.0, 0.0, 0.0], (len(z), 1))

    few = RecordingSet((recorded(arc(0.0), "one"), recorded(arc(0.0, 0.5), "two")))
    found = evaluate(controller(away), few)
    assert found.n_recordings == 2 and found.n_arrived == 0
    assert [row["arrived"] for row in found.per_recording] == [False, False]
    assert found.path_error_deg > 100
    assert found.ratio is None  # straight movements leave nothing to compare with


def test_flows_are_followed_from_the_first_posture_to_the_last() -> None:
    paths = [arc(0.1, 1.0, 0.2), 0.3 + arc(0.0, 0.4)]
    for path in paths:
        followed = roll_out(controller(), path)
        np.testing.assert_array_equal(followed.points[[0, -1]], path[[0, -1]])


def test_the_direction_error_of_a_turned_line() -> None:
    """A flow turned by an angle from a straight movement is wrong by that angle, either way."""
    path = arc(0.0)
    for angle in (-0.4, 0.0, 0.3, 2.5):

        def turned(z: np.ndarray, goals: np.ndarray, a: float = angle) -> np.ndarray:
            np.testing.assert_array_equal(goals, path[-1])  # the movement's own destination
            return np.tile([np.cos(a), np.sin(a), 0.0], (len(z), 1))

        assert direction_error(controller(turned), path) == pytest.approx(abs(angle), abs=1e-6)

    def half(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return np.where(z[:, :1] < 0.485, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])

    # 0 over the first half of the 97 %, a right angle over the second.
    assert direction_error(controller(half), path) == pytest.approx(np.pi / 4, rel=1e-6)


def test_directions_are_not_compared_near_the_end() -> None:
    """Over the last 3 % of its length a recording turns back: that is noise of its end."""
    s = np.linspace(0.0, 1.0, 1001)
    hooked = np.column_stack([np.minimum(s, 1.96 - s), 0 * s, 0 * s])
    kept = np.column_stack([np.minimum(s, 1.9 - s), 0 * s, 0 * s])

    def onwards(z: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return np.tile([1.0, 0.0, 0.0], (len(z), 1))

    assert direction_error(controller(onwards), hooked[:-1]) == pytest.approx(0.0, abs=1e-7)
    assert direction_error(controller(onwards), kept) > 0.05


def test_variance_explained_is_about_the_mean_of_the_subspace() -> None:
    """Postures (x, 0, 0, d) about a mean m: sum d^2 is missed of sum |q - m|^2."""
    z = np.linspace([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 50)
    few = RecordingSet((recorded(z, "one", outside=0.2),))
    total = np.sum((z[:, 0] - 0.3) ** 2) + 50 * 0.2**2
    mean = np.array([0.3, *np.zeros(21)])
    found = variance_explained(controller(mean=mean), few)
    assert found == pytest.approx(1 - 50 * 0.2**2 / total)
    assert evaluate(controller(mean=mean), few).variance_explained == found


def test_only_the_same_person_repeats_the_same_task_with_the_same_object() -> None:
    """Half sines of different height, repeated: the error is that of the difference."""
    rows = (
        recorded(arc(0.02), "one"),
        recorded(arc(0.05), "two"),
        recorded(arc(0.09), "three"),
        recorded(arc(0.30), "other person", subject="b"),
        recorded(arc(0.40), "other object", thing="pen"),
        recorded(arc(0.50), "other task", task="turn"),
        recorded(arc(0.25), "again", subject="c"),
        recorded(arc(0.25), "just so", subject="c"),
    )
    found = [
        row["repeatability_deg"] for row in evaluate(controller(), RecordingSet(rows)).per_recording
    ]
    expected = [
        (rms(0.03) + rms(0.07)) / 2,
        (rms(0.03) + rms(0.04)) / 2,
        (rms(0.07) + rms(0.04)) / 2,
    ]
    np.testing.assert_allclose(found[:3], expected, rtol=0.02)
    assert found[3:6] == [None, None, None]
    np.testing.assert_allclose(found[6:], 0.0, atol=1e-3)


def test_scoring_says_how_far_it_is() -> None:
    fractions: list[float] = []
    rows = (recorded(arc(0.1), "one"), recorded(arc(0.2), "two"))
    evaluate(controller(), RecordingSet(rows), progress=fractions.append)
    assert fractions == [0.5, 1.0]


def test_the_one_left_out_is_scored_and_not_learned_from() -> None:
    rows = [recorded(arc(0.01 * (i + 1), 1.0 + i), f"{i}", outside=0.1 * i) for i in range(3)]
    learned, fractions = [], []

    def learn(others: RecordingSet) -> Any:
        learned.append([recording.name for recording in others])
        return controller(mean=0.01 * len(learned))

    few = RecordingSet(tuple(rows))
    found = leave_one_out(few, learn, fractions.append)
    assert learned == [["1", "2"], ["0", "2"], ["0", "1"]]
    np.testing.assert_allclose(fractions, [1 / 3, 2 / 3, 1.0])
    assert [row["name"] for row in found.per_recording] == ["0", "1", "2"]
    alone = [
        variance_explained(controller(mean=0.01 * (i + 1)), RecordingSet((rows[i],)))
        for i in range(3)
    ]
    assert found.variance_explained == pytest.approx(np.mean(alone))
    # Straight flows from its own start to its own end: as good as its own chord.
    for row in found.per_recording:
        assert row["path_error_deg"] == pytest.approx(row["straight_error_deg"], rel=1e-6)
        assert row["arrived"]
    errors = [row["straight_error_deg"] for row in found.per_recording]  # each its own
    np.testing.assert_allclose(errors, [rms(0.01), rms(0.02), rms(0.03)], rtol=0.01)
    whole = evaluate(controller(), few).per_recording
    repeats = [row["repeatability_deg"] for row in found.per_recording]
    np.testing.assert_allclose(repeats, [row["repeatability_deg"] for row in whole], rtol=1e-6)
    assert leave_one_out(RecordingSet(tuple(rows[:2])), learn).n_recordings == 2
    with pytest.raises(InputError, match="at least 2"):
        leave_one_out(RecordingSet(tuple(rows[:1])), learn)


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
    assert found.ratio == pytest.approx(1.0, abs=1e-6)
    assert found.n_arrived == found.n_recordings == len(found.per_recording) == 9
    assert found.variance_explained > 0.99
    row = found.per_recording[4]
    path = flat.subspace.transform(recordings[4].q)
    assert row["name"] == recordings[4].name and row["arrived"]
    expected = np.rad2deg(path_error(path[[0, -1]], path))
    assert row["straight_error_deg"] == pytest.approx(expected)
    assert 5 < found.direction_error_deg < 90
    assert [entry["n_recordings"] for entry in found.per_object] == [3, 3, 3]
    errors = [entry["path_error_deg"] for entry in found.per_object]
    assert np.mean(errors) == pytest.approx(found.path_error_deg)


def test_learning_beats_straight_lines_also_on_what_is_left_out(recordings: RecordingSet) -> None:
    few = RecordingSet(recordings.recordings[:3])
    learned = evaluate(learn_controller(few, n_components=2).controller, few)
    assert learned.n_arrived == 3 and learned.ratio < 0.3
    assert learned.direction_error_deg < 15
    calls: list[float] = []
    left = leave_one_out(
        few, lambda r: learn_controller(r, n_components=2).controller, calls.append
    )
    assert left.n_recordings == 3 and calls[-1] == 1.0 and len(calls) == 3
    assert left.ratio < 0.8
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
    found = certify(flat, per_dimension=3)
    assert found.certified and found.k_min == 2.0 and found.other_minima == ()
    assert found.starts == found.arrivals == 27 * 9
    assert found.n_minima == 9 and found.n_saddles == found.n_maxima == 0


def test_certification_names_traps_and_lost_starts(flat: GraspController) -> None:
    basis = flat.navigation.obstacle.chi.basis  # type: ignore[attr-defined]
    trap = flat.demonstrations[0].z_start + 0.5
    axes = [np.array([t[i + 1 : i + 4].mean() for i in range(7)]) for t in basis.knots]
    far = np.sum((np.stack(np.meshgrid(*axes, indexing="ij"), -1) - trap) ** 2, axis=-1)
    well = ExponentialObstacle(TensorBSpline(basis, 40 * np.exp(-far)), np.full(3, 0.1))
    navigation = NavigationFunction(well, 2.0)
    trapped = GraspController(flat.subspace, navigation, flat.demonstrations[:1])
    found = certify(trapped, per_dimension=3)
    assert not found.certified and found.k_min is None
    assert found.n_minima >= 2 and found.other_minima
    assert found.arrivals < found.starts == 27
    assert len(found.lost_starts) == found.starts - found.arrivals
    place = np.deg2rad(found.other_minima[0]["z_deg"])
    goal = trapped.demonstrations[0].z_goal
    assert np.linalg.norm(navigation.value_and_gradient(place, goal)[1]) < 1e-2
    lost, paths = not_arriving(navigation, goal, grid(navigation, 3))
    assert len(lost) == len(paths) == len(found.lost_starts)


def test_numbers_of_objects_are_told_where_the_controller_knows_objects_by_them(
    recordings: RecordingSet,
) -> None:
    """Widths that differ are numbers; one that all share tells nothing, and names are told."""
    widths = {name: 0.02 * i for i, name in enumerate(dict.fromkeys(r.object for r in recordings))}
    told = RecordingSet(tuple(
        replace(r, extra={"object_width_m": str(widths[r.object])}) for r in recordings
    ))  # fmt: skip
    same = RecordingSet(tuple(replace(r, extra={"object_width_m": "0.05"}) for r in recordings))
    few = RecordingSet((*told.recordings[:-1], replace(told[-1], extra={})))
    names = evaluate(learn_controller(recordings).controller, recordings)
    for those in (same, few):
        assert evaluate(learn_controller(those).controller, those).ratio == names.ratio
    by_width = learn_controller(told).controller
    assert by_width.predictor is not None
    assert by_width.predictor.objects[0].numbers == ("object_width_m",)
    assert evaluate(by_width, told).ratio == pytest.approx(names.ratio, abs=0.05)


def test_each_destination_has_its_own_lost_starts_however_many_are_followed_at_once() -> None:
    """A flow straight to the destination, but from above to destinations on the right."""

    class Walled:
        def directions(self, points: np.ndarray, goals: np.ndarray) -> np.ndarray:
            away = goals - points
            free = (goals[:, :1] < 0) | (points[:, 1:] < 0.5)
            return free * away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)

    side = np.linspace(-1, 1, 15)
    starts = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    goals = np.array([[-0.9, 0.0], [0.9, 0.0], [-0.5, -0.3], [0.5, 0.1]])
    navigation = cast("NavigationFunction", Walled())
    assert len(starts) * len(goals) > _AT_ONCE, "more than one part"
    found = list(_lost_paths(navigation, goals, starts))
    assert len(found) == 4
    for goal, (lost, paths) in zip(goals, found, strict=True):
        expected = starts[starts[:, 1] >= 0.5] if goal[0] > 0 else starts[:0]
        np.testing.assert_array_equal(lost, expected)
        begun = np.array([path.points[0] for path in paths]).reshape(-1, 2)
        np.testing.assert_array_equal(begun, expected)
        alone, _ = not_arriving(navigation, goal, starts)
        np.testing.assert_array_equal(alone, lost)

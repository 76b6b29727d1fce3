"""The controller, whichever learner made it: one contract; files; postures; bad input."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import read_archive, write_archive
from handsim.joints import JOINT_INDEX, LOWER, N_JOINTS, UPPER
from handsim.learning.controller import SCHEMA, GraspController
from handsim.learning.learn import Learned, learn_controller
from handsim.learning.options import METHODS, Method
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import path_error
from handsim.recordings.plausibility import ImplausibleError
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize

SUMMARY = {
    "method", "n_recordings", "n_components", "variance_explained", "n_coefficients", "iterations",
    "seconds", "cost_start", "cost_end",
}  # fmt: skip


@pytest.fixture(scope="module", params=METHODS)
def learned(request: pytest.FixtureRequest, recordings: RecordingSet) -> tuple:
    method: Method = request.param
    # One object, and for the paper's learner one trial: what each can do.
    some = RecordingSet(recordings.recordings[3 : 4 if method == "pde" else 6])
    return learn_controller(some, method=method)


def test_learning_contract(learned: Learned) -> None:
    controller, summary = learned.controller, learned.summary
    assert set(summary) >= SUMMARY
    assert summary["n_recordings"] == len(controller.demonstrations) in (1, 3)
    assert summary["n_components"] == controller.navigation.n_dimensions == 3
    assert 0.9 < summary["variance_explained"] <= 1
    assert summary["cost_end"] < summary["cost_start"]
    assert summary["iterations"] > 0 and summary["seconds"] > 0


def test_controller_contract(learned: Learned) -> None:
    controller = learned.controller
    for demonstration in controller.demonstrations:
        z, goal = demonstration.z_start, demonstration.z_goal
        phi, gradient = controller.navigation.value_and_gradient(z, goal)
        assert 0 < phi < 1
        np.testing.assert_allclose(controller.velocity(z, goal), -gradient)
        direction = controller.direction(z, goal)
        np.testing.assert_allclose(direction, -gradient / np.linalg.norm(gradient), atol=1e-9)
        np.testing.assert_array_equal(controller.velocity(goal, goal), np.zeros(3))
        path = controller.path(z, goal)
        assert path.arrived
        np.testing.assert_array_equal(path.points[[0, -1]], [z, goal])


def test_saved_and_loaded_it_is_the_same(learned: Learned, tmp_path: Path) -> None:
    controller = learned.controller
    controller.save(tmp_path / "c.npz")
    loaded = GraspController.load(tmp_path / "c.npz")
    assert loaded.digest == controller.digest
    assert loaded.method == controller.method
    one, other = controller.demonstrations[-1], loaded.demonstrations[-1]
    assert (one.name, one.task, one.object, one.duration) == (
        other.name, other.task, other.object, other.duration
    )  # fmt: skip
    for name in ("q_start", "q_goal", "z_start", "z_goal"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    sequence = loaded.postures(one.q_start, one.q_goal)
    np.testing.assert_array_equal(sequence.q, controller.postures(one.q_start, one.q_goal).q)
    controller.save(tmp_path / "d.npz")
    assert (tmp_path / "c.npz").read_bytes() == (tmp_path / "d.npz").read_bytes()


def test_digests_tell_controllers_apart(learned: Learned) -> None:
    controller = learned.controller
    faster = NavigationFunction(controller.navigation.obstacle, controller.navigation.k + 1)
    changed = GraspController(controller.subspace, faster, controller.demonstrations)
    assert changed.digest != controller.digest


@pytest.mark.parametrize("time_law", ["learned", "minimum-jerk", "gradient"])
def test_postures_follow_the_path_in_time(learned: Learned, time_law: str) -> None:
    controller = learned.controller
    one = controller.demonstrations[0]
    sequence = controller.postures(
        one.q_start, one.q_goal, time_law=time_law, duration=1.5, rate=200.0
    )
    assert sequence.arrived and sequence.reason == "arrived"
    np.testing.assert_allclose(sequence.time, np.arange(301) / 200)
    assert ((sequence.q >= controller.ranges[0]) & (sequence.q <= controller.ranges[1])).all()
    lifted = controller.subspace.inverse_transform(one.z_start)
    np.testing.assert_allclose(sequence.q[0], controller.clipped(lifted), atol=1e-12)
    # The speeds of the paper are those of the field; clipping is too slight to matter here.
    z = controller.subspace.transform(sequence.q)
    followed = replace(controller, guide=None) if time_law == "gradient" else controller
    path = followed.path(one.z_start, one.z_goal).points
    assert path_error(z, path) < np.deg2rad(2.0)
    speed = np.linalg.norm(np.diff(z, axis=0), axis=1)
    if time_law == "minimum-jerk":  # bell-shaped
        assert speed[:5].max() < 0.1 * speed.max() and speed[-5:].max() < 0.1 * speed.max()
        assert 100 < np.argmax(speed) < 200
    elif time_law == "learned":  # the recordings move at a constant speed
        assert speed.max() < 1.5 * speed.min()
    else:  # falling towards the destination
        assert speed[-20:].max() < 0.3 * speed.max()


def test_gradient_law_has_the_speeds_of_phi(learned: Learned) -> None:
    controller = learned.controller
    one = controller.demonstrations[0]
    sequence = controller.postures(one.q_start, one.q_goal, time_law="gradient", rate=500.0)
    z = controller.subspace.transform(sequence.q)
    inside = ((sequence.q > LOWER) & (sequence.q < UPPER)).all(axis=1)
    middle = np.arange(len(z) // 10, len(z) // 2)
    middle = middle[inside[middle] & inside[middle + 1]]
    assert len(middle) > 20
    speed = np.linalg.norm(z[middle + 1] - z[middle], axis=1) * 500
    field = [np.linalg.norm(controller.velocity(x, one.z_goal)) for x in z[middle]]
    scale = speed / np.array(field)  # one time scale for all
    assert scale.std() / scale.mean() < 0.1


def test_durations_default_to_the_recorded(learned: Learned) -> None:
    controller = learned.controller
    one = controller.demonstrations[0]
    sequence = controller.postures(one.q_start, z_goal=one.z_goal)
    assert sequence.time[-1] == pytest.approx(controller.median_duration, abs=0.01)
    assert controller.median_duration == pytest.approx(79 / 50)


def test_closed_loop_from_a_push(learned: Learned) -> None:
    controller = learned.controller
    if controller.method != "direction":
        pytest.skip("the paper's field is only known to lead back from near the recordings")
    one = controller.demonstrations[0]
    timing = controller.timing(one.z_start, one.z_goal, 1.5)
    z, push = one.z_start.copy(), np.deg2rad(20.0) * np.array([0.6, -0.8, 0.0])
    for i in range(170):
        z = z + (push if i == 60 else 0.0) + 0.01 * timing.velocities(z[None], 0.01 * i)[0]
    assert np.linalg.norm(z - one.z_goal) < np.deg2rad(2.0)


def test_demonstrations_are_found_by_name_and_task(learned: Learned) -> None:
    controller = learned.controller
    last = controller.demonstrations[-1].name
    assert controller.demonstration(last).name == last
    assert controller.demonstration("object-1-grasp").name == "object-1-0"


def test_demonstrations_are_found_by_object_the_first_of_several(learned: Learned) -> None:
    controller = learned.controller
    assert controller.demonstration("object-1").name == "object-1-0"
    with pytest.raises(UnknownNameError, match="'objekt-1'; did you mean object-1") as raised:
        controller.demonstration("objekt-1")
    assert "task, recording or object" in str(raised.value)
    assert set(raised.value.known) >= {"object-1", "object-1-0", "object-1-grasp"}


def test_the_name_of_a_task_goes_before_that_of_an_object(learned: Learned) -> None:
    one = replace(learned.controller.demonstrations[0], name="a", task="cube-raise", object="pen")
    other = replace(one, name="b", task="pen", object="cube")
    controller = replace(learned.controller, demonstrations=(one, other))
    assert controller.demonstration("pen") is other
    assert controller.demonstration("cube") is other
    assert controller.demonstration("cube-raise") is one


def test_bad_input(learned: Learned) -> None:
    controller = learned.controller
    one = controller.demonstrations[0]
    for arguments, words in (
        ({}, "one destination"),
        ({"q_goal": one.q_goal, "z_goal": one.z_goal}, "one destination"),
        ({"q_goal": one.q_goal[:5]}, "22 finite angles"),
        ({"z_goal": np.array([50.0, 0.0, 0.0])}, "outside the workspace"),
        ({"z_goal": np.array([np.nan, 0.0, 0.0])}, "finite"),
        ({"q_goal": one.q_goal, "duration": -1.0}, "seconds"),
        ({"q_goal": one.q_goal, "rate": 0.0}, "rate"),
        ({"q_goal": one.q_goal, "time_law": "linear"}, "time law"),
    ):
        with pytest.raises(InputError, match=words):
            controller.postures(one.q_start, **arguments)
    with pytest.raises(InputError, match="start of shape"):
        controller.path(one.z_start[:1], one.z_goal)


def test_a_trap_is_a_result_with_a_reason(learned: Learned) -> None:
    """A wall of low beta across the way: the sequence ends where the flow does."""
    controller = learned.controller
    if controller.method != "direction":
        pytest.skip("the trap is planted in an exponential obstacle")
    obstacle = controller.navigation.obstacle
    one = controller.demonstrations[0]
    basis = obstacle.chi.basis
    axes = [
        np.array([knots[i + 1 : i + 4].mean() for i in range(m)])
        for knots, m in zip(basis.knots, basis.shape, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    middle = 0.5 * (one.z_start + one.z_goal)
    hill = 30.0 * np.exp(-np.sum((grid - middle) ** 2, axis=-1) / 0.3**2)
    planted = ExponentialObstacle(TensorBSpline(basis, hill), obstacle.width)
    trapped = GraspController(
        controller.subspace, NavigationFunction(planted, 4.0), controller.demonstrations
    )
    sequence = trapped.postures(one.q_start, one.q_goal)
    assert not sequence.arrived and sequence.reason == "stuck"


def test_damaged_and_foreign_files(learned: Learned, tmp_path: Path) -> None:
    path = tmp_path / "c.npz"
    learned.controller.save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileError, match="cut off"):
        GraspController.load(path)
    with pytest.raises(FileError, match="no such file"):
        GraspController.load(tmp_path / "absent.npz")
    path.write_bytes(whole)
    metadata, arrays = read_archive(path, "controller", SCHEMA)
    metadata = {k: v for k, v in metadata.items() if k not in ("kind", "schema")}
    for kind, schema, lost, words in (
        ("rollout", 1, "", "not a controller"),
        ("controller", 99, "", "schema 99"),
        ("controller", 1, "coefficients", "coefficients"),
        ("controller", 1, "z_goal", "z_goal"),
        *[("controller", 2, name, name) for name in arrays if name.startswith("metric")],
    ):
        kept = {name: array for name, array in arrays.items() if name != lost}
        write_archive(path, kind, schema, metadata, kept)
        with pytest.raises(FileError, match=words):
            GraspController.load(path)


def test_what_cannot_be_learned(recordings: RecordingSet) -> None:
    with pytest.raises(UnknownNameError, match="direction"):
        learn_controller(recordings, method="directions")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="1 to 5"):
        learn_controller(recordings, n_components=6)
    with pytest.raises(InputError, match="2 or more"):
        learn_controller(recordings, k=1.0)
    with pytest.raises(InputError, match="cannot be certified"):
        learn_controller(recordings, method="pde", certified=True)
    still = recordings[0]
    frozen = Recording(
        "a", still.time, np.tile(still.q[0], (80, 1)), 1, "", "", "", HandSize(0.19, 0.085)
    )
    with pytest.raises(ImplausibleError, match="does not reach for anything"):
        learn_controller(RecordingSet((frozen,)))
    with pytest.raises(InputError, match="vary in 0 directions"):
        learn_controller(RecordingSet((frozen,)), accept=("small", "constant"))


def test_identical_recordings_are_learned_as_one(recordings: RecordingSet) -> None:
    one = recordings[0]
    twins = tuple(
        Recording(name, one.time, one.q, i, "", "", "t", HandSize(0.19, 0.085))
        for i, name in enumerate(("a", "b"))
    )
    controller = learn_controller(RecordingSet(twins), n_components=2).controller
    assert controller.postures(one.q[0], one.q[-1]).arrived


def test_postures_stay_in_the_joint_ranges(learned: Learned) -> None:
    """Recorded angles may leave the ranges; what drives the hand may not."""
    controller = learned.controller
    arrays = controller.subspace.to_arrays()
    arrays["subspace_mean"] = arrays["subspace_mean"] + 2.0
    beyond = GraspController(
        PostureSubspace.from_arrays(arrays), controller.navigation, controller.demonstrations
    )
    one = controller.demonstrations[0]
    q = beyond.postures(one.q_start + 2.0, z_goal=one.z_goal).q
    assert ((q >= LOWER) & (q <= UPPER)).all()
    assert (q[0] == UPPER).sum() > 5


def test_ranges_are_the_persons_and_what_they_keep_away_has_not_arrived(
    recordings: RecordingSet,
) -> None:
    """A glove that leaves the ranges: the hand follows, as far as it was recorded to."""
    joint = JOINT_INDEX["palm_arch"]
    far = [replace(r, q=r.q + np.eye(N_JOINTS)[joint]) for r in recordings]
    controller = learn_controller(RecordingSet(tuple(far)), accept=["range"]).controller
    highest = max(r.q[:, joint].max() for r in far)
    assert controller.ranges[1, joint] == highest > UPPER[joint]
    others = np.arange(N_JOINTS) != joint
    assert (controller.ranges[0] <= LOWER).all()
    assert (controller.ranges[1, others] >= UPPER[others]).all()
    goal = controller.demonstrations[0]
    movement = controller.postures(goal.q_start, goal.q_goal)
    assert movement.arrived and movement.goal_distance < np.deg2rad(4)
    narrow = replace(controller, ranges=np.array([LOWER, UPPER]))
    clipped = narrow.postures(goal.q_start, goal.q_goal)
    assert narrow.path(goal.z_start, goal.z_goal).arrived
    assert not clipped.arrived and clipped.reason == "clipped"
    away = clipped.q[-1] - controller.subspace.inverse_transform(goal.z_goal)
    assert clipped.goal_distance == pytest.approx(np.linalg.norm(away))
    assert clipped.goal_distance > np.deg2rad(30)


def test_a_guided_controller_is_told_the_object(recordings: RecordingSet, tmp_path: Path) -> None:
    controller = learn_controller(recordings).controller
    one, other = controller.demonstrations[0], controller.demonstrations[-1]
    known = controller.path(one.z_start, one.z_goal, one.object).points
    wrong = controller.path(one.z_start, one.z_goal, other.object).points
    assert path_error(known, one.path) < 0.5 * path_error(wrong, one.path)
    controller.save(tmp_path / "c.npz")
    read = GraspController.load(tmp_path / "c.npz")
    np.testing.assert_array_equal(read.path(one.z_start, one.z_goal, one.object).points, known)
    assert read.guide == controller.guide and read == controller
    controller.check_object(one.object)
    with pytest.raises(UnknownNameError, match="did you mean object-1"):
        controller.check_object("objekt-1")


def test_destinations_far_from_all_recordings_are_refused(recordings: RecordingSet) -> None:
    controller = learn_controller(recordings).controller
    low, high = controller.reach
    field_only = replace(controller, guide=None)
    start = controller.demonstrations[0].z_start
    inner = field_only.reach[1]
    for goal in (0.99 * high + 0.01 * low, 0.01 * high + 0.99 * low):
        assert controller.path(start, goal).arrived
        assert controller.field(start, goal).proven
    for learned, goal in ((controller, high + 0.01), (field_only, inner + 0.001)):
        with pytest.raises(InputError, match="is outside the workspace"):
            learned.path(start, goal)

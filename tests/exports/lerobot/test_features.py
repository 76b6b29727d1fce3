"""What LeRobot calls the quantities of a movement, and on which frames they stand."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.exports.episode import Episode
from handsim.exports.export_sources import episodes_of
from handsim.exports.lerobot.feature_statistics import PixelCounts, statistics_of
from handsim.exports.lerobot.features import Plan, Take, plan_of, take_of, usual_fps
from handsim.grasping.rollout.record import Rollout
from handsim.joints import JOINT_NAMES
from handsim.recordings.recording import RecordingSet


def values(take: Take, name: str) -> np.ndarray:
    return next(each.values for each in take.features if each.name == name)


def names(take: Take, name: str) -> tuple[str, ...]:
    return next(each.names for each in take.features if each.name == name)


@pytest.fixture
def flown(flying: Rollout) -> Episode:
    return episodes_of(flying)[0]


def test_a_rollout_on_its_own_frames_is_taken_as_it_is(flown: Episode, flying: Rollout) -> None:
    take = take_of(flown, plan_of([flown]))
    assert not take.resampled
    assert np.array_equal(take.time, flying.time)
    assert [each.name for each in take.features] == [
        "observation.state", "observation.environment_state", "observation.forces", "action",
        "next.done", "next.success",
    ]  # fmt: skip
    model = flying.model()
    at = [model.joint(name).qposadr[0] for name in JOINT_NAMES]
    state = np.hstack([flying.qpos[:, at], flying.qpos[:, 7:14]]).astype(np.float32)
    assert np.array_equal(values(take, "observation.state"), state)
    assert names(take, "observation.state")[-8:-4] == (
        "wrist_deviation_rad", "forearm_x_m", "forearm_y_m", "forearm_z_m",
    )  # fmt: skip
    actuators = [model.actuator(name).id for name in JOINT_NAMES]
    commanded = [flying.ctrl[:, actuators], flying.mocap_pos, flying.mocap_quat]
    assert np.array_equal(values(take, "action"), np.hstack(commanded).astype(np.float32))
    pose = values(take, "observation.environment_state")
    assert np.array_equal(pose, flying.qpos[:, :7].astype(np.float32))
    forces = np.column_stack([flying.contact_force, flying.table_force])
    assert np.array_equal(values(take, "observation.forces"), forces.astype(np.float32))
    assert values(take, "next.done")[:, 0].tolist() == [False] * 11 + [True]


@pytest.mark.parametrize("success", [True, False])
def test_success_is_said_in_the_last_frame(flown: Episode, success: bool) -> None:
    take = take_of(replace(flown, success=success), Plan(100, ()))
    assert values(take, "next.success")[:, 0].tolist() == [False] * 11 + [success]


def test_an_arm_is_part_of_state_and_action(with_arm: Rollout) -> None:
    (episode,) = episodes_of(with_arm)
    take = take_of(episode, plan_of([episode]))
    assert names(take, "observation.state")[22:] == (
        "shoulder_plane_rad", "shoulder_elevation_rad", "shoulder_rotation_rad",
        "elbow_flexion_rad", "forearm_rotation_rad",
    )  # fmt: skip
    of_joints = [name.removesuffix("_rad") for name in names(take, "observation.state")]
    assert names(take, "action") == tuple(f"{name}_target_rad" for name in of_joints)


def test_other_frames_are_interpolated(flown: Episode, flying: Rollout) -> None:
    take = take_of(flown, Plan(70, ()))
    assert take.resampled
    assert np.allclose(take.time, np.arange(8) / 70)
    height = np.interp(take.time, flying.time, flying.qpos[:, 9])
    state, where = values(take, "observation.state"), names(take, "observation.state")
    assert np.array_equal(state[:, where.index("forearm_z_m")], height.astype(np.float32))
    turn = state[:, [where.index(f"forearm_q{axis}") for axis in "wxyz"]]
    assert np.allclose(np.linalg.norm(turn, axis=1), 1, atol=1e-6)


def test_who_tells_no_commands_is_followed_a_frame_later(recordings: RecordingSet) -> None:
    (episode,) = episodes_of(recordings[0])
    take = take_of(episode, plan_of([episode]))
    q = recordings[0].q.astype(np.float32)
    assert np.array_equal(values(take, "observation.state"), q)
    assert np.array_equal(values(take, "action"), np.vstack([q[1:], q[-1:]]))
    assert [each.name for each in take.features] == ["observation.state", "action", "next.done"]


def test_the_rate_is_the_median_in_whole_frames(recordings: RecordingSet) -> None:
    slow = [replace(each, time=each.time * 50 / 20.3) for each in recordings[:2]]
    assert usual_fps(episodes_of(recordings)) == 50
    assert usual_fps(episodes_of([*slow, recordings[2]])) == 20


def test_channels_that_all_have_without_gaps_are_observed(recordings: RecordingSet) -> None:
    n = len(recordings[0].time)
    both = {"distance_m": np.linspace(0.3, 0, n), "emg_01": np.linspace(0, 1, n)}
    gap = both | {"emg_01": np.where(np.arange(n) == 3, np.nan, 0.0), "only": np.zeros(n)}
    episodes = episodes_of(
        [replace(recordings[0], channels=both), replace(recordings[1], channels=gap)]
    )
    plan = plan_of(episodes)
    assert plan.left_out == ("channel:emg_01", "channel:only")
    for take in (take_of(each, plan) for each in episodes):
        assert names(take, "observation.channels") == ("channel:distance_m",)
        found = values(take, "observation.channels")[:, 0]
        assert np.array_equal(found, both["distance_m"].astype(np.float32))


def test_hinges_of_the_object_are_observed_where_all_have_them(flown: Episode) -> None:
    position = flown.quantity("object_position")
    assert position is not None
    lid = replace(
        position, name="object_joints", columns=("object_lid",), units=("rad",),
        values=position.values[:, :1],
    )  # fmt: skip
    hinged = replace(flown, quantities=(*flown.quantities, lid))
    assert plan_of([hinged]).left_out == ()
    assert names(take_of(hinged, plan_of([hinged])), "observation.environment_state")[-1] == (
        "object_lid_rad"
    )
    plan = plan_of([hinged, flown])
    assert plan.left_out == ("object_lid",)
    assert len(names(take_of(hinged, plan), "observation.environment_state")) == 7


def test_what_does_not_belong_together_is_refused(
    flying: Rollout, with_arm: Rollout, recordings: RecordingSet
) -> None:
    with pytest.raises(InputError, match="differ in joints, actuators or base"):
        plan_of(episodes_of([flying, with_arm]))
    with pytest.raises(InputError, match="export rollouts and recordings apart"):
        plan_of(episodes_of([flying, recordings[0]]))


@pytest.mark.parametrize("fps", [0, -3, 1001])
def test_rates_that_are_none_are_refused(flown: Episode, fps: int) -> None:
    with pytest.raises(InputError, match=f"{fps} frames a second; give 1 to 1000"):
        plan_of([flown], fps)


def test_statistics_are_those_of_numpy() -> None:
    numbers = np.random.default_rng(2).normal(size=(200, 3)).astype(np.float32)
    found = statistics_of(numbers)
    exact = numbers.astype(float)
    assert found["count"] == [200]
    assert np.allclose(found["std"], exact.std(axis=0))
    assert np.allclose(found["mean"], exact.mean(axis=0))
    assert np.array_equal(found["max"], exact.max(axis=0))
    for name, q in (("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)):
        assert np.allclose(found[name], np.quantile(exact, q, axis=0))


def test_statistics_of_pixels_are_those_of_all_of_them() -> None:
    rng = np.random.default_rng(4)
    frames = rng.integers(20, 240, size=(5, 6, 8, 3)).astype(np.uint8)
    one, other = PixelCounts(), PixelCounts()
    assert np.array_equal(list(one.counting(frames[:2])), frames[:2])
    list(other.counting(frames[2:]))
    one.add(other)
    found, colours = one.statistics(), frames.reshape(-1, 3) / 255
    assert found["count"] == [5]
    for name, expected in (
        ("min", colours.min(axis=0)), ("max", colours.max(axis=0)),
        ("mean", colours.mean(axis=0)), ("std", colours.std(axis=0)),
        ("q10", np.quantile(colours, 0.1, axis=0, method="inverted_cdf")),
        ("q99", np.quantile(colours, 0.99, axis=0, method="inverted_cdf")),
    ):  # fmt: skip
        assert np.shape(found[name]) == (3, 1, 1)
        assert np.allclose(np.ravel(found[name]), expected), name

"""Where the tests of plausibility draw their lines."""

from dataclasses import replace

import numpy as np
import pytest

from handsim import data_folder
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.folder import read_recordings
from handsim.recordings.plausibility import Anomaly, anomalies
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.sides import MIRRORED_JOINTS, mirrored
from handsim.types import Array

PIP = JOINT_INDEX["index_pip"]


@pytest.fixture(scope="module")
def reach() -> Recording:
    return read_recordings(data_folder("assets") / "experiments")[0]


def found(*recordings: Recording) -> list[Anomaly]:
    return list(anomalies(RecordingSet(recordings)))


def kinds(*recordings: Recording) -> list[tuple[str, str, str | None]]:
    return [(each.kind, each.severity, each.joint) for each in found(*recordings)]


def with_joint(recording: Recording, joint: int, angle: Array) -> Recording:
    q = recording.q.copy()
    q[:, joint] = angle
    return replace(recording, q=q)


def at_times(recording: Recording, time: Array) -> Recording:
    q = np.column_stack([np.interp(time, recording.time, angle) for angle in recording.q.T])
    return replace(recording, time=time, q=q)


@pytest.mark.parametrize(("left", "said"), [(0.1, True), (0.6, False)])
def test_a_return_need_not_be_complete(reach: Recording, left: float, said: bool) -> None:
    back = np.linspace(0, 1 - left, 50)[:, None] * (reach.q[0] - reach.q[-1])
    q = np.vstack([reach.q, reach.q[-1] + back])
    returned = replace(reach, q=q, time=np.arange(len(q)) / 100)
    assert kinds(returned) == ([("rest-to-rest", "error", None)] if said else [])


def test_a_palm_arch_far_outside_is_a_warning(reach: Recording) -> None:
    arch = JOINT_INDEX["palm_arch"]
    odd = with_joint(reach, arch, reach.q[:, arch] + np.deg2rad(90))
    assert kinds(odd) == [("range", "warning", "palm_arch")]


def test_steps_of_a_coarse_sensor_are_no_jumps(reach: Recording) -> None:
    fine = at_times(reach, np.arange(1000) / 1000)
    step = np.deg2rad(10)  # in a millisecond: 10000 deg/s
    coarse = with_joint(fine, PIP, step * np.round(fine.q[:, PIP] / step))
    assert "jump" not in {each.kind for each in found(coarse)}


def test_a_sensor_that_turns_over_is_said_once(reach: Recording) -> None:
    angle = reach.q[:, PIP]
    middle = (angle.min() + angle.max()) / 2
    turned = with_joint(reach, PIP, np.mod(angle - middle, 2 * np.pi) - np.pi)
    assert [each.kind for each in found(turned) if each.joint == "index_pip"].count("wrap") == 1
    assert "jump" not in {each.kind for each in found(turned)}


def test_most_sensors_dead_is_an_error(reach: Recording) -> None:
    q = reach.q.copy()
    q[:, 8:] = q[0, 8:]
    (only,) = found(replace(reach, q=q))
    assert (only.kind, only.severity, only.joint) == ("constant", "error", None)
    assert (only.value, only.limit) == (N_JOINTS - 8, N_JOINTS / 2)


def test_a_sensor_dead_in_one_recording_is_told_from_one_dead_in_all(reach: Recording) -> None:
    dead = replace(with_joint(reach, PIP, np.full(len(reach.time), 0.5)), name="dead")
    (only,) = found(reach, dead)
    assert only.recording == "dead"
    assert "moves in this recording" in only.message


def test_a_joint_that_rests_with_the_hand_is_not_stuck(reach: Recording) -> None:
    q = np.vstack([reach.q, reach.q[-1:].repeat(300, axis=0)])
    assert kinds(replace(reach, q=q, time=np.arange(len(q)) / 100)) == []


def test_a_jump_of_another_joint_does_not_hide_that_one_is_stuck(reach: Recording) -> None:
    """Beside the jump's speed the rest of the movement is slow, and is movement nevertheless."""
    n = len(reach.time)
    angle, other = reach.q[:, PIP].copy(), reach.q[:, JOINT_INDEX["middle_pip"]].copy()
    angle[: 3 * n // 4] = angle[0]
    other[7 * n // 8 :] += np.deg2rad(80)
    odd = with_joint(with_joint(reach, PIP, angle), JOINT_INDEX["middle_pip"], other)
    told = {(each.kind, each.joint) for each in found(odd)}
    assert {("jump", "middle_pip"), ("stuck", "index_pip")} <= told


@pytest.mark.parametrize(
    ("side", "remedy"), [("right", "is it a left hand"), ("left", "turn their signs around")]
)
def test_the_remedy_for_mirrored_signs_goes_by_the_side(
    reach: Recording, side: str, remedy: str
) -> None:
    q = reach.q.copy()
    q[:, [JOINT_INDEX[name] for name in MIRRORED_JOINTS]] += np.deg2rad(6)
    hand = replace(reach.hand, side=side)  # type: ignore[arg-type]
    (only,) = [a for a in found(replace(reach, q=mirrored(q), hand=hand)) if a.kind == "side"]
    assert remedy in only.message

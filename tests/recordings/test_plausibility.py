"""Faults planted in good recordings are named with recording, joint, figure and remedy."""

import pickle
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim import GraspController, data_folder, learn_controller
from handsim.errors import InputError, UnknownNameError
from handsim.joints import JOINT_INDEX, JOINT_NAMES, JOINTS, N_JOINTS
from handsim.recordings.folder import read_recordings
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.plausibility import (
    KINDS,
    ImplausibleError,
    PlausibilityWarning,
    anomalies,
    check_plausible,
    lines_of,
)
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.sides import MIRRORED_JOINTS, mirrored
from handsim.types import Array

REAL = Path(__file__).parents[3] / "shared" / "data" / "reach_to_grasp"
FLEXIONS = np.array([joint.motion == "flexion" for joint in JOINTS])

Change = Callable[[Recording], Recording]


@pytest.fixture(scope="module")
def good() -> RecordingSet:
    return read_recordings(data_folder("assets") / "experiments")[:6]


def with_q(change: Callable[[Array], Array]) -> Change:
    return lambda recording: replace(recording, q=change(recording.q))


def with_time(change: Callable[[Array], Array]) -> Change:
    return lambda recording: replace(recording, time=change(recording.time))


def column(name: str, change: Callable[[Array], Array]) -> Change:
    def changed(q: Array) -> Array:
        q = q.copy()
        q[:, JOINT_INDEX[name]] = change(q[:, JOINT_INDEX[name]])
        return q

    return with_q(changed)


def returned(recording: Recording) -> Recording:
    q = np.vstack([recording.q, recording.q[::-1]])
    return replace(recording, q=q, time=np.arange(len(q)) / 100)


def dropped_out(recording: Recording) -> Recording:
    """Half a second in the middle is missing."""
    middle = recording.time[len(recording.time) // 2]
    kept = np.abs(recording.time - middle) > 0.25
    return replace(recording, time=recording.time[kept], q=recording.q[kept])


def wrapped(angle: Array) -> Array:
    """As a sensor gives it that turns over at 180 deg, in the middle of the movement."""
    centred = angle - (angle.min() + angle.max()) / 2
    return np.mod(centred, 2 * np.pi) - np.pi


def slowed_down(recording: Recording) -> Recording:
    time = np.arange(7000) / 100
    at = time / time[-1] * recording.duration
    q = np.column_stack([np.interp(at, recording.time, each) for each in recording.q.T])
    return replace(recording, time=time, q=q)


def spread_and_mirrored(q: Array) -> Array:
    return mirrored(q + np.isin(JOINT_NAMES, MIRRORED_JOINTS) * np.deg2rad(5))


FAULTS: dict[str, tuple[Change, str, str, tuple[str, ...]]] = {
    "radians": (with_q(np.deg2rad), "radians", "error", ("are these radians", "--units rad")),
    "milliseconds": (with_time(lambda t: 1000 * t), "milliseconds", "error", ("milliseconds", "s")),
    "microseconds": (with_time(lambda t: 1e6 * t), "milliseconds", "error", ("in seconds",)),
    "frame numbers": (
        with_time(lambda t: np.arange(len(t), dtype=float)),
        *("milliseconds", "error", ("frame numbers",)),
    ),
    "minutes": (with_time(lambda t: t / 60), "duration", "error", ("minutes",)),
    "slow": (slowed_down, "duration", "error", ("recordings cut",)),
    "counts": (
        with_q(lambda q: np.deg2rad(np.clip(np.round(100 + 0.8 * np.rad2deg(q)), 0, 179))),
        *("counts", "error", ("raw counts", "calibrate")),
    ),
    "flexion negative": (
        with_q(lambda q: np.where(FLEXIONS, -q, q)), "sign", "error", ("signs turned around",),
    ),
    "columns reversed": (with_q(lambda q: q[:, ::-1]), "range", "error", ("order of the columns",)),
    "rest to rest": (returned, "rest-to-rest", "error", ("recordings cut", "same posture")),
    "hardly moves": (
        with_q(lambda q: q[:1] + 0.01 * (q - q[:1])), "small", "error", ("does not reach",),
    ),
    "wrap": (column("index_pip", wrapped), "wrap", "error", ("whole turn", "--unwrap")),
    "mirrored": (with_q(spread_and_mirrored), "side", "warning", ("left hand", "--side left")),
    "constant": (
        column("ring_pip", lambda angle: 0 * angle), "constant", "warning", ("in no recording",),
    ),
    "stuck": (
        column("ring_pip", lambda a: a[0] + 0.3 * (np.arange(len(a)) > 0.85 * len(a))),
        *("stuck", "warning", ("loose sensor",)),
    ),
    "one sensor off": (
        column("middle_mcp", lambda a: a + np.deg2rad(110)), "range", "warning", ("calibration",),
    ),
    "spike": (
        column("middle_mcp", lambda a: a + np.deg2rad(90) * (np.arange(len(a)) == 30)),
        *("jump", "warning", ("within a frame",)),
    ),
    "gap": (dropped_out, "gap", "warning", ("0.5", "not known")),
    "rate": (
        lambda r: replace(r, extra={"rate_hz": "60"}), "rate", "warning", ("100", "60"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_named(good: RecordingSet, fault: str) -> None:
    change, kind, severity, words = FAULTS[fault]
    found = [a for a in anomalies(RecordingSet(tuple(map(change, good)))) if a.kind == kind]
    assert {a.recording for a in found} == {r.name for r in good}
    assert {a.severity for a in found} == {severity}
    for word in words:
        assert word in found[0].message
    assert "\n" not in str(found[0]) and good[0].name in str(found[0])
    assert np.isfinite([found[0].value, found[0].limit]).all()


@pytest.mark.parametrize("fault", FAULTS)
def test_learning_stops_at_errors_and_warns_aloud_of_the_rest(
    good: RecordingSet, fault: str
) -> None:
    change, kind, severity, _ = FAULTS[fault]
    bad = RecordingSet(tuple(map(change, good)))
    if severity == "error":
        with pytest.raises(ImplausibleError, match=f"--accept.* {kind}"):
            learn_controller(bad)
    else:
        with pytest.warns(PlausibilityWarning):
            learn_controller(bad, n_components=1)


def test_one_bad_recording_among_good_ones_is_named(good: RecordingSet) -> None:
    for fault in ("radians", "milliseconds", "counts", "flexion negative", "rest to rest"):
        change, kind, _, _ = FAULTS[fault]
        mixed = RecordingSet((*good[:3], replace(change(good[3]), name="odd"), *good[4:]))
        with pytest.raises(ImplausibleError, match="recording 'odd'") as caught:
            check_plausible(mixed)
        assert [(a.recording, a.kind) for a in caught.value.anomalies] == [("odd", kind)]


def test_good_recordings_have_nothing(good: RecordingSet) -> None:
    assert check_plausible(read_recordings(data_folder("assets") / "experiments")) == ()
    assert anomalies(good) == ()


@pytest.mark.real_data
@pytest.mark.skipif(
    not REAL.is_dir(), reason="the published recordings are not beside the checkout"
)
def test_people_show_no_error() -> None:
    files = sorted(REAL.glob("*.mat"))
    for subject in (1, 2, 3, 4):
        found = anomalies(import_recordings(files, "west-rtg", subject))
        assert Counter(a.severity for a in found)["error"] == 0
        assert {a.joint for a in found if a.kind == "range"} >= {"palm_arch"}


def test_what_is_accepted_is_learned_and_kept(good: RecordingSet, tmp_path: Path) -> None:
    small = RecordingSet(tuple(map(FAULTS["radians"][0], good)))
    learned = learn_controller(small, n_components=1, accept=["radians"]).controller
    assert learned.accepted == ("radians",)
    learned.save(tmp_path / "c.npz")
    assert GraspController.load(tmp_path / "c.npz").accepted == ("radians",)
    plain = learn_controller(good, n_components=1).controller
    assert plain.accepted == ()


def test_unknown_kinds_are_refused(good: RecordingSet) -> None:
    with pytest.raises(UnknownNameError, match="radians"):
        check_plausible(good, ["radian"])
    assert len(set(KINDS)) == len(KINDS)


def test_lines_group_what_is_alike(good: RecordingSet) -> None:
    bad = RecordingSet(tuple(map(FAULTS["one sensor off"][0], good)))
    (line,) = lines_of(anomalies(bad))
    assert line.startswith(f"warning: recording '{good[0].name}', middle_mcp")
    assert "in 5 further recordings" in line


def test_the_error_goes_to_other_processes(good: RecordingSet) -> None:
    bad = RecordingSet(tuple(map(FAULTS["radians"][0], good)))
    with pytest.raises(ImplausibleError) as caught:
        check_plausible(bad)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and isinstance(again, InputError)


def test_a_hand_that_converges_is_not_mirrored(good: RecordingSet) -> None:
    """Fingers close over an object with negative abductions; their start tells the side."""

    def converging(q: Array) -> Array:
        q = q.copy()
        for name in MIRRORED_JOINTS[1:4]:
            q[:, JOINT_INDEX[name]] = np.linspace(0.1, -0.3, len(q))
        return q

    found = anomalies(RecordingSet(tuple(map(with_q(converging), good))))
    assert not [a for a in found if a.kind == "side"]


def test_warnings_are_errors_here() -> None:
    """The tests would not notice a warning that learning gives without cause otherwise."""
    with pytest.raises(PlausibilityWarning), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.warn("planted", PlausibilityWarning, stacklevel=1)
    assert N_JOINTS == 22


def test_what_is_said_not_to_be_seen_is_no_news(good: RecordingSet) -> None:
    still = [column("ring_pip", lambda angle: 0 * angle)(r) for r in good]
    noted = [replace(r, notes=("wrist_flexion, ring_pip not seen: kept at 0",)) for r in still]
    assert [a.kind for a in anomalies(RecordingSet(tuple(still)))] == 6 * ["constant"]
    assert anomalies(RecordingSet(tuple(noted))) == ()

"""What a controller keeps of how recordings went: progress over time, signals over progress."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import handsim
from handsim.errors import FileError
from handsim.files import read_archive, write_archive
from handsim.learning.controller import SCHEMA, GraspController
from handsim.learning.demonstration import SIGNAL_PROGRESS, demonstrations_of
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.paths import arc_length
from handsim.recordings.recording import Recording, RecordingSet


def with_channels(recording: Recording, **channels: np.ndarray) -> Recording:
    return dataclasses.replace(recording, channels=channels)


@pytest.fixture(scope="module")
def subspace(recordings: RecordingSet) -> PostureSubspace:
    return PostureSubspace(3).fit(np.vstack([r.q for r in recordings]))


@pytest.fixture(scope="module")
def controller(recordings: RecordingSet) -> GraspController:
    """Learned from recordings of which all but the last hold a channel."""
    own = [with_channels(r, reach=100.0 - r.time) for r in recordings][:-1]
    return handsim.learn_controller(RecordingSet((*own, recordings[-1]))).controller


def test_progress_is_length_covered_at_even_times(recordings, subspace) -> None:
    (kept,) = demonstrations_of(recordings[:1], subspace)
    length = arc_length(subspace.transform(recordings[0].q))
    assert kept.progress.shape == (51,)
    assert (kept.progress[0], kept.progress[-1]) == (0.0, 1.0)
    middle = np.interp(recordings[0].duration / 2, recordings[0].time, length) / length[-1]
    assert kept.progress[25] == pytest.approx(middle, abs=1e-9)


def test_signals_are_kept_by_progress(recordings, subspace) -> None:
    one = recordings[0]
    length = arc_length(subspace.transform(one.q))
    broken = np.array(one.time)
    broken[3] = np.nan
    many = with_channels(
        one, covered=100.0 * length / length[-1], time=one.time, broken=broken,
        stamp=1e12 + one.time, emg_01=np.ones(len(one.time)),
    )  # fmt: skip
    (kept,) = demonstrations_of(RecordingSet((many,)), subspace)
    assert set(kept.signals) == {"covered", "time", "emg_01", "emg_envelope"}
    np.testing.assert_allclose(kept.signals["covered"], 100.0 * SIGNAL_PROGRESS, atol=1e-4)
    assert kept.signals["time"][-1] == pytest.approx(one.duration)


def test_of_a_standstill_the_first_frame_counts(recordings, subspace) -> None:
    one = recordings[0]
    still = np.repeat(one.q, [1] * 40 + [21] + [1] * (len(one.q) - 41), axis=0)
    time = np.arange(len(still)) / 50
    (kept,) = demonstrations_of(
        RecordingSet((dataclasses.replace(one, q=still, time=time, channels={"t": time}),)),
        subspace,
    )
    assert np.diff(kept.signals["t"]).max() > 0.35  # passes over the 0.4 s
    assert (np.diff(kept.signals["t"]) > 0).all()


def test_they_are_stored_and_read(controller, tmp_path: Path) -> None:
    controller.save(tmp_path / "c.npz")
    again = GraspController.load(tmp_path / "c.npz")
    assert len(again.demonstrations) == len(controller.demonstrations)
    for a, b in zip(controller.demonstrations, again.demonstrations, strict=True):
        assert list(a.signals) == list(b.signals)
        for name in a.signals:
            np.testing.assert_array_equal(a.signals[name], b.signals[name])
        np.testing.assert_array_equal(a.progress, b.progress)
    assert list(again.demonstrations[0].signals) == ["reach"]
    assert again.demonstrations[-1].signals == {}


def test_the_digest_does_not_count_them(controller) -> None:
    without = tuple(dataclasses.replace(d, signals={}) for d in controller.demonstrations)
    assert dataclasses.replace(controller, demonstrations=without).digest == controller.digest
    moved = tuple(dataclasses.replace(d, z_goal=d.z_goal + 0.01) for d in controller.demonstrations)
    assert dataclasses.replace(controller, demonstrations=moved).digest != controller.digest


def damaged(path: Path, change) -> None:
    metadata, arrays = read_archive(path, "controller", SCHEMA)
    change(metadata, arrays)
    write_archive(path, "controller", SCHEMA, metadata, arrays)


@pytest.mark.parametrize(
    "change",
    [
        lambda metadata, arrays: arrays.update(signals=arrays["signals"][1:]),
        lambda metadata, arrays: arrays.update(signals=arrays["signals"][:, :50]),
        lambda metadata, arrays: arrays["signals"].__setitem__((0, 0), np.nan),
        lambda metadata, arrays: metadata["signals"].__setitem__(0, [99, "reach"]),
        lambda metadata, arrays: metadata["signals"].__setitem__(0, [True, "reach"]),
        lambda metadata, arrays: metadata["signals"].__setitem__(0, [0, 7]),
        lambda metadata, arrays: metadata["signals"].__setitem__(0, 7),
        lambda metadata, arrays: arrays.pop("signals"),
        lambda metadata, arrays: arrays.update(progress=arrays["progress"][:, :50]),
        lambda metadata, arrays: arrays.update(progress=1 - arrays["progress"]),
        lambda metadata, arrays: arrays.update(progress=2 * arrays["progress"]),
    ],
)
def test_damaged_ones_are_refused(controller, tmp_path: Path, change) -> None:
    controller.save(tmp_path / "c.npz")
    damaged(tmp_path / "c.npz", lambda *_: None)
    GraspController.load(tmp_path / "c.npz")
    damaged(tmp_path / "c.npz", change)
    with pytest.raises(FileError, match="not a whole controller") as raised:
        GraspController.load(tmp_path / "c.npz")
    assert "\n" not in str(raised.value)

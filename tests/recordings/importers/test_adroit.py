"""Demonstrations of a simulated hand: columns and signs, the start from zero, published ones."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.importers.adroit import postures_of_adroit
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.recording import RecordingSet

REAL = Path(__file__).parents[3] / "../shared/data/door_teleop/door.npz"
real_data = pytest.mark.skipif(not REAL.is_file(), reason="no published recordings in ../shared")


def demonstration(n: int = 60) -> np.ndarray:
    rows = np.tile(np.arange(39) / 100, (n, 1))
    rows[:, 25:27] *= -1  # the thumb's flexions are negative
    rows[0, 3:27] = 0
    return rows


def imported(file: Path, **said: object) -> RecordingSet:
    return import_recordings([file], "adroit", options=ImportOptions(**said))  # type: ignore[arg-type]


def test_columns_signs_and_channels(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", observations_00=demonstration(), other=np.zeros(3))
    recording = imported(tmp_path / "a.npz")[0]
    q = {name: recording.q[0, j] for name, j in JOINT_INDEX.items()}
    expected = {
        "wrist_deviation": 0.03, "wrist_flexion": 0.04, "index_abduction": 0.05, "index_mcp": 0.06,
        "index_pip": 0.07, "index_dip": 0.08, "middle_mcp": 0.10, "middle_pip": 0.11,
        "middle_dip": 0.12, "ring_abduction": -0.13, "ring_mcp": 0.14, "ring_pip": 0.15,
        "ring_dip": 0.16, "palm_arch": 0.17, "little_abduction": -0.18, "little_mcp": 0.19,
        "little_pip": 0.20, "little_dip": 0.21, "thumb_mcp": 0.25, "thumb_ip": 0.26,
        "thumb_rotation": np.deg2rad(16) + 0.7 * 0.22 + 0.85 * 0.23 + 0.7 * 0.24,
        "thumb_abduction": -0.6 * 0.22 + 0.6 * 0.23 + 0.5 * 0.24,
    }  # fmt: skip
    assert q == pytest.approx(expected)
    channels = {name: values[0] for name, values in recording.channels.items()}
    assert channels == pytest.approx({
        "arm_x_rad": 0.0, "arm_y_rad": 0.01, "arm_z_rad": 0.02, "middle_abduction_rad": 0.09,
        "latch_rad": 0.27, "palm_x_m": 0.29, "palm_y_m": 0.30, "palm_z_m": 0.31,
        "handle_x_m": 0.32, "handle_y_m": 0.33, "handle_z_m": 0.34,
    })  # fmt: skip


def test_the_start_from_zero_is_dropped_and_only_that(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", d=demonstration())
    recording = imported(tmp_path / "a.npz")[0]
    assert len(recording.time) == 60 - 25 and recording.time[1] == pytest.approx(0.01)
    assert "first 0.25 s dropped" in recording.notes[0]
    np.savez(tmp_path / "a.npz", d=demonstration()[1:])
    whole = imported(tmp_path / "a.npz", rate_hz=50.0)[0]
    assert len(whole.time) == 59 and whole.time[1] == pytest.approx(0.02)
    assert "dropped" not in whole.notes[0]


def test_other_keys_files_and_stacks(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "a.npz", **{"run 1/obs": demonstration(), "b": np.stack([demonstration()] * 2)}
    )
    assert [r.name for r in imported(tmp_path / "a.npz")] == ["run-1-obs", "b-00", "b-01"]
    np.save(tmp_path / "c.npy", demonstration()[:, :28])
    recording = imported(tmp_path / "c.npy")[0]
    assert recording.name == "c" and "latch_rad" in recording.channels
    assert "palm_x_m" not in recording.channels
    both = import_recordings([tmp_path / "a.npz"] * 2, "adroit")
    assert len(both) == 6 and both[3].name == "a-run-1-obs"


def test_a_folder_of_them_is_read_back_with_its_notes(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **{f"d{i}": demonstration() for i in range(6)})
    made = imported(tmp_path / "a.npz")
    write_recordings(made, tmp_path / "folder")
    assert read_recordings(tmp_path / "folder")[3].notes == made[3].notes


def test_what_is_no_demonstration(tmp_path: Path) -> None:
    rows = demonstration()
    missing, degrees, other, short = rows.copy(), rows * 180, rows.copy(), rows[:30]
    missing[40, 8] = np.nan
    other[:, 10] = -0.9
    for content, said in (
        (missing, "frame 16 after the start has no FFJ0; bridge"),
        (degrees, "beyond 2.5 rad"),
        (other, "MFJ2 is -52 deg for most"),
        (short, "d has 5 frames"),
        (rows[:, :38], r"no array of shape \(frames, 39\) among d \(60, 38\)"),
    ):
        np.savez(tmp_path / "a.npz", d=content)
        with pytest.raises(FileError, match=rf"a\.npz: .*{said}"):
            imported(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", d=missing)
    assert "bridged 1 frame" in imported(tmp_path / "a.npz", bridge_s=0.05)[0].notes


def test_zero_is_the_hand_at_rest() -> None:
    q = postures_of_adroit(np.zeros((1, 24)))
    assert np.flatnonzero(q[0]).tolist() == [JOINT_INDEX["thumb_rotation"]]


@real_data
@pytest.mark.real_data
def test_published_demonstrations() -> None:
    recordings = imported(REAL)
    assert len(recordings) == 25 and recordings[0].name == "observations_00"
    q = np.vstack([recording.q for recording in recordings])
    middle = np.median(q, axis=0)
    assert (middle > LOWER).all() and (middle < UPPER).all()
    outside = ((q < LOWER - 1e-6) | (q > UPPER + 1e-6)).mean(axis=0)
    assert outside.max() < 0.25 and np.delete(outside, JOINT_INDEX["palm_arch"]).max() < 0.10
    start = np.median([recording.q[0] for recording in recordings], axis=0)
    for joint in ("index_abduction", "ring_abduction", "little_abduction"):
        assert start[JOINT_INDEX[joint]] > 0  # hands at rest are spread
    assert q[:, JOINT_INDEX["thumb_ip"]].min() > -0.02  # and thumbs flex

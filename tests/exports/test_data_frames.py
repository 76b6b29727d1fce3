"""Data frames hold what was moved, in the columns of the package's own CSV files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from handsim.errors import InputError, MissingToolError
from handsim.exports.data_frames import to_frame, write_frame
from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS, JOINT_NAMES
from handsim.learning.controller import PostureSequence
from handsim.recordings.posture_file import read_postures
from handsim.recordings.recording import RecordingSet

IN_DEGREES = [f"{name}_deg" for name in JOINT_NAMES]


OLD = int(pd.__version__.partition(".")[0]) < 3
"""Whether pandas reads the last digit of a number only where it is asked to."""


def read(path: Path) -> pd.DataFrame:
    if path.suffix == ".csv":
        exactly = {"float_precision": "round_trip"} if OLD else {}
        return pd.read_csv(path, keep_default_na=False, **exactly)
    return pd.read_parquet(path)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_a_rollout_is_read_back_to_the_bit(with_arm: Rollout, tmp_path: Path, suffix: str) -> None:
    frame = to_frame(with_arm)
    path = tmp_path / f"rollout{suffix}"
    write_frame(frame, path)
    found = read(path)
    pd.testing.assert_frame_equal(found, frame, check_exact=True)
    assert np.array_equal(found["time_s"], with_arm.time)
    model = with_arm.model()
    for name in (*JOINT_NAMES, "elbow_flexion"):
        joint = model.joint(name)
        angle, speed = with_arm.qpos[:, joint.qposadr[0]], with_arm.qvel[:, joint.dofadr[0]]
        assert np.array_equal(found[f"{name}_deg"], np.rad2deg(angle))
        assert np.array_equal(found[f"{name}_velocity_deg_s"], np.rad2deg(speed))
        target = with_arm.ctrl[:, model.actuator(name).id]
        assert np.array_equal(found[f"{name}_target_deg"], np.rad2deg(target))
    for i, part in enumerate(CONTACT_PARTS):
        assert np.array_equal(found[f"{part}_force_n"], with_arm.contact_force[:, i])
        for j, axis in enumerate("xyz"):
            assert np.array_equal(found[f"{part}_press_{axis}_n"], with_arm.press[:, i, j])
    pose = [f"object_{each}" for each in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
    assert np.array_equal(found[pose], with_arm.qpos[:, :7])
    glove = [f"{name}_glove_deg" for name in JOINT_NAMES]
    assert np.array_equal(found[glove], np.rad2deg(with_arm.reading))
    assert found["phase"].tolist() == [with_arm.phase_at(time) for time in with_arm.time]


def test_a_hand_without_an_arm_has_a_forearm_that_moves(flying: Rollout) -> None:
    frame = to_frame(flying)
    pose = [f"forearm_{each}" for each in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
    assert np.array_equal(frame[pose], flying.qpos[:, 7:14])
    target = [f"forearm_target_{each}" for each in ("x_m", "y_m", "z_m")]
    assert np.array_equal(frame[target], flying.mocap_pos)
    assert "elbow_flexion_deg" not in frame


def test_recordings_stand_below_each_other(recordings: RecordingSet, tmp_path: Path) -> None:
    frame = to_frame(recordings)
    assert list(frame.columns) == ["episode", "name", "task", "time_s", *IN_DEGREES]
    path = tmp_path / "all.parquet"
    write_frame(frame, path)
    found = pd.read_parquet(path)
    for number, recording in enumerate(recordings):
        rows = found[found["episode"] == number]
        assert set(rows["name"]) == {recording.name}
        assert set(rows["task"]) == {recording.task}
        assert np.array_equal(rows["time_s"], recording.time)
        assert np.array_equal(rows[IN_DEGREES], np.rad2deg(recording.q))
    facts = found.attrs["episodes"]
    assert [each["subject"] for each in facts] == ["made-up"] * len(recordings)
    assert facts[3]["hand_length_m"] == recordings[3].hand.length


def test_what_is_known_of_a_rollout_comes_along(with_arm: Rollout, tmp_path: Path) -> None:
    frame = to_frame({"mine": with_arm})
    write_frame(frame, tmp_path / "r.parquet")
    (facts,) = pd.read_parquet(tmp_path / "r.parquet").attrs["episodes"]
    assert (facts["name"], facts["kind"], facts["task"]) == ("mine", "rollout", "cube-raise")
    assert facts["sentence"] == "Grasp the cube and raise it."
    assert facts["success"] is with_arm.outcome.success
    assert facts["outcome"]["lift_m"] == with_arm.outcome.lift_m
    assert facts["conditions"]["friction"] == with_arm.conditions.friction
    assert facts == frame.attrs["episodes"][0]


def test_what_one_lacks_is_missing_there(with_arm: Rollout, flying: Rollout) -> None:
    frame = to_frame([flying, with_arm])
    assert frame.loc[frame["episode"] == 0, "elbow_flexion_deg"].isna().all()
    assert frame.loc[frame["episode"] == 1, "elbow_flexion_deg"].notna().all()
    assert set(frame["name"]) == {"cube-raise", "cube-raise-2"}


def test_a_csv_of_postures_is_one_that_handsim_reads(
    recordings: RecordingSet, tmp_path: Path
) -> None:
    sequence = PostureSequence(recordings[0].time, recordings[0].q, arrived=True, reason="")
    path = tmp_path / "postures.csv"
    write_frame(to_frame(sequence), path)
    time, q = read_postures(path)
    assert np.array_equal(time, recordings[0].time)
    assert np.allclose(q, recordings[0].q, rtol=0, atol=1e-15)


def test_channels_keep_their_names_and_gaps(recordings: RecordingSet) -> None:
    distance = np.linspace(0.3, 0.0, len(recordings[0].time))
    distance[7] = np.nan
    frame = to_frame(replace(recordings[0], channels={"distance_m": distance}))
    assert np.array_equal(frame["channel:distance_m"], distance, equal_nan=True)


def test_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="nothing to export"):
        to_frame([])


def test_what_is_no_movement_is_refused() -> None:
    with pytest.raises(InputError, match="a float cannot be exported"):
        to_frame([1.0])  # type: ignore[list-item]


@pytest.mark.parametrize("name", ["pandas", "pyarrow"])
def test_without_the_library_its_extra_is_named(
    with_arm: Rollout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    frame = to_frame(with_arm)
    monkeypatch.setitem(__import__("sys").modules, name, None)
    with pytest.raises(MissingToolError, match=rf"{name}; run: pip install 'handsim\[export\]'"):
        to_frame(with_arm) if name == "pandas" else write_frame(frame, tmp_path / "f.parquet")
    assert not list(tmp_path.iterdir())

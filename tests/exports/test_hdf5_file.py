"""An HDF5 file holds every array to the bit, and says units and frames."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from handsim.errors import FileError, MissingToolError
from handsim.exports.hdf5_file import write_hdf5
from handsim.grasping.rollout.record import Rollout
from handsim.joints import JOINT_NAMES
from handsim.recordings.recording import RecordingSet


def test_a_rollout_is_read_back_to_the_bit(with_arm: Rollout, tmp_path: Path) -> None:
    write_hdf5(with_arm, tmp_path / "r.h5")
    model = with_arm.model()
    with h5py.File(tmp_path / "r.h5") as file:
        group = file["cube-raise"]
        for name in ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat"):
            assert np.array_equal(group["mujoco"][name], getattr(with_arm, name))
        assert group["mujoco/model_xml"].asstr()[()] == with_arm.model_xml
        for name in ("time", "contact_force", "z"):
            assert np.array_equal(group[name], getattr(with_arm, name)), name
        for name in ("penetration", "table_force"):
            assert np.array_equal(group[name][:, 0], getattr(with_arm, name)), name
        assert np.array_equal(group["press"], with_arm.press.reshape(12, 18))
        assert np.array_equal(group["glove"], with_arm.reading)
        joints = group["joints"]
        assert joints.dtype == np.float64
        assert list(joints.attrs["columns"][:22]) == list(JOINT_NAMES)
        for column, values in zip(joints.attrs["columns"], joints[:].T, strict=True):
            assert np.array_equal(values, with_arm.qpos[:, model.joint(column).qposadr[0]])
        targets = group["targets"]
        for column, values in zip(targets.attrs["columns"], targets[:].T, strict=True):
            name = column.removesuffix("_target")
            assert np.array_equal(values, with_arm.ctrl[:, model.actuator(name).id])


def test_units_frames_and_time_are_said(with_arm: Rollout, tmp_path: Path) -> None:
    write_hdf5(with_arm, tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        group = file["cube-raise"]
        assert group["time"].attrs["unit"] == "s"
        said = {name: group[name].attrs["unit"] for name in group if name not in ("time", "mujoco")}
        assert said == {
            "joints": "rad", "velocities": "rad/s", "targets": "rad", "glove": "rad", "z": "rad",
            "object_position": "m", "object_orientation": "", "palm_target_position": "m",
            "palm_target_orientation": "", "contact_force": "N", "press": "N",
            "penetration": "m", "table_force": "N",
        }  # fmt: skip
        assert group["object_position"].attrs["frame"] == "world"
        assert "quaternion (w, x, y, z)" in group["object_orientation"].attrs["description"]
        assert group["joints"].dims[0][0] == group["time"]
        assert list(group.attrs["phase_names"]) == [phase.name for phase in with_arm.phases]
        assert list(group.attrs["phase_starts_s"]) == [phase.start for phase in with_arm.phases]
        assert group.attrs["success"] == with_arm.outcome.success
        assert json.loads(group.attrs["outcome"])["lift_m"] == with_arm.outcome.lift_m
        assert json.loads(group.attrs["versions"]) == with_arm.versions


def test_each_recording_is_a_group_of_its_name(recordings: RecordingSet, tmp_path: Path) -> None:
    distance = np.linspace(0.3, 0.0, len(recordings[0].time))
    first = replace(recordings[0], channels={"distance_m": distance})
    write_hdf5([first, *recordings[1:]], tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        assert set(file) == {recording.name for recording in recordings}
        for recording in recordings:
            group = file[recording.name]
            assert np.array_equal(group["time"], recording.time)
            assert np.array_equal(group["joints"], recording.q)
            assert group.attrs["subject"] == "made-up"
            assert group.attrs["hand_length_m"] == recording.hand.length
        assert np.array_equal(file[first.name]["channel:distance_m"][:, 0], distance)


def test_the_same_movements_give_the_same_bytes(with_arm: Rollout, tmp_path: Path) -> None:
    for name in ("a.h5", "b.h5"):
        write_hdf5(with_arm, tmp_path / name)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_what_fails_half_way_leaves_the_old_file(with_arm: Rollout, tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    path.write_text("old")
    broken = replace(with_arm, ctrl=with_arm.ctrl[:, :3])
    with pytest.raises(IndexError):
        write_hdf5([with_arm, broken], path)
    assert [each.name for each in tmp_path.iterdir()] == ["r.h5"]
    assert path.read_text() == "old"


def test_a_folder_that_is_not_there_is_refused(with_arm: Rollout, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="create it first"):
        write_hdf5(with_arm, tmp_path / "missing" / "r.h5")


def test_without_the_library_its_extra_is_named(
    with_arm: Rollout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingToolError, match=r"h5py; run: pip install 'handsim\[export\]'"):
        write_hdf5(with_arm, tmp_path / "r.h5")
    assert not list(tmp_path.iterdir())

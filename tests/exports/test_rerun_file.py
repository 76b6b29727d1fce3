"""A rerun recording holds curves to the bit, and bodies where the simulation had them."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handsim.errors import MissingToolError
from handsim.exports.export_sources import episodes_of
from handsim.exports.rerun_file import write_rerun
from handsim.grasping.rollout.record import Rollout
from handsim.recordings.recording import RecordingSet


def test_without_the_library_its_extra_is_named(
    with_arm: Rollout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(MissingToolError, match=r"rerun-sdk; run: pip install 'handsim\[rerun\]'"):
        write_rerun(with_arm, tmp_path / "r.rrd")
    assert not list(tmp_path.iterdir())


def read(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """Entity to component to values a row, as rerun's own reader finds them; of static ones too."""
    chunk = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk 0.41, which is in no extra")
    found: dict[str, dict[str, Any]] = {}
    for part in chunk.RrdReader(path).stream():
        batch = part.to_record_batch()
        columns = found.setdefault(part.entity_path, {})
        for name in batch.schema.names:
            columns[name] = batch.column(name).to_pylist()
    return found


def test_curves_are_read_back_to_the_bit(with_arm: Rollout, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    write_rerun({"mine": with_arm}, tmp_path / "r.rrd")
    found = read(tmp_path / "r.rrd")
    (episode,) = episodes_of(with_arm)
    for quantity in episode.quantities:
        curves = found[f"/mine/{quantity.name}"]
        assert np.array_equal(curves["Scalars:scalars"], quantity.values), quantity.name
        seconds = [each.total_seconds() for each in curves["time"]]
        assert np.allclose(seconds, with_arm.time - with_arm.time[0], rtol=0, atol=1e-6)
    (names,) = found["/mine/joints"]["SeriesLines:names"]
    assert names[:2] == ["thumb_rotation [rad]", "thumb_mcp [rad]"]
    assert "Grasp the cube and raise it." in found["/mine/facts"]["TextDocument:text"][0][0]


def test_bodies_are_where_they_were(with_arm: Rollout, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    write_rerun({"mine": with_arm}, tmp_path / "r.rrd")
    found = read(tmp_path / "r.rrd")
    body = found["/mine/scene/object"]
    position = np.array(body["Transform3D:translation"])[:, 0]
    turn = np.array(body["Transform3D:quaternion"])[:, 0]
    assert np.allclose(position, with_arm.qpos[:, :3], atol=1e-6)
    assert np.allclose(turn, with_arm.qpos[:, [4, 5, 6, 3]], atol=1e-6)
    meshes = [entity for entity, has in found.items() if "Mesh3D:vertex_positions" in has]
    assert any(entity.startswith("/mine/scene/index_distal/") for entity in meshes)


def test_recordings_are_below_their_names(recordings: RecordingSet, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    done: list[float] = []
    distance = np.linspace(0.3, 0.0, len(recordings[0].time))
    first = replace(recordings[0], channels={"distance_m": distance})
    write_rerun([first, recordings[1]], tmp_path / "r.rrd", done.append)
    found = read(tmp_path / "r.rrd")
    (channel,) = (has for entity, has in found.items() if "distance_m" in entity)
    assert np.array_equal(np.ravel(channel["Scalars:scalars"]), distance)
    for recording in recordings[:2]:
        curves = found[f"/{recording.name}/joints"]
        assert np.array_equal(curves["Scalars:scalars"], recording.q)
    assert done == [0.5, 1.0]

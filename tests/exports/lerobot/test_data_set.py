"""The files of a data set are where codebase version v3.0 has them, and hold what was moved."""

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from handsim.errors import FileError, InputError, MissingToolError, UnknownNameError
from handsim.exports.episode_clip import bare_clip
from handsim.exports.export_sources import episodes_of
from handsim.exports.lerobot import data_set
from handsim.exports.lerobot.data_set import write_lerobot
from handsim.exports.lerobot.data_set_layout import file_of
from handsim.exports.lerobot.features import plan_of, take_of
from handsim.exports.lerobot.film_files import files_of, places_of
from handsim.exports.lerobot.frame_files import columns_of, write_frames
from handsim.grasping.rollout.record import Rollout
from handsim.recordings.recording import RecordingSet
from handsim.viewing.film.clips import frame_times, render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.posture_clips import posture_clip, posture_model

COUNTED = ["timestamp", "frame_index", "episode_index", "index", "task_index"]
FILE = "chunk-000/file-000"


def read_json(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def recorded(recordings: RecordingSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot") / "recorded"
    write_lerobot(recordings, folder)
    return folder


@pytest.fixture(scope="module")
def filmed(with_arm: Rollout, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two grasps, of which one failed, filmed with two frames a second."""
    dropped = replace(with_arm, outcome=replace(with_arm.outcome, success=False))
    folder = tmp_path_factory.mktemp("lerobot") / "filmed"
    named = {"held": with_arm, "dropped": dropped}
    write_lerobot(named, folder, fps=2, camera="front", size=(96, 64))
    return folder


def test_the_files_are_those_of_the_layout(recorded: Path, filmed: Path) -> None:
    usual = {
        f"data/{FILE}.parquet", f"meta/episodes/{FILE}.parquet", "meta/info.json",
        "meta/stats.json", "meta/tasks.parquet", "meta/handsim.json",
    }  # fmt: skip
    for folder, more in (
        (recorded, set()),
        (filmed, {f"videos/observation.images.front/{FILE}.mp4"}),
    ):
        found = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
        assert found == usual | more


def test_info_says_what_files_hold(recorded: Path, recordings: RecordingSet) -> None:
    info = read_json(recorded / "meta/info.json")
    n = sum(len(each.time) for each in recordings)
    counts = {
        "codebase_version": "v3.0", "robot_type": "handsim", "fps": 50, "chunks_size": 1000,
        "total_episodes": 9, "total_frames": n, "total_tasks": 3, "splits": {"train": "0:9"},
        "data_files_size_in_mb": 100, "video_files_size_in_mb": 200, "video_path": None,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    }  # fmt: skip
    assert {name: info[name] for name in counts} == counts
    state = info["features"]["observation.state"]
    assert (state["dtype"], state["shape"]) == ("float32", [22])
    assert state["names"][:2] == ["thumb_rotation_rad", "thumb_mcp_rad"]
    assert list(info["features"])[-5:] == COUNTED
    schema = pq.read_schema(recorded / f"data/{FILE}.parquet")
    assert schema.names == list(info["features"])
    for name, feature in info["features"].items():
        kind = schema.field(name).type
        shape = [kind.list_size] if hasattr(kind, "list_size") else [1]
        assert shape == feature["shape"], name
        dtype = str(kind.value_type if hasattr(kind, "list_size") else kind)
        assert dtype == {"float32": "float"}.get(feature["dtype"], feature["dtype"])


def test_frames_are_the_recordings_as_float32(recorded: Path, recordings: RecordingSet) -> None:
    frames = pd.read_parquet(recorded / f"data/{FILE}.parquet")
    assert frames["index"].tolist() == list(range(len(frames)))
    for number, recording in enumerate(recordings):
        rows = frames[frames["episode_index"] == number]
        q = recording.q.astype(np.float32)
        assert np.array_equal(np.stack(rows["observation.state"]), q)
        assert np.array_equal(np.stack(rows["action"]), np.vstack([q[1:], q[-1:]]))
        assert rows["frame_index"].tolist() == list(range(len(q)))
        assert rows["timestamp"].dtype == np.float32
        assert np.array_equal(rows["timestamp"], (np.arange(len(q)) / 50).astype(np.float32))


def test_tasks_are_sentences_with_numbers(recorded: Path, recordings: RecordingSet) -> None:
    tasks = pd.read_parquet(recorded / "meta/tasks.parquet")
    assert tasks.columns.tolist() == ["task_index"]
    assert tasks.index.tolist() == [f"Object {i} grasp." for i in range(3)]
    assert tasks["task_index"].tolist() == [0, 1, 2]
    frames = pd.read_parquet(recorded / f"data/{FILE}.parquet")
    episodes = pd.read_parquet(recorded / f"meta/episodes/{FILE}.parquet")
    for number, recording in enumerate(recordings):
        (sentence,) = episodes["tasks"][number]
        assert sentence == f"{recording.task.replace('-', ' ').capitalize()}."
        indices = frames.loc[frames["episode_index"] == number, "task_index"]
        assert set(indices) == {tasks.loc[sentence, "task_index"]}


def test_episodes_say_where_they_are(recorded: Path, recordings: RecordingSet) -> None:
    episodes = pd.read_parquet(recorded / f"meta/episodes/{FILE}.parquet")
    lengths = [len(each.time) for each in recordings]
    assert episodes["length"].tolist() == lengths
    assert episodes["dataset_to_index"].tolist() == np.cumsum(lengths).tolist()
    assert episodes["dataset_from_index"].tolist() == [0, *np.cumsum(lengths)[:-1]]
    assert episodes["name"].tolist() == [each.name for each in recordings]
    for name in ("data/chunk_index", "data/file_index", "meta/episodes/chunk_index",
                 "meta/episodes/file_index"):  # fmt: skip
        assert set(episodes[name]) == {0}


def test_statistics_are_those_of_the_frames(recorded: Path) -> None:
    frames = pd.read_parquet(recorded / f"data/{FILE}.parquet")
    stats = read_json(recorded / "meta/stats.json")
    assert set(stats) == set(frames.columns)
    state = np.stack(frames["observation.state"]).astype(float)
    found = stats["observation.state"]
    assert set(found) == {"min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99"}
    assert found["count"] == [len(frames)]
    assert np.allclose(found["mean"], state.mean(axis=0))
    assert np.allclose(found["q90"], np.quantile(state, 0.9, axis=0))
    assert stats["frame_index"]["max"] == [frames["frame_index"].max()]
    episodes = pd.read_parquet(recorded / f"meta/episodes/{FILE}.parquet")
    second = state[(frames["episode_index"] == 1).to_numpy()]
    assert np.allclose(episodes["stats/observation.state/std"][1], second.std(axis=0))


def test_success_stands_in_frames_and_episodes(filmed: Path) -> None:
    frames = pd.read_parquet(filmed / f"data/{FILE}.parquet")
    ends = frames[frames["next.done"]]
    assert ends["episode_index"].tolist() == [0, 1]
    assert ends["next.success"].tolist() == [True, False]
    episodes = pd.read_parquet(filmed / f"meta/episodes/{FILE}.parquet")
    assert episodes["success"].tolist() == [True, False]


def test_what_lerobot_does_not_ask_for_is_kept(filmed: Path, with_arm: Rollout) -> None:
    facts = read_json(filmed / "meta/handsim.json")
    held, dropped = facts["episodes"]
    assert (held["name"], dropped["name"]) == ("held", "dropped")
    assert held["outcome"]["lift_m"] == with_arm.outcome.lift_m
    assert held["resampled"] is True
    assert held["phases"][1] == {"name": "squeeze", "start_s": 1.2}


def test_films_show_each_frame_of_each_episode(
    filmed: Path, with_arm: Rollout, read_video: Callable[[Path], Any]
) -> None:
    metadata, frames = read_video(filmed / f"videos/observation.images.front/{FILE}.mp4")
    episodes = pd.read_parquet(filmed / f"meta/episodes/{FILE}.parquet")
    info = read_json(filmed / "meta/info.json")["features"]["observation.images.front"]
    assert (info["dtype"], info["shape"]) == ("video", [64, 96, 3])
    assert (metadata["fps"], metadata["codec"]) == (2.0, "h264")
    assert len(frames) == episodes["length"].sum()
    key = "videos/observation.images.front"
    assert episodes[f"{key}/from_timestamp"].tolist() == [0.0, len(frames) / 4]
    assert episodes[f"{key}/to_timestamp"].tolist() == [len(frames) / 4, len(frames) / 2]
    (take,) = [take_of(each, plan_of([each], 2)) for each in episodes_of(with_arm)]
    drawn = list(render_clips([bare_clip(take.episode)], View("front", 96, 64, 2)))
    assert len(drawn) == len(take.time) == episodes["length"][0]
    for i, shown in enumerate(frames):
        off = [np.abs(shown.astype(int) - picture).mean() for picture in drawn]
        assert off[i % len(drawn)] < 3  # H.264 is lossy
        assert off[i % len(drawn)] < min(off) + 0.05  # at the end hardly anything moves
    assert np.abs(frames[0].astype(int) - drawn[-1]).mean() > 4
    stats = read_json(filmed / "meta/stats.json")["observation.images.front"]
    assert stats["count"] == [len(frames)]
    expected = np.mean([*drawn, *drawn], axis=(0, 1, 2)) / 255
    assert np.allclose(np.ravel(stats["mean"]), expected)
    assert np.shape(episodes["stats/observation.images.front/q50"][0][0][0]) == (1,)


def test_a_recording_is_filmed_with_its_own_hand(
    recordings: RecordingSet, tmp_path: Path, read_video: Callable[[Path], Any]
) -> None:
    one = recordings[0]
    write_lerobot(one, tmp_path / "set", fps=2, camera="view", size=(64, 48))
    _, frames = read_video(tmp_path / f"set/videos/observation.images.view/{FILE}.mp4")
    clip = posture_clip(one.time - one.time[0], one.q, posture_model(one.hand))
    drawn = list(render_clips([clip], View("view", 64, 48, 2)))
    assert len(frames) == len(drawn) == len(frame_times(one.duration, 2))
    off = [np.abs(frames[1].astype(int) - picture).mean() for picture in drawn]
    assert off[1] == min(off) < 3


def test_large_data_sets_are_cut_into_files(recordings: RecordingSet, tmp_path: Path) -> None:
    episodes = episodes_of(recordings)
    plan = plan_of(episodes)
    takes = [take_of(each, plan) for each in episodes]
    columns = columns_of(takes, list(dict.fromkeys(each.sentence for each in episodes)))
    size = sum(array.nbytes for array in columns[0].values())
    rows = write_frames(columns, tmp_path, max_bytes=round(3.5 * size))
    assert [each.file for each in rows] == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    second = pd.read_parquet(tmp_path / "data/chunk-000/file-001.parquet")
    assert second["episode_index"].unique().tolist() == [3, 4, 5]
    assert second["index"].min() == rows[3].start == rows[2].end
    assert pq.ParquetFile(tmp_path / "data/chunk-000/file-001.parquet").num_row_groups == 3
    view = View("view", 64, 48, 50)
    files = files_of(takes, view, 2.5 * 80 * 0.1 * 64 * 48)
    assert files == [[0, 1], [2, 3], [4, 5], [6, 7], [8]]
    places = places_of(takes, files, 50)
    assert [(each.file, each.start, each.end) for each in places[:3]] == [
        (0, 0.0, 1.6), (0, 1.6, 3.2), (1, 0.0, 1.6),
    ]  # fmt: skip


def test_a_thousand_files_are_a_chunk() -> None:
    assert file_of(999) == {"chunk_index": 0, "file_index": 999}
    assert file_of(1000) == {"chunk_index": 1, "file_index": 0}


def test_a_data_set_is_replaced_and_nothing_else(recordings: RecordingSet, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    folder.mkdir()
    write_lerobot(recordings, folder)
    write_lerobot(recordings[:2], folder)
    assert read_json(folder / "meta/info.json")["total_episodes"] == 2
    other = tmp_path / "other"
    (other / "meta").mkdir(parents=True)
    (other / "meta" / "info.json").write_text("{}")
    with pytest.raises(FileError, match=r"holds 'meta', which `handsim export` did not write"):
        write_lerobot(recordings, other)
    assert (other / "meta" / "info.json").read_text() == "{}"
    assert {path.name for path in tmp_path.iterdir()} == {"set", "other"}


def test_what_fails_half_way_leaves_the_old_folder(
    recordings: RecordingSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_lerobot(recordings[:2], tmp_path / "set")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(data_set, "write_meta", full)
    with pytest.raises(FileError, match="No space left on device"):
        write_lerobot(recordings, tmp_path / "set")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]
    assert read_json(tmp_path / "set/meta/info.json")["total_episodes"] == 2


@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"camera": "view", "size": (63, 48)}, InputError, "takes even sizes, give 64x48"),
        ({"camera": "nose"}, UnknownNameError, "unknown camera 'nose'"),
        ({"fps": 0}, InputError, "give 1 to 1000"),
        ({"camera": "view", "fps": 500}, InputError, "500 frames a second; give 1 to 240"),
    ],
)
def test_what_cannot_be_filmed_is_refused(
    recordings: RecordingSet, tmp_path: Path, options: dict, error: type, said: str
) -> None:
    with pytest.raises(error, match=said):
        write_lerobot(recordings[:1], tmp_path / "set", **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["pandas", "pyarrow"])
def test_without_the_library_its_extra_is_named(
    recordings: RecordingSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingToolError, match=rf"{name}; run: pip install 'handsim\[export\]'"):
        write_lerobot(recordings, tmp_path / "set")
    assert not list(tmp_path.iterdir())

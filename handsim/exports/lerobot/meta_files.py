"""What a LeRobot data set says about itself: features, rate, tasks, episodes, statistics."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handsim.exports.lerobot.data_set_layout import (
    CHUNK,
    DATA_MB,
    DATA_PATH,
    EPISODES_PATH,
    FACTS,
    INFO,
    STATS,
    TASKS,
    VERSION,
    VIDEO_MB,
    VIDEO_PATH,
    file_of,
    made,
)
from handsim.exports.lerobot.feature_statistics import PixelCounts, statistics_of
from handsim.exports.lerobot.features import Plan, Take
from handsim.exports.lerobot.film_files import Films, video_feature
from handsim.exports.lerobot.frame_files import COUNTED, Columns, Rows
from handsim.exports.libraries import library

ROBOT = "handsim"
"""What ``info.json`` calls the robot."""


@dataclass(frozen=True)
class Written:
    """All that the files about a data set are made from.

    Attributes
    ----------
    takes
        Its episodes.
    tasks
        Sentences, in the order of their numbers.
    plan
    columns, rows
        Of each episode.
    films
        None where there are none.
    """

    takes: Sequence[Take]
    tasks: tuple[str, ...]
    plan: Plan
    columns: Sequence[Columns]
    rows: Sequence[Rows]
    films: Films | None


def write_meta(written: Written, folder: Path) -> None:
    """Write the files about a data set."""
    arrow, parquet = library("pyarrow"), library("pyarrow.parquet")
    numbered = {"task_index": np.arange(len(written.tasks))}
    tasks = library("pandas").DataFrame(numbered, index=list(written.tasks))
    tasks.to_parquet(made(folder / TASKS))
    episodes = arrow.Table.from_pylist([_row(written, i) for i in range(len(written.takes))])
    path = made(folder / EPISODES_PATH.format(**file_of(0)))
    parquet.write_table(episodes, path, compression="snappy")
    _write_json(folder / STATS, _statistics(written))
    _write_json(folder / INFO, info_of(written))
    _write_json(folder / FACTS, _facts(written))


def info_of(written: Written) -> dict[str, Any]:
    """Return ``info.json``."""
    n = len(written.takes)
    return {
        "codebase_version": VERSION,
        "robot_type": ROBOT,
        "total_episodes": n,
        "total_frames": written.rows[-1].end,
        "total_tasks": len(written.tasks),
        "chunks_size": CHUNK,
        "data_files_size_in_mb": DATA_MB,
        "video_files_size_in_mb": VIDEO_MB,
        "fps": written.plan.fps,
        "splits": {"train": f"0:{n}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH if written.films is not None else None,
        "features": _features(written),
    }


def _features(written: Written) -> dict[str, Any]:
    """Return what a frame holds, in the words of ``info.json``."""
    own = {
        feature.name: {
            "dtype": str(feature.values.dtype),
            "shape": [feature.values.shape[1]],
            "names": list(feature.names) or None,
        }
        for feature in written.takes[0].features
    }
    films = written.films
    filmed = {} if films is None else {films.key: video_feature(films.view)}
    kinds = (("timestamp", "float32"), *((name, "int64") for name in COUNTED))
    counted = {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in kinds}
    return {**own, **filmed, **counted}


def _row(written: Written, i: int) -> dict[str, Any]:
    """Return what is said of an episode: where it is, and its statistics."""
    episode, rows, films = written.takes[i].episode, written.rows[i], written.films
    row: dict[str, Any] = {
        "episode_index": i,
        "tasks": [episode.sentence],
        "length": rows.end - rows.start,
        **{f"data/{name}": number for name, number in file_of(rows.file).items()},
        "dataset_from_index": rows.start,
        "dataset_to_index": rows.end,
    }
    statistics = {name: _of_columns([each]) for name, each in written.columns[i].items()}
    if films is not None:
        place = films.places[i]
        of_film = {**file_of(place.file), "from_timestamp": place.start, "to_timestamp": place.end}
        row |= {f"videos/{films.key}/{name}": value for name, value in of_film.items()}
        statistics[films.key] = films.counts[i].statistics()
    for feature, of_feature in statistics.items():
        row |= {f"stats/{feature}/{name}": value for name, value in of_feature.items()}
    row |= {f"meta/episodes/{name}": number for name, number in file_of(0).items()}
    row["name"] = episode.name
    if episode.success is not None:
        row["success"] = episode.success
    return row


def _statistics(written: Written) -> dict[str, Any]:
    """Return statistics over all frames."""
    found = {
        name: _of_columns([each[name] for each in written.columns]) for name in written.columns[0]
    }
    if written.films is not None:
        whole = PixelCounts()
        for counts in written.films.counts:
            whole.add(counts)
        found[written.films.key] = whole.statistics()
    return found


def _of_columns(columns: Sequence[Any]) -> dict[str, Any]:
    values = np.concatenate(columns)
    return statistics_of(values.reshape(len(values), -1))


def _facts(written: Written) -> dict[str, Any]:
    """Return what LeRobot does not ask for, and somebody will."""
    return {
        "kind": "handsim movements",
        "left_out": list(written.plan.left_out),
        "episodes": [
            {
                "name": take.episode.name,
                "kind": take.episode.kind,
                "task": take.episode.task,
                "resampled": take.resampled,
                "phases": [{"name": name, "start_s": start} for name, start in take.episode.phases],
                **take.episode.facts,
            }
            for take in written.takes
        ],
    }


def _write_json(path: Path, content: Any) -> None:
    made(path).write_text(json.dumps(content, indent=4, ensure_ascii=False), encoding="utf-8")

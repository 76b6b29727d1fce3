"""Files of hand keypoints: arrays of NumPy, tables of text, JSON."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handsim.errors import FileError
from handsim.files import as_floats, read_arrays, read_text
from handsim.joints import FINGERS
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.points.keypoint_order import COUNTS, KEYPOINTS
from handsim.types import Array

SUFFIXES = (".npz", ".npy", ".csv", ".tsv", ".txt", ".json")
MAX_FRAMES = 1_000_000
_POINT_WORDS = ("keypoint", "landmark", "joint", "point", "hand")
_TIME = re.compile(
    r"(?:channel:)?(?:time|timestamp|t|stamp|seconds)(?:[ _\[(]*(?:s|ms|us|ns|sec)?[\])]*)"
)
_RATE = ("fps", "rate", "rate_hz", "frequency", "framerate", "frame_rate")
_AXIS_LAST = re.compile(r"(.*?)[ _.:-]*([xyz])(?:[ _]?\[?\(?(?:m|mm|cm)\)?\]?)?")
_AXIS_FIRST = re.compile(r"([xyz])[ _.:-]*(\d+)")
_NUMBER = re.compile(r"\D*(\d+)")
_JSON_POINTS = ("landmarks", "keypoints", "joints", "points", "hand", "hand_landmarks",
                "world_landmarks", "hand_world_landmarks", "multi_hand_landmarks",
                "multi_hand_world_landmarks", "positions", "data")  # fmt: skip
_JSON_TIME = ("time", "timestamp", "time_s", "t", "timestamp_ms")
_MAX_DEPTH = 6


@dataclass(frozen=True)
class KeypointFile:
    """What a file of keypoints holds, in its own unit and order.

    Attributes
    ----------
    points : (n, k, 3)
        k is one of `COUNTS`; NaN where a point is missing.
    stamps : (n,) or None
        Times in a unit of their own.
    rate_hz
        None where the file says none.
    notes
        What was chosen or left out.
    """

    points: Array
    stamps: Array | None = None
    rate_hz: float | None = None
    notes: tuple[str, ...] = ()


def read_keypoint_file(path: Path) -> KeypointFile:
    """Read a file of keypoints, of whichever of `SUFFIXES`.

    Raises
    ------
    FileError
        If it is missing, damaged, or holds no keypoints.
    """
    suffix = path.suffix.lower()
    if suffix in (".npz", ".npy"):
        return _of_arrays(path, read_arrays(path))
    if suffix == ".json":
        return _of_json(path)
    if suffix in SUFFIXES:
        return _of_table(read_table(path, header=False))
    raise FileError(f"{path}: '{suffix}' is no file of keypoints; give {', '.join(SUFFIXES)}")


def _of_arrays(path: Path, arrays: Mapping[str, Any]) -> KeypointFile:
    numbers = {
        name: as_floats(array)
        for name, array in arrays.items()
        if array.dtype.kind in "fiu" and array.size
    }
    found = {
        name: made for name, array in numbers.items() if (made := _as_points(array)) is not None
    }
    if not found:
        shapes = ", ".join(f"{name or 'array'} {array.shape}" for name, array in arrays.items())
        raise FileError(
            f"{path}: no array of shape (frames, 21, 3) or (frames, 63) among {shapes[:300]}; save "
            "the keypoints so"
        )
    name = min(found, key=lambda each: (_rank(each), each))
    points = found[name]
    others = sorted(set(found) - {name})
    notes = (f"array {name} taken, not {', '.join(others)}",) if others else ()
    stamps = next(
        (
            a
            for key, a in numbers.items()
            if a.shape == (len(points),) and _TIME.fullmatch(key.lower())
        ),
        None,
    )
    rate = next(
        (float(a) for key, a in numbers.items() if key.lower() in _RATE and not a.ndim), None
    )
    return KeypointFile(points, stamps, _believable(rate), notes)


def _rank(name: str) -> int:
    """Return how likely an array of that name is the keypoints; less is more likely."""
    low = name.lower()
    word = next((i for i, word in enumerate(_POINT_WORDS) if word in low), len(_POINT_WORDS))
    return word - (10 if "world" in low else 0)


def _as_points(array: Array) -> Array | None:
    """Return an array as (n, k, 3), or None if its shape is not that of keypoints."""
    if array.ndim == 2 and array.shape[1] in [3 * count for count in COUNTS]:
        return array.reshape(len(array), -1, 3)
    if array.ndim == 4 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim == 3 and array.shape[1] in COUNTS and array.shape[2] in (3, 4):
        return array[..., :3]  # the fourth is a visibility
    return None


def _believable(rate: float | None) -> float | None:
    return rate if rate is not None and 1 <= rate <= 100_000 else None


def _of_table(table: Table) -> KeypointFile:
    columns, time = _columns_by_name(table.header) if table.header else ({}, None)
    n = table.n_columns
    if len(columns) not in [3 * count for count in COUNTS]:
        if n not in (63, 64, 75, 76, 78, 79):
            raise FileError(
                f"{table.path}: {n} columns, of which {len(columns)} name a keypoint and x, y or "
                "z; give 63, with or without a time before them"
            )
        ahead = n % 3
        time = 0 if ahead else None
        places = list(range(ahead, n))
    else:
        places = [columns[key] for key in sorted(columns)]
    values = table.values([*places, *([] if time is None else [time])])
    points = values[:, : len(places)].reshape(len(values), len(places) // 3, 3)
    stamps = None if time is None else values[:, -1]
    if stamps is not None and table.header and "frame" in table.header[time or 0].lower():
        stamps = None  # a count of frames is no time
    return KeypointFile(points, stamps)


def _columns_by_name(header: tuple[str, ...]) -> tuple[dict[tuple[int, int], int], int | None]:
    """Return columns by keypoint and axis, and the column of the time."""
    columns: dict[tuple[int, int], int] = {}
    time: int | None = None
    for i, cell in enumerate(header):
        low = cell.strip().lower()
        if time is None and _TIME.fullmatch(low):
            time = i
            continue
        first, last = _AXIS_FIRST.fullmatch(low), _AXIS_LAST.fullmatch(low)
        name, axis = (first[2], first[1]) if first else (last[1], last[2]) if last else ("", "")
        point = _point_of(name)
        if axis and point is not None:
            columns.setdefault((point, "xyz".index(axis)), i)
    if columns and min(columns)[0] == 1 and max(columns)[0] in COUNTS:
        columns = {(point - 1, axis): i for (point, axis), i in columns.items()}
    return columns, time


def _point_of(name: str) -> int | None:
    """Return which keypoint a name such as ``landmark_8``, ``8`` or ``index_finger_tip`` means."""
    words = [word for word in re.split(r"[^a-z0-9]+", name) if word not in ("finger", "hand", "")]
    if words == ["wrist"]:
        return 0
    words = ["little" if word in ("pinky", "small") else word for word in words]
    joined = "_".join(words)
    if joined in KEYPOINTS:
        return KEYPOINTS.index(joined)
    finger = next((i for i, each in enumerate(FINGERS) if words and words[0] == each), None)
    number = _NUMBER.fullmatch(words[-1]) if words else None
    if finger is not None:
        if number is None or len(words) != 2 or not 1 <= int(number[1]) <= 4:
            return None
        return 4 * finger + int(number[1])
    if number is None or len(words) > 2 or len(number[1]) > 2:
        return None
    return int(number[1])


def _of_json(path: Path) -> KeypointFile:
    try:
        content = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        reason = str(error).splitlines()[0]
        raise FileError(f"{path}: not readable as JSON ({reason}); export it again") from error
    rate: float | None = None
    if isinstance(content, dict):
        rate = next((_float(content[key]) for key in _RATE if key in content), None)
        frames = next(
            (
                content[key]
                for key in ("frames", *_JSON_POINTS)
                if isinstance(content.get(key), list)
            ),
            None,
        )
    else:
        frames = content
    if not isinstance(frames, list) or not frames:
        raise FileError(f"{path}: holds no list of frames; give a list with 21 points a frame")
    if len(frames) > MAX_FRAMES:
        raise FileError(f"{path}: {len(frames)} frames, more than {MAX_FRAMES}; split it")
    made = [_frame_of_json(frame, 0) for frame in frames]
    counts = [len(each) for each in made if each is not None]
    count = max(set(counts), key=counts.count, default=0)
    if count not in COUNTS or counts.count(count) < len(counts):
        odd = next((i for i, each in enumerate(made) if each is not None and len(each) != count), 0)
        raise FileError(
            f"{path}: frame {odd + 1} has no 21 points; give each frame as a list of 21 [x, y, z]"
        )
    points = np.full((len(made), count, 3), np.nan)
    for i, each in enumerate(made):
        if each is not None:
            points[i] = each
    stamps = [_time_of_json(frame) for frame in frames]
    timed = np.array(stamps, dtype=float) if None not in stamps else None
    return KeypointFile(points, timed, _believable(rate))


def _frame_of_json(frame: Any, depth: int) -> list[list[float]] | None:
    """Return the points of a frame; None where no hand is seen in it."""
    if isinstance(frame, dict):
        inner = next((frame[key] for key in _JSON_POINTS if key in frame), None)
        if inner is None and "wrist" in {key.lower() for key in frame}:
            return _named_points(frame)
        return _frame_of_json(inner, depth + 1) if depth < _MAX_DEPTH else None
    if not isinstance(frame, list) or not frame:
        return None
    if len(frame) == 1:  # one hand of several that might be there
        return _frame_of_json(frame[0], depth + 1) if depth < _MAX_DEPTH else None
    if all(isinstance(each, int | float) for each in frame):
        values = [_float(each) for each in frame]
        return [values[i : i + 3] for i in range(0, len(values), 3)]
    return [_point_of_json(each) for each in frame]


def _named_points(frame: Mapping[str, Any]) -> list[list[float]] | None:
    made = [[np.nan] * 3 for _ in KEYPOINTS]
    for name, value in frame.items():
        point = _point_of(name.lower())
        if point is not None and point < len(KEYPOINTS):
            made[point] = _point_of_json(value)
    return made


def _point_of_json(point: Any) -> list[float]:
    if isinstance(point, dict):
        low = {key.lower(): value for key, value in point.items()}
        return [_float(low.get(axis)) for axis in "xyz"]
    if isinstance(point, list) and len(point) >= 3:
        return [_float(value) for value in point[:3]]
    return [np.nan] * 3


def _time_of_json(frame: Any) -> float | None:
    if not isinstance(frame, dict):
        return None
    value = next((frame[key] for key in _JSON_TIME if key in frame), None)
    return None if value is None else _float(value)


def _float(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return np.nan

"""Keypoints in all the files in which they come, and files that hold none."""

import json
from pathlib import Path

import numpy as np
import pytest
from seen_hand import SIZE, movement, seen

from handsim.errors import FileError
from handsim.recordings.points.keypoint_files import read_keypoint_file
from handsim.recordings.points.keypoint_order import (
    KEYPOINTS,
    ORDERS,
    expected_places,
    in_order,
    metres_per_unit,
)

POINTS = np.round(np.random.default_rng(0).uniform(-0.1, 0.1, (12, 21, 3)), 5)
FLAT = POINTS.reshape(12, 63)
TIME = np.arange(12) / 50


def csv(header: list[str], rows: np.ndarray, separator: str = ",") -> str:
    lines = [separator.join(header)] if header else []
    return "\n".join([*lines, *(separator.join(f"{x:.5f}" for x in row) for row in rows)])


def named(name: str) -> list[str]:
    return [name.format(i=i, point=KEYPOINTS[i], axis=axis) for i in range(21) for axis in "xyz"]


def test_arrays_of_any_name_and_shape(tmp_path: Path) -> None:
    for i, arrays in enumerate([
        {"keypoints": POINTS, "time": TIME}, {"data": FLAT, "fps": np.array(50.0)},
        {"a": POINTS[:, None].astype(np.float32)},
        {"landmarks": 2 * POINTS, "world_landmarks": POINTS},
        {"v": np.concatenate([POINTS, np.ones((12, 21, 1))], axis=2)},
    ]):  # fmt: skip
        file = tmp_path / f"{i}.npz"
        np.savez(file, **arrays)
        read = read_keypoint_file(file)
        assert np.abs(read.points - POINTS).max() < 1e-7
        assert (read.stamps is not None) == ("time" in arrays)
        assert read.rate_hz == (50.0 if "fps" in arrays else None)
        assert bool(read.notes) == ("world_landmarks" in arrays)
    np.save(tmp_path / "a.npy", FLAT)
    assert (read_keypoint_file(tmp_path / "a.npy").points == POINTS).all()


@pytest.mark.parametrize(
    "header",
    [
        [],
        named("landmark_{i}_{axis}"),
        named("{axis}{i}"),
        named("{point}_{axis}"),
        named("{point}.{axis}"),
        named("joint{i}{axis}"),
    ],
    ids=lambda h: str(h[:1]),
)
@pytest.mark.parametrize("timed", [False, True])
def test_tables_with_and_without_names_and_times(
    tmp_path: Path, header: list[str], timed: bool
) -> None:
    rows = np.column_stack([TIME, FLAT]) if timed else FLAT
    file = tmp_path / "k.csv"
    file.write_text(csv((["time_s"] if timed else []) + header if header else [], rows))
    read = read_keypoint_file(file)
    assert np.abs(read.points - POINTS).max() < 1e-9
    assert (read.stamps is not None) == timed


def test_columns_are_found_by_their_names_not_their_places(tmp_path: Path) -> None:
    header = named("{point}_{axis}")
    order = np.random.default_rng(1).permutation(63)
    rows = np.column_stack([FLAT[:, order], TIME, np.ones(12)])
    file = tmp_path / "k.csv"
    file.write_text(csv([*(header[i] for i in order), "timestamp", "confidence"], rows, ";"))
    read = read_keypoint_file(file)
    assert np.abs(read.points - POINTS).max() < 1e-9
    assert read.stamps == pytest.approx(TIME, abs=1e-5)


def test_json_of_lists_and_of_dicts(tmp_path: Path) -> None:
    dicts = [[dict(zip("xyz", point, strict=True)) for point in frame] for frame in POINTS.tolist()]
    for i, content in enumerate([
        POINTS.tolist(), FLAT.tolist(), dicts, {"frames": dicts, "fps": 50},
        [{"landmarks": frame} for frame in dicts],
        {"frames": [{"hand_landmarks": [frame]} for frame in POINTS.tolist()], "fps": 50},
        [{"timestamp": t, "keypoints": f} for t, f in zip(TIME.tolist(), dicts, strict=True)],
        [dict(zip(KEYPOINTS, frame, strict=True)) for frame in POINTS.tolist()],
    ]):  # fmt: skip
        file = tmp_path / f"{i}.json"
        file.write_text(json.dumps(content))
        read = read_keypoint_file(file)
        assert np.abs(read.points - POINTS).max() < 1e-9, i
        assert read.rate_hz == (50 if isinstance(content, dict) else None)
    assert read_keypoint_file(tmp_path / "6.json").stamps == pytest.approx(TIME)
    lost = POINTS.tolist()
    lost[3], lost[4] = None, []
    (tmp_path / "lost.json").write_text(json.dumps(lost))
    missing = np.isnan(read_keypoint_file(tmp_path / "lost.json").points).all(axis=(1, 2))
    assert np.flatnonzero(missing).tolist() == [3, 4]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.json", "[[1, 2", "not readable as JSON"),
        ("b.json", "[" * 100_000, "not readable as JSON"),
        ("c.json", "{}", "no list of frames"),
        ("d.json", "[[[1, 2, 3]], [[1, 2, 3]]]", "no 21 points"),
        ("e.csv", "a,b\n1,2\n3,4", "63"),
        ("f.txt", "", "is empty"),
        ("g.npz", "PK\x03\x04 nonsense", "not a readable file of arrays"),
        ("h.xyz", "1", "no file of keypoints"),
    ],
)
def test_what_is_no_file_of_keypoints(tmp_path: Path, name: str, content: str, said: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(FileError, match=said) as error:
        read_keypoint_file(tmp_path / name)
    assert name in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(FileError, match="no such file"):
        read_keypoint_file(tmp_path / "absent.npz")


def test_arrays_that_are_no_keypoints_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", poses=np.zeros((5, 20, 3)))
    with pytest.raises(FileError, match=r"poses \(5, 20, 3\)"):
        read_keypoint_file(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", keypoints=np.array([None], dtype=object))
    with pytest.raises(FileError, match="Python objects"):
        read_keypoint_file(tmp_path / "b.npz")


def test_a_header_that_claims_more_than_there_is_allocates_nothing(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", FLAT)
    data = (tmp_path / "a.npy").read_bytes()
    huge = data.replace(b"'shape': (12, 63), }" + b" " * 12, b"'shape': (99999999999, 63), }   ")
    assert huge != data
    (tmp_path / "a.npy").write_bytes(huge)
    with pytest.raises(FileError, match="not a readable file of arrays"):
        read_keypoint_file(tmp_path / "a.npy")


def test_orders_are_recognised() -> None:
    hand = seen(expected_places(), movement(12))
    assert in_order(hand)[1] == "MediaPipe"
    mano = np.empty_like(hand)
    mano[:, ORDERS["MANO"]] = hand
    points, order = in_order(mano)
    assert order == "MANO" and (points == hand).all()
    for name, count in (("OpenXR", 26), ("WebXR", 25)):
        more = np.full((12, count, 3), 9.0)
        more[:, ORDERS[name]] = hand
        points, order = in_order(more)
        assert order == name and (points == hand).all()


@pytest.mark.parametrize(("factor", "unit"), [(1, "m"), (100, "cm"), (1000, "mm"), (7, "own")])
def test_units_by_the_size_of_the_hand(factor: float, unit: str) -> None:
    hand = factor * seen(expected_places(), movement(12))
    scale, name = metres_per_unit(hand, None if unit != "own" else SIZE.length)
    assert unit in name and scale == pytest.approx(1 / factor, rel=1e-9 if unit != "own" else 0.1)


def test_places_in_a_picture_have_a_unit_of_their_own() -> None:
    hand = seen(expected_places(), movement(12))
    picture = (hand - hand[:, :1]) * [1, 1, 1]
    picture[..., :2] += 0.5
    assert metres_per_unit(picture, 0.18)[1] == "a unit of their own"
    assert metres_per_unit(np.zeros((3, 21, 3)), None)[0] == 0.0

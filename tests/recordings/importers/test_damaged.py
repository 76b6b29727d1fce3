"""Damaged tables, gloves, maps, calibrations and postures: read, or refused in a line."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from handsim.errors import InputError
from handsim.joints import N_JOINTS
from handsim.recordings.columns.draft import draft_map
from handsim.recordings.glove.calibrate import calibrate_postures, postures_of_table
from handsim.recordings.glove.calibration import GloveCalibration, write_calibration
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions

CASES = 40
KINDS = ("table", "draft", "map", "glove", "calibration", "postures", "ninapro")
PIECES = (
    b"nan", b"inf", b"1e999", b"-1e308", b"9" * 400, b"", b"1,5", b"1.234,5", b'"', b"\0",
    b"\xff\xfe", b"12:30:01.250", b"2024-13-45 99:99:99", b"\r", b"\x85", b"1_000", b"#", b";",
    b"\t", b"9\xb0", b"[[", b"=", b"true", b"\xef\xbb\xbf",
)  # fmt: skip


def damaged(rng: np.random.Generator, data: bytes) -> bytes:
    for _ in range(rng.integers(1, 4)):
        i, kind = int(rng.integers(0, len(data) + 1)), rng.integers(0, 7)
        long, piece = int(rng.integers(1, 200)), PIECES[rng.integers(0, len(PIECES))]
        lines = data.split(b"\n")
        j = int(rng.integers(0, len(lines)))
        if kind == 0 and i < len(data):
            data = data[:i] + bytes([data[i] ^ 1 << int(rng.integers(0, 8))]) + data[i + 1 :]
        elif kind == 1:
            data = data[:i]
        elif kind == 2:
            data = data[:i] + data[i : i + long] + data[i:]
        elif kind == 3:
            data = data[:i] + data[i + long :]
        elif kind == 4:
            data = data[:i] + piece + data[i + int(rng.integers(0, 6)) :]
        elif kind == 5:
            data = b"\n".join(lines[:j] + [lines[j]] * int(rng.integers(0, 3)) + lines[j + 1 :])
        else:
            column = int(rng.integers(0, 24))
            rows = [line.split(b",") for line in lines]
            data = b"\n".join(b",".join(r[:column] + r[column + 1 :]) for r in rows)
    return data


def imported(file: Path, layout: str, **said) -> object:
    return import_recordings([file], layout, options=ImportOptions(**said))


def reader(kind: str, folder: Path) -> Callable[[Path], object]:
    table, glove, made = (folder / name for name in ("table.csv", "glove.csv", "glove.toml"))
    return {
        "table": lambda path: imported(path, "table", bridge_s=0.1, unwrap=True),
        "draft": draft_map,
        "map": lambda path: imported(table, "table", column_map=path),
        "glove": lambda path: imported(path, "cyberglove", calibration=made, bridge_s=0.1),
        "calibration": lambda path: imported(glove, "cyberglove", calibration=path),
        "postures": lambda path: calibrate_postures(postures_of_table(path, [])),
        "ninapro": lambda path: imported(path, "ninapro", calibration=made, bridge_s=0.1),
    }[kind]


@pytest.fixture
def originals(movement) -> dict[str, Path]:
    """Files of each kind that are read."""
    folder = movement.folder
    table = movement.write("table.csv")
    movement.write("glove.csv", header=None, values=movement.angles + 60, number="{:.0f}")
    fist = movement.angles + 60 + np.where(np.arange(N_JOINTS) > 3, 80, 0)
    movement.write("fist.csv", header=None, values=fist, number="{:.0f}")
    ones = np.ones(N_JOINTS)
    made = GloveCalibration("x", ("ranges",) * N_JOINTS, ones, -60 * ones, np.nan * ones,
                            np.outer(ones, [60, 160]))  # fmt: skip
    write_calibration(made, folder / "glove.toml")
    (folder / "map.toml").write_text(draft_map(table))
    (folder / "postures.toml").write_text(
        '[[posture]]\nfile = "glove.csv"\nname = "flat"\n'
        '[[posture]]\nfile = "fist.csv"\nname = "fist"\nrows = [2, 30]\nangles = {thumb_ip = 0}\n'
    )
    label = np.repeat([0, 1, 0, 2], 10)[:, None]
    savemat(folder / "n.mat", {"glove": movement.angles + 60, "restimulus": label, "subject": 1,
                               "emg": movement.angles[:, :10]})  # fmt: skip
    names = ("table.csv", "table.csv", "map.toml", "glove.csv", "glove.toml", "postures.toml")
    return {kind: folder / name for kind, name in zip(KINDS, (*names, "n.mat"), strict=True)}


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused_in_a_line(kind: str, originals, tmp_path: Path) -> None:
    original = originals[kind]
    read = reader(kind, tmp_path)
    read(original)
    rng = np.random.default_rng(sum(map(ord, kind)))
    data, path = original.read_bytes(), original.with_name(f"damaged{original.suffix}")
    refused = 0
    for _ in range(CASES):
        path.write_bytes(damaged(rng, data))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                read(path)
            except InputError as error:
                assert "\n" not in str(error) and len(str(error)) < 2000
                refused += 1
    assert refused > 0

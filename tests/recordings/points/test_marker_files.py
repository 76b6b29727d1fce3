"""Tables of motion capture in the ways in which systems export them."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from handsim.errors import FileError, MissingToolError
from handsim.recordings.points.marker_files import read_marker_file

NAMES = ("hand_top", "index_tip", "thumb_tip")
AT = np.round(np.random.default_rng(2).uniform(10, 500, (15, 3, 3)), 3)
TIME = np.arange(15) / 100
ROWS = np.column_stack([np.arange(1, 16), TIME, AT.reshape(15, 9)])


def body(rows: np.ndarray, separator: str) -> list[str]:
    return [separator.join(f"{x:.6g}" for x in row) for row in rows]


def qualisys(columns: bool = True) -> str:
    head = ["NO_OF_FRAMES\t15", "NO_OF_MARKERS\t3", "FREQUENCY\t100", "DATA_INCLUDED\t3D"]
    head += ["MARKER_NAMES\t" + "\t".join(NAMES), "TRAJECTORY_TYPES\tMeasured\tMeasured\tMixed"]
    names = "\t".join(f"{name} {axis}" for name in NAMES for axis in "XYZ")
    rows = ROWS if columns else ROWS[:, 2:]
    return "\n".join([*head, *([f"Frame\tTime\t{names}\t"] if columns else []), *body(rows, "\t")])


def stacked() -> str:
    """Names over letters, as other systems do."""
    names = ",," + ",".join(f"Subject:{name},," for name in NAMES)
    letters = "Frame,Sub Frame," + ",".join("X,Y,Z" for _ in NAMES)
    units = ",," + ",".join("mm,mm,mm" for _ in NAMES)
    rows = np.column_stack([ROWS[:, 0], 0 * ROWS[:, 0], ROWS[:, 2:]])
    return "\n".join(["Trajectories,,", "Rate,100", names, letters, units, *body(rows, ",")])


def test_qualisys_exports(tmp_path: Path) -> None:
    (tmp_path / "a.tsv").write_text(qualisys())
    read = read_marker_file(tmp_path / "a.tsv")
    assert read.names == NAMES and read.rate_hz == 100
    assert np.abs(read.positions - AT).max() < 1e-2
    assert read.stamps == pytest.approx(TIME)
    (tmp_path / "b.tsv").write_text(qualisys(columns=False))
    bare = read_marker_file(tmp_path / "b.tsv")
    assert bare.names == NAMES and (bare.positions == read.positions).all()
    assert bare.stamps is None and bare.rate_hz == 100


def test_names_above_letters(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(stacked())
    read = read_marker_file(tmp_path / "a.csv")
    assert [name.split(":")[1] for name in read.names] == list(NAMES)
    assert np.abs(read.positions - AT).max() < 1e-2
    assert read.metres_per_unit == 0.001


@pytest.mark.parametrize(
    "form", ["{} {}", "{}_{}", "{}.{}", "{} - {}", "{}:{}", "{} {} [mm]", "{}{}"]
)
@pytest.mark.parametrize("axes", ["XYZ", "xyz"])
def test_names_with_letters(tmp_path: Path, form: str, axes: str) -> None:
    header = [form.format(name, axis) for name in NAMES for axis in axes]
    (tmp_path / "a.csv").write_text("\n".join([",".join(header), *body(ROWS[:, 2:], ",")]))
    read = read_marker_file(tmp_path / "a.csv")
    assert read.names == NAMES and np.abs(read.positions - AT).max() < 1e-2
    assert read.metres_per_unit == (0.001 if "mm" in form else None)


def test_gaps_are_empty_or_zero_or_nan(tmp_path: Path) -> None:
    lines = qualisys().split("\n")
    cells = [line.split("\t") for line in lines]
    cells[7][5:8] = ["", "", ""]
    cells[8][5:8] = ["0", "0.000", "0"]
    cells[9][5:8] = ["NaN", "nan", ""]
    cells[10] = cells[10][:-3]  # what is empty at the end may be left out
    (tmp_path / "a.tsv").write_text("\n".join("\t".join(line) for line in cells))
    read = read_marker_file(tmp_path / "a.tsv")
    missing = np.argwhere(np.isnan(read.positions[..., 0])).tolist()
    assert missing == [[0, 1], [1, 1], [2, 1], [3, 2]]


def test_what_holds_no_markers(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time,angle\n0,1\n1,2\n2,3\n")
    with pytest.raises(FileError, match="end in X, Y and Z"):
        read_marker_file(tmp_path / "a.csv")
    with pytest.raises(FileError, match="no such file"):
        read_marker_file(tmp_path / "absent.tsv")


def test_c3d_needs_its_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a.c3d"
    file.write_bytes(b"\x02P")
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(MissingToolError, match=r"pip install 'handsim\[markers\]'"):
        read_marker_file(file)

    def c3d(path: str) -> dict[str, object]:
        assert path == str(file)
        return {
            "parameters": {"POINT": {"LABELS": {"value": list(NAMES)}, "RATE": {"value": [200.0]},
                                     "UNITS": {"value": ["mm"]}}},
            "data": {"points": np.concatenate([AT, np.ones((15, 3, 1))], 2).transpose(2, 1, 0)},
        }  # fmt: skip

    fake = ModuleType("ezc3d")
    fake.c3d = c3d  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ezc3d", fake)
    read = read_marker_file(file)
    assert read.names == NAMES and (read.positions == AT).all()
    assert (read.rate_hz, read.metres_per_unit) == (200.0, 0.001)
    monkeypatch.setitem(sys.modules, "ezc3d", SimpleNamespace(c3d=lambda _: 1 / 0))
    with pytest.raises(FileError, match="not readable as C3D"):
        read_marker_file(file)

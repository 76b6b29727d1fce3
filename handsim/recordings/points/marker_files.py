"""Files of optical motion capture: tables of text, and C3D where ``ezc3d`` is installed.

Tables: exports of Qualisys (tab-separated, a heading that names markers and rate), and any table
whose columns are called ``<marker> X``, ``<marker> Y``, ``<marker> Z`` in whichever way, or whose
markers stand in a line above the letters, as in exports of other systems.
"""

import re
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from handsim.disk import naming
from handsim.errors import FileError, MissingToolError
from handsim.files import MAX_ARCHIVE_BYTES, is_file
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.fitting.hand_points import are_seen
from handsim.recordings.points.marker_map import LENGTH_UNITS
from handsim.types import Array

_AXIS_LAST = re.compile(r"(.+?)[ _.:/-]*\[?\(?([XYZxyz])\)?\]?(?:[ _]*[\[(]?(m|cm|mm)[\])]?)?")
_AXIS_ALONE = re.compile(r"([XYZxyz])\d*")
_TIME = re.compile(r"time(?:[ _]*[\[(]?(?:s|sec|seconds)[\])]?)?", re.IGNORECASE)
_TIME_COLUMNS = frozenset({"frame", "frame#", "sub frame", "time"})
_RATES = ("FREQUENCY", "DATARATE", "CAMERARATE", "CAPTURE FRAME RATE", "EXPORT FRAME RATE", "RATE")
_PREAMBLE_BYTES, _PREAMBLE_LINES = 2**18, 40


@dataclass(frozen=True)
class MarkerFile:
    """What a file of markers holds.

    Attributes
    ----------
    names
        k names of markers.
    positions : (n, k, 3)
        In the file's unit; NaN where a marker is not seen.
    stamps : (n,) or None
        Times.
    rate_hz, metres_per_unit
        None where the file says nothing.
    """

    names: tuple[str, ...]
    positions: Array
    stamps: Array | None
    rate_hz: float | None
    metres_per_unit: float | None


def read_marker_file(path: Path) -> MarkerFile:
    """Read a file of markers.

    Raises
    ------
    FileError
        If it is missing, damaged, or holds no markers.
    MissingToolError
        If it is C3D and ``ezc3d`` is not installed.
    """
    made = _read_c3d(path) if path.suffix.lower() == ".c3d" else _read_text(path)
    there = are_seen(made.positions) & (made.positions != 0).any(axis=2)
    positions = np.where(there[..., None], made.positions, np.nan)
    return MarkerFile(made.names, positions, made.stamps, made.rate_hz, made.metres_per_unit)


def _read_text(path: Path) -> MarkerFile:
    table = read_table(path, header=False)
    above = _preamble(path, table)
    columns, unit = _marker_columns(table, above)
    if not columns:
        raise FileError(
            f"{path}: no columns of markers found; each needs three that end in X, Y and Z, such "
            "as 'index_tip X'"
        )
    time = next((i for i, cell in enumerate(table.header) if _TIME.fullmatch(cell.strip())), None)
    places = [i for triple in columns.values() for i in triple]
    values = _values(table, [*places, *([] if time is None else [time])])
    positions = values[:, : len(places)].reshape(len(values), len(columns), 3)
    stamps = None if time is None else values[:, -1]
    rate = _rate(above, table.separator)
    factor = LENGTH_UNITS.get(unit or _stated_unit(table, above))
    return MarkerFile(tuple(columns), positions, stamps, rate, factor)


def _preamble(path: Path, table: Table) -> list[list[str]]:
    """Cells of the lines before the first row of values."""
    with naming(path, "read"), path.open("rb") as stream:
        text = stream.read(_PREAMBLE_BYTES)
    encoding = "utf-16" if text[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    lines = text.decode(encoding, errors="replace").splitlines()
    first = int(table.numbers[0]) - 1 if len(table) else 0
    kept = lines[: min(first, _PREAMBLE_LINES)]
    return [[cell.strip().strip('"') for cell in line.split(table.separator)] for line in kept]


def _values(table: Table, columns: list[int]) -> Array:
    """Return columns as numbers; rows may be shorter or longer by what is empty at their end."""
    n, sign = max(columns) + 1, table.separator
    if sign == " ":
        return table.values(columns)
    header = (*table.header, *[""] * n)[:n] if table.header else ()
    lines = tuple(_of_length(line, n, sign) for line in table.lines)
    return replace(table, header=header, lines=lines).values(columns)


def _of_length(line: str, n: int, sign: str) -> str:
    """Return a line with its first n cells, empty ones added."""
    more = n - 1 - line.count(sign)
    if more >= 0:
        return line + sign * more
    return sign.join(line.split(sign, maxsplit=n)[:n])


def _marker_columns(
    table: Table, above: list[list[str]]
) -> tuple[dict[str, tuple[int, int, int]], str | None]:
    """Return the three columns of each marker, and the unit in their names."""
    found: dict[str, dict[str, int]] = {}
    unit = None
    for i, cell in enumerate(table.header):
        match = _AXIS_LAST.fullmatch(cell.strip())
        if match is not None and not _AXIS_ALONE.fullmatch(cell.strip()):
            found.setdefault(match[1].strip(), {}).setdefault(match[2].lower(), i)
            unit = unit or match[3]
    columns = {name: (a["x"], a["y"], a["z"]) for name, a in found.items() if len(a) == 3}
    if columns:
        return columns, unit
    for row in reversed(above):  # letters alone, and the names above them
        places = [
            i for i, cell in enumerate(row) if (m := _AXIS_ALONE.fullmatch(cell)) and m[1] in "Xx"
        ]
        if len(places) >= 2:
            return _columns_under_names(above[: above.index(row)], places), unit
    return _columns_of_list(table, above), unit


def _columns_under_names(
    above: list[list[str]], places: list[int]
) -> dict[str, tuple[int, int, int]]:
    for row in reversed(above):
        names = [next((c for c in reversed(row[: i + 1]) if c), "") for i in places]
        if len(set(names)) == len(names) and all(names):
            return {name: (i, i + 1, i + 2) for name, i in zip(names, places, strict=True)}
    return {}


def _columns_of_list(table: Table, above: list[list[str]]) -> dict[str, tuple[int, int, int]]:
    """Return columns after a line ``MARKER_NAMES``, where no line names the columns."""
    names = next(([c for c in row[1:] if c] for row in above if row[0] == "MARKER_NAMES"), [])
    n = len(table.cells(0)) if len(table) else 0
    ahead = n - 3 * len(names)
    if not names or len(set(names)) < len(names) or not 0 <= ahead <= 2:
        return {}
    return {name: (s, s + 1, s + 2) for name, s in zip(names, range(ahead, n, 3), strict=False)}


def _rate(above: list[list[str]], separator: str) -> float | None:
    """Return the rate that the heading gives: after its name, or under it."""
    for k, row in enumerate(above):
        for i, cell in enumerate(row):
            if cell.upper() not in _RATES:
                continue
            beside = row[i + 1 : i + 2]
            below = above[k + 1][i : i + 1] if k + 1 < len(above) else []
            for text in (*beside, *below):
                value = _number(text)
                if 1 <= value <= 100_000:
                    return value
    return None


def _stated_unit(table: Table, above: list[list[str]]) -> str:
    cells = [*(table.units or ()), *(cell for row in above for cell in row)]
    known = [cell.strip("[]() ").lower() for cell in cells]
    words = {"millimeters": "mm", "meters": "m", "centimeters": "cm"}
    units = [words.get(cell, cell) for cell in known]
    return next((unit for unit in units if unit in LENGTH_UNITS), "")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def _read_c3d(path: Path) -> MarkerFile:
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    with naming(path, "read"):
        size = path.stat().st_size
    if size > MAX_ARCHIVE_BYTES:
        raise FileError(f"{path}: {size} bytes, more than {MAX_ARCHIVE_BYTES}; split it")
    try:
        ezc3d: Any = import_module("ezc3d")
    except ImportError as error:
        raise MissingToolError(
            f"{path}: C3D needs ezc3d; run: pip install 'handsim[markers]'"
        ) from error
    try:
        content = ezc3d.c3d(str(path))
        point = content["parameters"]["POINT"]
        names = tuple(str(name).strip() for name in point["LABELS"]["value"])
        positions = np.array(content["data"]["points"], dtype=float)[:3].transpose(2, 1, 0)
        rate = float(np.ravel(point["RATE"]["value"])[0])
        units = [str(unit).strip().lower() for unit in point.get("UNITS", {}).get("value", [])]
    except Exception as error:  # the library raises whatever its C++ does
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileError(f"{path}: not readable as C3D ({reason}); export it again") from error
    names = names[: positions.shape[1]]
    if not names or len(set(names)) < len(names) or not len(positions):
        raise FileError(f"{path}: holds no markers with names of their own; export it again")
    factor = LENGTH_UNITS.get(units[0]) if units else None
    return MarkerFile(names, positions[:, : len(names)], None, rate, factor)

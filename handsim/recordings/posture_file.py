"""CSV files of postures: ``time_s``, the 22 joint names with ``_deg``, further channels.

Angles are degrees in files and radians everywhere else. Files of spreadsheets and loggers are read
as they are (`handsim.recordings.delimited`). A glove of 18 sensors has none for the distal joints
of the fingers; their angles are then filled (`DIP_OF_PIP`).
"""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.files import write_text
from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.recording import check_frames, check_postures
from handsim.types import Array

CHANNEL = "channel:"
"""What the header of a further channel begins with."""
DIP_OF_PIP = 0.67
"""Distal over middle flexion of a finger whose distal joint has no sensor.

Rijpkema & Girard (1991), Computer Graphics 25(4):339-348: 2/3 in free flexion.
"""
DIP_JOINTS = tuple(name for name in JOINT_NAMES if name.endswith("_dip"))
_TIME = "time_s"
_DEGREES = frozenset({"deg", "degree", "degrees", "°", ""})
_SECONDS = frozenset({"s", "sec", ""})


@dataclass(frozen=True)
class PostureTable:
    """What a posture file holds, its values not yet checked.

    Attributes
    ----------
    table
        The file.
    time : (n,) [s]
    angles : (n, 22) [deg]
        NaN where a cell holds no number.
    channels : name to (n,)
    notes
        What was filled or left out.
    """

    table: Table
    time: Array
    angles: Array
    channels: Mapping[str, Array]
    notes: tuple[str, ...]


def filled_dips(angles: Array) -> tuple[Array, tuple[str, ...]]:
    """Fill those distal joints that have no value at all from the joint before them.

    Parameters
    ----------
    angles : (n, 22)

    Returns
    -------
    angles : (n, 22)
    notes
        Which were filled, if any.
    """
    filled = np.array(angles, dtype=float)
    names = [n for n in DIP_JOINTS if np.isnan(filled[:, JOINT_NAMES.index(n)]).all()]
    for name in names:
        pip = JOINT_NAMES.index(name.replace("_dip", "_pip"))
        filled[:, JOINT_NAMES.index(name)] = DIP_OF_PIP * filled[:, pip]
    if not names:
        return filled, ()
    return filled, (f"{', '.join(names)} filled as {DIP_OF_PIP:g} times the PIP joint",)


def read_posture_table(path: Path) -> PostureTable:
    """Read a posture file, values that are missing included.

    Raises
    ------
    FileError
        If the file is missing or empty, a column is missing or there twice, or the row of units
        names others than s and deg.
    """
    table = read_table(path)
    header = table.header
    filled = [name for name in DIP_JOINTS if f"{name}_deg" not in header]
    fills = len(filled) == len(DIP_JOINTS)
    wanted = [_TIME, *(f"{name}_deg" for name in JOINT_NAMES if not (fills and name in filled))]
    for column in wanted:
        if header.count(column) != 1:
            raise FileError(_missing(table, column))
    _check_units(table, wanted)
    channels = [name for name in header if name.startswith(CHANNEL)]
    twice = next((name for name in channels if channels.count(name) > 1), None)
    if twice is not None:
        raise FileError(_missing(table, twice))
    values = table.values([header.index(name) for name in (*wanted, *channels)])
    notes = [f"{path.name}: {table.found}"] if table.found else []
    angles = np.full((len(table), N_JOINTS), np.nan)
    for column, name in enumerate(wanted[1:], start=1):
        angles[:, JOINT_NAMES.index(name.removesuffix("_deg"))] = values[:, column]
    if fills:
        angles, said = filled_dips(angles)
        notes += said
    ignored = [name for name in header if name and name not in wanted and name not in channels]
    if ignored:
        notes.append(f"columns ignored: {', '.join(ignored)}")
    return PostureTable(
        table=table,
        time=values[:, 0],
        angles=angles,
        channels={
            name.removeprefix(CHANNEL).strip(): values[:, len(wanted) + i]
            for i, name in enumerate(channels)
        },
        notes=tuple(notes),
    )


def read_postures(path: Path) -> tuple[Array, Array]:
    """Read a sequence of postures from one CSV file.

    Returns
    -------
    time : (n,) [s]
    q : (n, 22) [rad]

    Raises
    ------
    FileError
        If the file is missing or empty, a column is missing or twice, a value is no finite number,
        an angle is beyond +-180 deg, time does not increase, or there are fewer than 10 frames. The
        message names file, row (as an editor counts them) and column.
    """
    content = read_posture_table(Path(path))
    return checked_postures(content)


def checked_postures(content: PostureTable) -> tuple[Array, Array]:
    """Return time (n,) [s] and postures (n, 22) [rad] of a file without gaps.

    Raises
    ------
    FileError
        As `read_postures`.
    """
    table = content.table
    for columns, names in (
        (content.time[:, None], (_TIME,)),
        (content.angles, tuple(f"{name}_deg" for name in JOINT_NAMES)),
    ):
        missing = np.argwhere(~np.isfinite(columns))
        if missing.size:
            row, column = (int(i) for i in missing[0])
            cell = _cell(table, row, names[column])
            raise FileError(
                f"{table.path}: row {table.numbers[row]}, column {names[column]}: '{cell}' is not "
                "a finite number; correct or remove the row, or bridge short gaps with `handsim "
                "recordings import --format handsim --bridge`"
            )
    check_frames(str(table.path), content.time, content.angles, table.numbers)
    return content.time, np.deg2rad(content.angles)


def write_postures(time: Array, q: Array, path: Path) -> None:
    """Write a sequence of postures to one CSV file.

    Parameters
    ----------
    time : (n,) [s]
    q : (n, 22) [rad], written in degrees with 6 decimals (2e-8 rad)
    """
    check_postures(str(path), np.asarray(time, dtype=float), np.asarray(q, dtype=float))
    write_text(Path(path), postures_text(time, q))


def postures_text(time: Array, q: Array, channels: Mapping[str, Array] | None = None) -> str:
    """Return a posture file as text; channels have 6 decimals and an empty cell where missing."""
    further = channels or {}
    names = [_TIME, *(f"{name}_deg" for name in JOINT_NAMES), *(CHANNEL + name for name in further)]
    # + 0.0 turns -0.0 into 0.0, so that equal postures are equal text.
    columns = np.column_stack([time, np.round(np.rad2deg(q), 6) + 0.0, *further.values()])
    stream = io.StringIO()
    stream.write(",".join(names) + "\n")
    np.savetxt(stream, columns, fmt="%.6f", delimiter=",")
    text = stream.getvalue()
    return text.replace("nan", "") if further else text


def _cell(table: Table, row: int, column: str) -> str:
    """Return the cell itself, or that of the PIP joint from which it would have been filled."""
    if column not in table.header:
        column = column.replace("_dip", "_pip")
    return table.cells(row)[table.header.index(column)]


def _missing(table: Table, column: str) -> str:
    found = "twice" if column in table.header else "missing"
    divided = f" ({table.found})" if table.found else ""
    remedy = (
        "name each column once"
        if found == "twice"
        else "name each column once, or draft a map of yours with `handsim recordings map`"
    )
    return f"{table.path}: row {table.header_line}: column {column} is {found}{divided}; {remedy}"


def _check_units(table: Table, wanted: list[str]) -> None:
    if table.units is None:
        return
    of_column = dict(zip(table.header, table.units, strict=False))
    for column in wanted:
        unit = of_column.get(column, "").strip("[]() ").lower()
        if unit not in (_SECONDS if column == _TIME else _DEGREES):
            raise FileError(
                f"{table.path}: row {table.header_line + 1}, column {column}: unit '{unit}'; "
                f"{'seconds' if column == _TIME else 'degrees'} are read here, import others with "
                "`handsim recordings import --format table`"
            )

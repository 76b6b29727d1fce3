"""Reaches whose times somebody has given by hand, as a table ``file,start_s,end_s``."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from handsim.errors import FileError
from handsim.recordings.columns.cells import column_numbers
from handsim.recordings.cutting.reach import Reach
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.phases import RATE
from handsim.recordings.recording import MIN_FRAMES, Recording, RecordingSet

COLUMNS = ("file", "start_s", "end_s")
BY_HAND = "its times were given by hand"
SLACK_S = 0.005
"""How far a time may lie outside a recording [s]: tables are written with two decimals."""


@dataclass(frozen=True)
class GivenReach:
    """One row of the table.

    Attributes
    ----------
    reach
    object, task
        What was grasped and what for; None where the table does not say.
    """

    reach: Reach
    object: str | None = None
    task: str | None = None


def read_times(path: Path, recordings: RecordingSet) -> tuple[GivenReach, ...]:
    """Read a table of times; further columns are left alone.

    Parameters
    ----------
    path
        ``file`` is the name of a recording, with or without ``.csv``; times are the recording's.
        ``object`` and ``task`` may be given, too.
    recordings
        Those that the table speaks of.

    Raises
    ------
    FileError
        If a column is missing, a recording is unknown, a time is no number or outside its
        recording, a reach is shorter than 10 frames at 100 Hz, or two overlap.
    """
    table = read_table(path)
    places = {name: _place(table, name) for name in COLUMNS}
    optional = [name for name in ("object", "task") if name in table.header]
    columns = [*places.values(), *(table.header.index(name) for name in optional)]
    known = {recording.name: recording for recording in recordings}
    given: list[GivenReach] = []
    for number, cells in zip(table.numbers, table.texts(columns), strict=True):
        where = f"{path}: row {number}"
        words = dict(zip(optional, (cell.strip() for cell in cells[3:]), strict=True))
        reach = _reach(where, known, cells[0].strip(), table, cells[1:3])
        _check_apart(where, reach, [each.reach for each in given])
        given.append(GivenReach(reach, words.get("object") or None, words.get("task") or None))
    if not given:
        raise FileError(f"{path}: lists no reach; give at least 1 row under {','.join(COLUMNS)}")
    return tuple(given)


def _place(table: Table, name: str) -> int:
    if table.header.count(name) != 1:
        found = "twice" if name in table.header else "missing"
        raise FileError(
            f"{table.path}: row {table.header_line}: column {name} is {found}; the header must "
            f"hold {', '.join(COLUMNS)} once each"
        )
    return table.header.index(name)


def _reach(
    where: str, known: dict[str, Recording], file: str, table: Table, cells: Sequence[str]
) -> Reach:
    recording = known.get(file) or known.get(file.removesuffix(".csv"))
    if recording is None:
        raise FileError(
            f"{where}, column file: '{file}' is none of the {len(known)} recordings, such as "
            f"'{next(iter(known))}'; correct it"
        )
    first, last = float(recording.time[0]), float(recording.time[-1])
    start, end = column_numbers([cell.strip() for cell in cells], table.decimal_comma)
    for column, cell, value in zip(COLUMNS[1:], cells, (start, end), strict=True):
        if not math.isfinite(value):
            raise FileError(f"{where}, column {column}: '{cell}' is not a time in s; correct it")
        if not first - SLACK_S <= value <= last + SLACK_S:
            raise FileError(
                f"{where}, column {column}: {value:g} s is outside '{recording.name}', which has "
                f"{first:g} to {last:g} s; correct it"
            )
    start, end = max(start, first), min(end, last)
    if end - start < (MIN_FRAMES - 1) / RATE:
        raise FileError(
            f"{where}: a reach from {start:g} to {end:g} s; end_s must be at least "
            f"{(MIN_FRAMES - 1) / RATE:g} s after start_s"
        )
    return Reach(recording.name, start, end, end, 1.0, BY_HAND)


def _check_apart(where: str, reach: Reach, others: Sequence[Reach]) -> None:
    for other in others:
        same = other.recording == reach.recording
        if same and reach.start_s < other.end_s and other.start_s < reach.end_s:
            raise FileError(
                f"{where}: {reach.start_s:g} to {reach.end_s:g} s overlaps the reach from "
                f"{other.start_s:g} to {other.end_s:g} s of '{reach.recording}'; keep one"
            )

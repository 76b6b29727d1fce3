"""Files of raw CyberGlove counts, frame by frame, in the order of the maker's sensors.

A file has a row a frame: 22 or 18 numbers from 0 to 255 (up to 4095 from gloves of 12 bits),
divided by blanks, tabs, commas or semicolons. Before them may stand one column of time (s, ms, us,
or a wall-clock stamp, also between quotes as in ``"12:30:01.250" 102 87 ...``) or two (date and
time, or a counter of frames and the time); behind them one constant column of status. A header is
not needed; if it names all sensors beyond doubt, columns are taken by their names, in any order.

The maker's order of 22 sensors is that of `handsim.joints.JOINTS`: thumb rotation, MCP, IP and
abduction; MCP, PIP and DIP of index and middle, abduction of the two; MCP, PIP, DIP and abduction
of ring and little finger; palm arch; wrist flexion and deviation. Gloves of 18 sensors have the
same without the four DIP.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from handsim.recordings.columns.clock import TIME_UNITS, clock_seconds, is_clock, unit_by_steps
from handsim.recordings.columns.column_map import place_of
from handsim.recordings.columns.guess import guess_map
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.posture_file import DIP_JOINTS
from handsim.types import Array
from handsim.wording import number_of

SENSORS: dict[int, tuple[str, ...]] = {
    N_JOINTS: JOINT_NAMES,
    N_JOINTS - len(DIP_JOINTS): tuple(name for name in JOINT_NAMES if name not in DIP_JOINTS),
}
"""Joints of the columns of gloves of 22 and of 18 sensors, in the maker's order."""
MAX_COUNT = 4095.0
_MOST_BEFORE = 2
_STATES = 16  # of the glove: its switch, its light


@dataclass(frozen=True)
class RawGlove:
    """Frames of a raw file.

    Attributes
    ----------
    table
        The file.
    time : (n,) [s], or None
        None where the file has no times.
    values : (n, 22)
        NaN where missing or where the glove has no sensor.
    places : 22
        Column of each joint in the file; None without a sensor.
    time_place
        Column of the time.
    notes
    """

    table: Table
    time: Array | None
    values: Array
    places: tuple[int | None, ...]
    time_place: int | None
    notes: tuple[str, ...]

    def cell(self, number: int, joint: int) -> str:
        """Return the text of a cell by the number of its row and its joint, -1 for the time."""
        place = self.places[joint] if joint >= 0 else self.time_place
        row = int(np.searchsorted(self.table.numbers, number))
        return "nan" if place is None else self.table.cells(row)[place]


def read_raw(path: Path) -> RawGlove:
    """Read a raw file.

    Raises
    ------
    FileError
        If it is missing, no table, or not of 18 or 22 sensors.
    """
    table = read_table(Path(path), header=False)
    if not len(table):
        raise FileError(f"{path}: holds no rows of values; check the file")
    if len(table.header) > len(table.cells(0)):  # names with blanks in a file divided by blanks
        raise FileError(
            f"{path}: row {table.header_line} names {len(table.header)} columns, row "
            f"{table.numbers[0]} has {len(table.cells(0))}; write names without blanks"
        )
    by_name = _places_by_name(table)
    if by_name is not None:
        places, before = by_name
        notes = ["columns taken by their names"]
    else:
        names, before = _places_by_order(table)
        places = [before + names.index(n) if n in names else None for n in JOINT_NAMES]
        notes = [f"columns taken in the maker's order of {len(names)} sensors"]
    known = [place for place in places if place is not None]
    values = np.full((len(table), N_JOINTS), np.nan)
    values[:, [place is not None for place in places]] = table.values(known)
    time, time_place, said = _times(table, before)
    return RawGlove(table, time, values, tuple(places), time_place, (*notes, *said))


def check_counts(raw: RawGlove) -> None:
    """Check that values are counts.

    Raises
    ------
    InputError
        If one is negative or greater than a sensor gives.
    """
    with np.errstate(invalid="ignore"):
        wrong = np.argwhere((raw.values < 0) | (raw.values > MAX_COUNT))
    if wrong.size:
        row, joint = (int(i) for i in wrong[0])
        raise InputError(
            f"{raw.table.path}: row {raw.table.numbers[row]}, {JOINT_NAMES[joint]}: "
            f"{raw.values[row, joint]:g} is no count from 0 to {MAX_COUNT:g}; if these are angles, "
            "give --units deg or rad"
        )


def _places_by_name(table: Table) -> tuple[list[int | None], int] | None:
    """Columns by the names of the header, and how many stand before; None if in doubt."""
    if not table.header:
        return None
    guess = guess_map(table, units="counts")
    if guess.doubts:
        return None
    found = {
        column.name: place_of(table, column.sensor, "the header")
        for column in guess.found.columns
        if column.sensor is not None and column.name in JOINT_INDEX
    }
    before = min(found.values())
    return [found.get(name) for name in JOINT_NAMES], min(before, _MOST_BEFORE)


def _places_by_order(table: Table) -> tuple[Sequence[str], int]:
    """Joints of the columns in the maker's order, and how many columns stand before them."""
    n = len(table.cells(0))
    for count, names in SENSORS.items():
        before = n - count
        if 0 <= before <= _MOST_BEFORE:
            if before and _is_status(table, before):
                before -= 1
            return names, before
    counts = " or ".join(map(str, sorted(SENSORS)))
    raise FileError(
        f"{table.path}: row {table.numbers[0]} has {number_of(n, 'column')}; a raw file has "
        f"{counts} sensors and at most 2 columns of time before them; import others with "
        "--format table"
    )


def _is_status(table: Table, before: int) -> bool:
    """Whether the last column is the glove's status, and one fewer stand before the sensors.

    It is constant and small, and what would be the last column of time does not rise.
    """
    values = table.values([before - 1, table.n_columns - 1])
    time, last = values[:, 0], values[:, 1]
    with np.errstate(over="ignore", invalid="ignore"):
        steps = np.diff(time)  # a sensor may rise, too, but rests on each count for a while
        rises = bool((steps >= 0).all()) and (steps > 0).mean() > 0.5 if steps.size else False
    constant = bool((last == last[0]).all()) and last[0] < _STATES
    return constant and not rises and not is_clock(table.cells(0)[before - 1])


def _times(table: Table, before: int) -> tuple[Array | None, int | None, list[str]]:
    """Return times [s], their column and what was decided about it."""
    if not before:
        return None, None, []
    first = table.cells(0)
    for place in range(before - 1, -1, -1):
        if is_clock(first[place]):
            dates = [first[0]] if place == 1 and not is_clock(first[0]) else []
            texts = table.texts(range(before))
            stamps = [" ".join(cells[:2]) if dates else cells[place] for cells in texts]
            time = clock_seconds(stamps)
            if dates and not np.isfinite(time).all():
                time = clock_seconds([cells[place] for cells in texts])
            return time, place, []
    values = table.values(range(before))
    place = before - 1  # behind a counter of frames
    with np.errstate(over="ignore", invalid="ignore"):
        unit = unit_by_steps(values[:, place]) or "s"
        time = values[:, place] * TIME_UNITS[unit]
    return time, place, [f"times taken as {unit} by their steps"]

"""A text table: its lines, and its columns as texts or as numbers."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.recordings.columns.cells import column_numbers
from handsim.types import Array, Index
from handsim.wording import number_of

QUOTED_COMMA = re.compile(r'"([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)"')
"""A number with a decimal comma between quotes."""
_NAMES = {"\t": "tab", ";": "semicolon", "|": "bar", ",": "comma", " ": "space"}
_QUOTED_OR_NOT = re.compile(r'"([^"]*)"|(\S+)')
_ROWS_AT_ONCE = 10_000


@dataclass(frozen=True, eq=False)
class Table:
    """A text table, its cells not yet turned into numbers.

    Attributes
    ----------
    path
    header
        Names of the columns without blanks around them; empty where the file has none.
    units
        The row of units under the header, or None.
    lines
        The lines of the body as they stand in the file.
    numbers
        Number of each of these lines in the file, from 1.
    header_line
        Number of the header's line; 0 without one.
    separator, decimal_comma
        How cells and decimals are divided.
    """

    path: Path
    header: tuple[str, ...]
    units: tuple[str, ...] | None
    lines: tuple[str, ...]
    numbers: Index
    header_line: int
    separator: str
    decimal_comma: bool

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.lines)

    @property
    def n_columns(self) -> int:
        """Number of columns, by the header or the first row."""
        return len(self.header) or len(self.cells(0))

    @property
    def found(self) -> str:
        """What was found about the layout, in words; empty for commas and decimal points."""
        said = [] if self.separator == "," else [f"separated by {_NAMES[self.separator]}"]
        return " and ".join([*said, *(["with decimal commas"] if self.decimal_comma else [])])

    def cells(self, row: int) -> list[str]:
        """Return the cells of a row, from 0, as they stand in the file."""
        return cells_of(self.lines[row], self.separator)

    def texts(self, columns: Sequence[int]) -> list[list[str]]:
        """Return the cells of some columns of every row.

        Raises
        ------
        FileError
            If a row has more or fewer cells than the header; the message names its line.
        """
        return [[cells[j].strip() for j in columns] for cells in map(self._whole, range(len(self)))]

    def values(self, columns: Sequence[int]) -> Array:
        """Return some columns as numbers, (n, len(columns)); NaN where a cell holds none.

        Raises
        ------
        FileError
            If a row has more or fewer cells than the header; the message names its line.
        """
        plain = self._plain
        if plain is None:
            rows = self.texts(columns)
            values = np.empty((len(self), len(columns)))
            for j in range(len(columns)):
                values[:, j] = column_numbers([cells[j] for cells in rows], self.decimal_comma)
            return values
        parts = [self._part(plain, start, columns) for start in range(0, len(self), _ROWS_AT_ONCE)]
        return np.vstack(parts) if parts else np.empty((0, len(columns)))

    def _part(self, plain: Sequence[str], start: int, columns: Sequence[int]) -> Array:
        """Return some columns of some rows: at once, or cell by cell if one is no number."""
        stop = min(start + _ROWS_AT_ONCE, len(self))
        lines = plain[start:stop]
        if columns and self._even(lines):
            try:
                values = np.loadtxt(
                    lines,
                    delimiter=None if self.separator == " " else self.separator,
                    comments=None,
                    ndmin=2,
                    dtype=float,
                    usecols=list(columns),
                )
                if values.shape == (stop - start, len(columns)):
                    return values
            except ValueError:
                pass
        rows = [self._whole(row) for row in range(start, stop)]
        values = np.empty((stop - start, len(columns)))
        for i, j in enumerate(columns):
            values[:, i] = column_numbers([cells[j].strip() for cells in rows], self.decimal_comma)
        return values

    def _even(self, lines: Sequence[str]) -> bool:
        """Whether all rows have as many cells as they must."""
        sign, n = self.separator, self.n_columns
        if sign == " ":
            return all(len(line.split()) == n for line in lines)
        return all(line.count(sign) == n - 1 for line in lines)

    def _whole(self, row: int) -> list[str]:
        """Return the cells of a row that has as many as it must; an empty one more is let go."""
        cells, n = split_cells(self.lines[row], self.separator), self.n_columns
        if len(cells) == n + 1 and not cells[-1].strip():
            return cells[:-1]
        if len(cells) != n:
            commas = self.separator == "," and len(cells) in (2 * n, 2 * n - 1)
            remedy = "separate cells by semicolons where commas are decimal signs"
            raise FileError(
                f"{self.path}: row {self.numbers[row]} has {number_of(len(cells), 'value')} for "
                f"{number_of(n, 'column')}; "
                f"{remedy if commas and n > 1 else 'complete it'}"
            )
        return cells

    @cached_property
    def _plain(self) -> list[str] | None:
        """The lines as NumPy's reader takes them; None where only cell by cell will do."""
        lines, sign = list(self.lines), self.separator
        if any('"' in line for line in lines):
            if sign == "," and self.decimal_comma:
                if any("." in line for line in lines):
                    return None
                lines = [QUOTED_COMMA.sub(r"\1.\2", line) for line in lines]
            lines = [line.replace('"', "") for line in lines]
        if sign != ",":
            if self.decimal_comma and any("." in line for line in lines):
                return None  # thousands, or points in one of the columns
            if not self.decimal_comma and any("," in line for line in lines):
                return None
            if self.decimal_comma:
                lines = [line.replace(",", ".") for line in lines]
        if sign != " ":
            lines = [_filled(line, sign) if sign + sign in line else line for line in lines]
        return lines


def cells_of(line: str, separator: str) -> list[str]:
    """Return the cells of a line, without blanks around them."""
    return [cell.strip() for cell in split_cells(line, separator)]


def split_cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line; quotes around them are taken off."""
    if separator == " ":
        if '"' not in line:
            return line.split()
        return [quoted or bare for quoted, bare in _QUOTED_OR_NOT.findall(line)]
    if '"' in line:
        try:
            return next(csv.reader([line], delimiter=separator))
        except (csv.Error, StopIteration):
            pass
    return line.split(separator)


def _filled(line: str, separator: str) -> str:
    """Return a line with ``nan`` in the empty cells between others."""
    return separator.join(cell if cell.strip() else "nan" for cell in line.split(separator))

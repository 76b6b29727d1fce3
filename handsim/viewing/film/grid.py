"""Movements side by side: rows of cells that leave no place empty.

Rows are as long as one another where the number allows it. Otherwise the last rows are shorter by
one, and their cells wider, so that all rows have the width of the picture.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.types import Frame

GAP = 2
"""White between cells [pixels]."""
MOST_PIXELS = 8192
"""Greatest width and height of a whole picture: encoders take no more."""
_WIDEST, _TALLEST, _WISHED = 4.2, 0.9, 16 / 9
"""Width over height of whole pictures: the most, the least, and what is aimed at."""


@dataclass(frozen=True)
class Grid:
    """Cells of one height in rows of one width.

    Attributes
    ----------
    rows
        Widths of the cells of each row [pixels].
    height
        Of each cell [pixels].
    """

    rows: tuple[tuple[int, ...], ...]
    height: int

    @classmethod
    def of(cls, n: int, width: int, height: int, columns: int | None = None) -> "Grid":
        """Lay out n cells of a size; those of shorter rows are wider.

        Parameters
        ----------
        n
        width, height
            Of a cell [pixels].
        columns
            Cells in the first row; by default so that the whole is about as wide as a screen.

        Raises
        ------
        InputError
            If there is no cell, or the whole picture were too large.
        """
        if n < 1:
            raise InputError("no movements to draw; give one or more")
        lengths = _by_rows(n, width / height) if columns is None else _by_columns(n, columns)
        whole = (_joined(max(lengths), width), _joined(len(lengths), height))
        if max(whole) > MOST_PIXELS:
            share = MOST_PIXELS / max(whole)
            raise InputError(
                f"{n} movements of {width}x{height} pixels make {whole[0]}x{whole[1]}; "
                f"{MOST_PIXELS} are the most, give a size of {int(share * width) // 2 * 2}x"
                f"{int(share * height) // 2 * 2} or less for each"
            )
        return cls(tuple(_shares(whole[0], length) for length in lengths), height)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole picture [pixels]."""
        first = self.rows[0]
        return sum(first) + GAP * (len(first) - 1), _joined(len(self.rows), self.height)

    @property
    def widths(self) -> list[int]:
        """Width of each cell, row after row [pixels]."""
        return [width for row in self.rows for width in row]

    def assemble(self, frames: Sequence[Frame]) -> Frame:
        """Set pictures side by side, row after row, each of the size of its cell."""
        width, height = self.size
        whole = np.full((height, width, 3), 255, np.uint8)
        cells = iter(frames)
        for i, row in enumerate(self.rows):
            top, left = i * (self.height + GAP), 0
            for each in row:
                whole[top : top + self.height, left : left + each] = next(cells)
                left += each + GAP
        return whole


def _by_rows(n: int, aspect: float) -> list[int]:
    """Choose the lengths of rows: equal ones before others, then the shape of a screen."""

    def shape(rows: int) -> float:
        return math.ceil(n / rows) * aspect / rows

    fitting = [rows for rows in range(1, n + 1) if _TALLEST <= shape(rows) <= _WIDEST]
    even = [rows for rows in fitting if n % rows == 0]
    rows = min(
        even or fitting or list(range(1, n + 1)),
        key=lambda each: abs(math.log(shape(each) / _WISHED)),
    )
    return [n // rows + (i < n % rows) for i in range(rows)]


def _by_columns(n: int, columns: int) -> list[int]:
    rows = math.ceil(n / columns)
    return [columns] * (rows - 1) + [n - columns * (rows - 1)]


def _joined(n: int, pixels: int) -> int:
    return n * pixels + (n - 1) * GAP


def _shares(width: int, n: int) -> tuple[int, ...]:
    """Divide a width among n cells and the gaps between them, to within a pixel."""
    edges = np.linspace(0, width - (n - 1) * GAP, n + 1).round().astype(int)
    return tuple(np.diff(edges).tolist())

"""Numbers as people write them: decimal commas, groups of thousands, a degree sign behind."""

import re
from collections.abc import Iterable, Sequence

import numpy as np

from handsim.types import Array

_GROUPED = {
    sign: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(group)}\d{{3}})+(?:{re.escape(sign)}\d*)?")
    for sign, group in ((".", ","), (",", "."))
}
_BLANKS = re.compile(r"(?<=\d)[ '\u2019\u00a0\u2009\u202f](?=\d{3}(?!\d))")
_TIDY = str.maketrans({"\u2212": "-", "\u00b0": None, "\u00ba": None})


def column_numbers(cells: Sequence[str], decimal_comma: bool) -> Array:
    """Return the numbers of a column, (n,); NaN where a cell holds none.

    The sign that is not the decimal sign of the file groups thousands if every cell that has it is
    such a group and the column shows that it is one: some cells are too small to need it, or have
    decimals besides. Otherwise it is the decimal sign of this column.

    Parameters
    ----------
    cells : (n,)
    decimal_comma
        Whether the file as a whole has decimal commas.
    """
    if not decimal_comma or not any("." in cell for cell in cells):
        try:
            return np.array(cells, dtype=float)
        except ValueError:
            pass
    tidy = [_BLANKS.sub("", cell.translate(_TIDY)).strip() for cell in cells]
    sign, other = (",", ".") if decimal_comma else (".", ",")
    if any(other in cell for cell in tidy):
        if _groups(tidy, sign, other):
            tidy = [cell.replace(other, "") for cell in tidy]
        else:
            sign = other if not any(sign in cell for cell in tidy) else sign
    return np.array([_number(cell.replace(sign, ".")) for cell in tidy], dtype=float)


def _groups(cells: Iterable[str], sign: str, other: str) -> bool:
    """Whether a sign divides thousands in a column."""
    shown = False
    for cell in cells:
        if other not in cell:
            shown = shown or any(map(str.isdigit, cell))
        elif not _GROUPED[sign].fullmatch(cell):
            return False
        else:
            shown = shown or sign in cell or cell.count(other) > 1
    return shown


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan

"""Text tables as spreadsheets and loggers of any country write them.

Found by themselves: the encoding (UTF-8, UTF-16 with its mark or without, Windows-1252), the
separator, decimal commas and groups of thousands (`handsim.recordings.columns.cells`), comment
lines, lines about the recording above the table, empty lines, quotes, and a row of units under the
header. A header may stand in the last comment line. Lines are counted as a text editor counts them,
so that a message names the line that has to be mended.
"""

import codecs
import re
from collections import Counter
from pathlib import Path

import numpy as np

from handsim.disk import naming
from handsim.errors import FileError
from handsim.files import is_file
from handsim.recordings.columns.text_table import Table, cells_of, split_cells

MAX_TABLE_BYTES = 512 * 1024**2
"""Size above which a table is refused; ten minutes of 22 angles at 1 kHz take 150 MB."""
COMMENTS = ("#", "%", "//")
_SEPARATORS = ("\t", ";", "|", ",", " ")
_LOOKED_AT = 60  # lines from which the separator is found
_UNITS = frozenset(
    {"", "s", "sec", "ms", "us", "hz", "deg", "degree", "degrees", "°", "rad", "count", "counts"}
    | {"raw", "m", "cm", "mm", "n", "v", "mv", "uv", "-", "1", "grad", "º", "radians", "seconds"}
    | {"milliseconds", "adc", "g", "m/s^2", "deg/s"}
)
_EMPTY = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--", "#n/a", "missing"})
_QUOTED = re.compile(r'"[^"]*"')
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_NUMBER = re.compile(
    r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE
)


def is_missing(cell: str) -> bool:
    """Whether a cell says in one of the usual ways that there is no value."""
    return cell.strip().lower() in _EMPTY


def read_table(path: Path, *, header: bool = True, words: bool = False) -> Table:
    """Read a text table.

    Parameters
    ----------
    path
    header
        Whether the table must have a row of names.
    words
        Whether its cells are words, so that the first row is that of names.

    Raises
    ------
    FileError
        If the file is missing, too large, a workbook, no text or empty, or has no row of names.
    """
    path = Path(path)
    text = _decoded(path)
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    lines = text.split("\n")
    kept = [(i, line) for i, line in enumerate(lines, start=1) if _is_content(line)]
    if not kept:
        raise FileError(f"{path}: is empty; its first row must name the columns")
    # Words may hold any sign; the names of their columns hold none that divides.
    separator = _separator([line for _, line in (kept[:1] if words else kept)])
    first = 1 if words else _first_row(kept, separator)
    names, units, header_line = _header(kept[:first], separator)
    if not names and first < len(kept):
        names, header_line = _commented_header(lines, kept[first], separator)
    if header and not names:
        raise FileError(
            f"{path}: row {kept[0][0]} holds no names of columns; give a header as the first row"
        )
    body = [line for _, line in kept[first:]]
    return Table(
        path=path,
        header=names,
        units=units,
        lines=tuple(body),
        numbers=np.array([i for i, _ in kept[first:]], dtype=np.int64),
        header_line=header_line,
        separator=separator,
        decimal_comma=_has_decimal_comma(body, separator),
    )


def _decoded(path: Path) -> str:
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    with naming(path, "read"):
        size = path.stat().st_size
        if size > MAX_TABLE_BYTES:
            raise FileError(f"{path}: {size} bytes, more than {MAX_TABLE_BYTES}; split it")
        data = path.read_bytes()
    if data[:4] == b"PK\x03\x04" or data[:4] == b"\xd0\xcf\x11\xe0":
        raise FileError(f"{path}: is a workbook or an archive, not text; export the sheet as CSV")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ("utf-16",)
    elif b"\0" in data[:200]:  # the high halves of what Latin letters are in UTF-16
        encodings = ("utf-16-le",) if data[1:2] == b"\0" else ("utf-16-be",)
    else:
        encodings = ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise FileError(f"{path}: cannot be read as text; export it again as CSV in UTF-8")


def _is_content(line: str) -> bool:
    stripped = line.strip(" \t;,|\r\n\ufeff")
    return bool(stripped) and not stripped.startswith(COMMENTS)


def _separator(lines: list[str]) -> str:
    """Return what divides the last of the lines looked at most evenly.

    The last lines, because texts about the recording stand before the table. A comma may be a
    decimal sign, so that what cannot be one comes first. What is quoted divides nothing.
    """
    looked_at = [_QUOTED.sub("", line) for line in lines[: _LOOKED_AT + 1][-_LOOKED_AT // 2 :]]
    best, most = ",", 0.0
    for separator in _SEPARATORS:
        counts = Counter(len(split_cells(line, separator)) for line in looked_at)
        count, times = counts.most_common(1)[0]
        even = times / len(looked_at)
        if count > 1 and even > most + 0.2:
            best, most = separator, even
    return best


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.fullmatch(cell.strip())) or is_missing(cell)


def _first_row(kept: list[tuple[int, str]], separator: str) -> int:
    """Return the place of the first row of values.

    It is the first of which most cells are numbers, and at least one is no missing value. It has
    more than half as many cells as most rows: texts about the recording have numbers, too.
    """
    looked_at = [line for _, line in kept[: _LOOKED_AT + 1]]
    usual = Counter(len(split_cells(line, separator)) for line in looked_at).most_common(1)[0][0]
    for i, line in enumerate(looked_at):
        cells = cells_of(line, separator)
        numbers = sum(map(_is_number, cells))
        real = sum(bool(_NUMBER.fullmatch(cell.strip())) for cell in cells)
        if numbers > len(cells) / 2 and real and len(cells) > max(1, usual / 2):
            return i
    return 1


def _commented_header(
    lines: list[str], first: tuple[int, str], separator: str
) -> tuple[tuple[str, ...], int]:
    """Return the names in the last comment line above the first row, as NumPy writes them."""
    number, row = first
    for i in range(number - 1, max(0, number - _LOOKED_AT), -1):
        line = lines[i - 1].strip().lstrip("\ufeff")
        if line.startswith(COMMENTS):
            names = cells_of(line.lstrip("#%/ \t"), separator)
            if len(names) == len(cells_of(row, separator)) and not any(map(_is_number, names)):
                return tuple(names), i
            return (), 0
    return (), 0


def _header(
    above: list[tuple[int, str]], separator: str
) -> tuple[tuple[str, ...], tuple[str, ...] | None, int]:
    """Return names, units and the line of the names from the lines above the first row."""
    if not above:
        return (), None, 0
    number, line = above[-1]
    last = cells_of(line, separator)
    if len(above) > 1 and any(last) and all(map(_is_unit, last)):
        number, line = above[-2]
        return tuple(cells_of(line, separator)), tuple(last), number
    return tuple(last), None, number


def _is_unit(cell: str) -> bool:
    return cell.strip("[]() ").lower() in _UNITS


def _has_decimal_comma(lines: list[str], separator: str) -> bool:
    """Whether decimals are divided by commas, by the first lines that show it."""
    if separator == ",":
        showing = [line for line in lines if '"' in line]
    else:
        showing = [line for line in lines if "," in line or "." in line]
    cells = [cell for line in showing[:_LOOKED_AT] for cell in cells_of(line, separator)]
    commas = sum(bool(_DECIMAL_COMMA.fullmatch(cell)) for cell in cells)
    return commas > sum("." in cell and _is_number(cell) for cell in cells)

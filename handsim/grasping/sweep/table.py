"""The table that a sweep fills: rows come in as they are done, and none is lost or written twice.

It is a CSV file whose first column says of which sweep a row is and whose second numbers the run.
Each row is appended as it is done. Whatever ends the work, the file holds whole lines and at most
one that was cut off, which is dropped when the work goes on. Once all are there they are put in
order, so that the file does not tell how often it was interrupted.
"""

import csv
import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from handsim.disk import naming
from handsim.errors import FileError
from handsim.files import check_target, write_text

KEYS = ("sweep", "run")
"""Columns that stand before those of the rows."""
MAX_LINE = 64 * 1024
"""Longer lines are none of ours [bytes]."""


class ResultsTable:
    """An open results table; see `open_table`."""

    def __init__(self, path: Path, sweep: str, columns: Sequence[str], n_runs: int) -> None:
        self.path = path
        self.sweep = sweep
        self.n_runs = n_runs
        self.header = _line([*KEYS, *columns])
        self._lines: dict[int, str] = {}
        self._stream: BinaryIO | None = None

    def __contains__(self, number: int) -> bool:
        """Whether the row of a run is there."""
        return number in self._lines

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self._lines)

    def rows(self) -> Iterator[dict[str, str]]:
        """Return the rows in order, as text by column."""
        text = (self.header, *(self._lines[number] for number in sorted(self._lines)))
        yield from csv.DictReader(text)

    def add(self, number: int, values: Sequence[Any]) -> None:
        """Append the row of a run; it is on the disk when this returns."""
        if number in self._lines:
            return
        line = _line([self.sweep, number, *values])
        self._append(line)
        self._lines[number] = line

    def complete(self) -> None:
        """Put the rows in order if all are there; the file is replaced as a whole."""
        in_order = list(self._lines) == sorted(self._lines)
        if len(self._lines) < self.n_runs or in_order:
            return
        ordered = (self._lines[number] for number in sorted(self._lines))
        write_text(self.path, self.header + "".join(ordered))

    def read(self, stream: BinaryIO) -> None:
        """Read what is there, drop a line that was cut off, and go on after it."""
        self._stream = stream
        end = 0
        while line := stream.readline(MAX_LINE):
            if not line.endswith(b"\n"):
                self._check_torn(line, first=end == 0)
                stream.truncate(end)
                break
            self._take(line, first=end == 0)
            end += len(line)
        if end == 0:
            self._append(self.header)

    def _append(self, line: str) -> None:
        """Write a line to the end of the file, or nothing of it."""
        assert self._stream is not None
        file = self._stream.fileno()
        before, rest = os.fstat(file).st_size, line.encode()
        with naming(self.path):
            try:
                while rest:  # without a buffer, which would be tried again as the file is closed
                    rest = rest[os.write(file, rest) :]
                os.fsync(file)
            except OSError:
                os.ftruncate(file, before)
                raise

    def _check_torn(self, line: bytes, *, first: bool) -> None:
        if len(line) == MAX_LINE or (first and not self.header.encode().startswith(line)):
            raise self._foreign()

    def _take(self, line: bytes, *, first: bool) -> None:
        """Keep the line of a row, if it is one of this sweep."""
        if first:
            if line != self.header.encode():
                raise self._foreign()
            return
        try:
            text = line.decode()
            values = next(csv.reader([text], strict=True))
            number = int(values[1])
        except (UnicodeDecodeError, csv.Error, ValueError, IndexError, StopIteration) as error:
            raise self._damaged(len(self) + 2) from error
        if values[0] != self.sweep:
            raise FileError(
                f"{self.path}: holds rows of another sweep; the TOML file, a controller or a "
                "version is another now: choose another output, or delete it"
            )
        complete = len(values) == len(next(csv.reader([self.header])))
        if not (complete and 0 <= number < self.n_runs and number not in self):
            raise self._damaged(len(self) + 2)
        self._lines[number] = text

    def _foreign(self) -> FileError:
        return FileError(f"{self.path}: is not a table of a sweep; choose another output")

    def _damaged(self, row: int) -> FileError:
        return FileError(f"{self.path}: row {row} is not as it was written; delete that line")


@contextmanager
def open_table(
    path: Path, sweep: str, columns: Sequence[str], n_runs: int
) -> Iterator[ResultsTable]:
    """Open a results table to go on with it; it appears if it is not there.

    Parameters
    ----------
    path
    sweep
        What distinguishes this sweep from all others.
    columns
        Names of the values of a row.
    n_runs
        Number of rows when it is complete.

    Raises
    ------
    FileError
        If it cannot be written, is no such table, holds rows of another sweep or damaged ones, or
        another sweep is writing to it.
    """
    check_target(path)
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise FileError(f"{path}: is not a plain file; give the name of one")
    table = ResultsTable(path, sweep, columns, n_runs)
    with _locked(path) as stream:
        table.read(stream)
        yield table


@contextmanager
def _locked(path: Path) -> Iterator[BinaryIO]:
    """Open a file to read and append, for this process alone for as long as it is open."""
    while True:
        # The lock goes with the process, however it ends, and its children do not have it.
        with naming(path):
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        stream = os.fdopen(file, "r+b")
        with stream:
            _lock(stream, path)
            if path.exists() and os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                yield stream
                return
        # Another sweep had it and has just put a complete table in its place.


def _lock(stream: BinaryIO, path: Path) -> None:
    try:
        import fcntl
    except ImportError:  # Windows: nobody watches there
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise FileError(
            f"{path}: another sweep is writing to it; wait for it, or choose another output"
        ) from error


def _line(values: Sequence[Any]) -> str:
    """Return values as one line of CSV; numbers with six digits."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(
        f"{value:.6g}" if isinstance(value, float) else value for value in values
    )
    return text.getvalue()

"""The table of results of a sweep: a CSV file that can be continued after any interruption.

The first column is the key of the sweep, the second the number of the run. Each row is appended as
soon as its run is done. However the work ends, the file holds whole lines and at most one that was
cut off, which is dropped when the work goes on. When all rows are there they are sorted, so that
an interrupted sweep gives the same file as an undisturbed one.
"""

import csv
import io
import os
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from handsim.disk import naming
from handsim.errors import FileError
from handsim.files import check_target, write_text

KEYS = ("sweep", "run")
"""Columns before those of the results."""
MAX_LINE = 64 * 1024
"""Longest line of a table [bytes]; a file with longer ones is refused."""


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
        """Whether the table has the row of a run."""
        return number in self._lines

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self._lines)

    def rows(self) -> Iterator[dict[str, str]]:
        """Return the rows in order, as text by column."""
        text = (self.header, *(self._lines[number] for number in sorted(self._lines)))
        yield from csv.DictReader(text)

    def add(self, number: int, values: Sequence[Any]) -> None:
        """Append the row of a run; when this returns, it is on the disk."""
        if number in self._lines:
            return
        line = _line([self.sweep, number, *values])
        self._append(line)
        self._lines[number] = line

    def complete(self) -> None:
        """Sort the rows if all are there; the file is replaced as a whole."""
        in_order = list(self._lines) == sorted(self._lines)
        if len(self._lines) < self.n_runs or in_order:
            return
        ordered = (self._lines[number] for number in sorted(self._lines))
        write_text(self.path, self.header + "".join(ordered))

    def read(self, stream: BinaryIO) -> None:
        """Read the rows of a file, drop a line that was cut off, and append after it."""
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
        """Append a line to the file; where that fails, nothing of it stays there."""
        assert self._stream is not None
        file = self._stream.fileno()
        before, rest = os.fstat(file).st_size, line.encode()
        with naming(self.path):
            try:
                while (
                    rest
                ):  # without a buffer, which would be written again when the file is closed
                    rest = rest[os.write(file, rest) :]
                os.fsync(file)
            except OSError:
                os.ftruncate(file, before)
                raise

    def _check_torn(self, line: bytes, *, first: bool) -> None:
        if len(line) == MAX_LINE or (first and not self.header.encode().startswith(line)):
            raise self._foreign()

    def _take(self, line: bytes, *, first: bool) -> None:
        """Take the line of a row, if it belongs to this sweep."""
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
) -> Generator[ResultsTable, None, None]:
    """Open a results table to append to it; it is made if it does not exist.

    Parameters
    ----------
    path
    sweep
        Key of the sweep, which no other sweep has.
    columns
        Names of the values of a row.
    n_runs
        Number of rows when it is complete.

    Raises
    ------
    FileError
        If it cannot be written, is no such table, holds damaged rows or those of another sweep, or
        if another sweep is writing to it.
    """
    check_target(path)
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise FileError(f"{path}: is not a plain file; give the name of one")
    table = ResultsTable(path, sweep, columns, n_runs)
    with _locked(path) as stream:
        table.read(stream)
        yield table


@contextmanager
def _locked(path: Path) -> Generator[BinaryIO, None, None]:
    """Open a file to read and append, locked by this process as long as it is open."""
    while True:
        # The lock ends with this process, however it ends; child processes do not inherit it.
        with naming(path):
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        stream = os.fdopen(file, "r+b")
        with stream:
            _lock(stream, path)
            if path.exists() and os.path.samestat(os.fstat(stream.fileno()), path.stat()):
                yield stream
                return
        # Another sweep had the lock and has just replaced the file by its sorted table.


def _lock(stream: BinaryIO, path: Path) -> None:
    try:
        import fcntl
    except ImportError:  # Windows has no such locks
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

"""CSV files that hold recordings of reach-to-grasp movements.

A folder of recordings is one CSV file a recording (`time_s`, then the 22 joint names with `_deg`)
and `experiments.csv`, which says what each file shows. Angles are degrees in files and radians
everywhere else.
"""

import csv
import io
import shutil
import tempfile
from pathlib import Path

import numpy as np

from handsim.disk import naming
from handsim.errors import FileError, InputError
from handsim.files import read_text, write_text
from handsim.joints import JOINT_NAMES
from handsim.recordings.recording import Recording, RecordingSet, check_frames, check_postures
from handsim.types import Array, HandSize

INDEX_FILE = "experiments.csv"
_POSTURE_COLUMNS = ("time_s", *(f"{name}_deg" for name in JOINT_NAMES))
_INDEX_COLUMNS = ("file", "number", "subject", "object", "task", "hand_length_m", "hand_breadth_m")


def read_postures(path: Path) -> tuple[Array, Array]:
    """Read a sequence of postures from one CSV file.

    Returns
    -------
    time : (n,) [s]
    q : (n, 22) [rad]

    Raises
    ------
    FileError
        If the file is missing or empty, a column is missing, extra or twice, a value is no finite
        number, an angle is beyond +-180 deg, time does not increase, or there are fewer than 10
        frames. The message names file, row (the header is row 1) and column.
    """
    path = Path(path)
    header, rows = _read_table(path, _POSTURE_COLUMNS)
    order = [header.index(column) for column in _POSTURE_COLUMNS]
    table = np.empty((len(rows), len(order)))
    for i, row in enumerate(rows):
        for j, source in enumerate(order):
            try:
                table[i, j] = float(row[source])
            except ValueError:
                table[i, j] = np.nan
            if not np.isfinite(table[i, j]):
                raise FileError(
                    f"{path}: row {i + 2}, column {_POSTURE_COLUMNS[j]}: '{row[source]}' is not a "
                    "finite number; correct or remove the row"
                )
    time, angles = table[:, 0], table[:, 1:]
    check_frames(str(path), time, angles, first_row=2)
    return time, np.deg2rad(angles)


def write_postures(path: Path, time: Array, q: Array) -> None:
    """Write a sequence of postures to one CSV file.

    Parameters
    ----------
    time : (n,) [s]
    q : (n, 22) [rad], written in degrees with 6 decimals (2e-8 rad)
    """
    check_postures(str(path), np.asarray(time, dtype=float), np.asarray(q, dtype=float))
    write_text(Path(path), _postures_text(time, q))


def read_recordings(folder: Path) -> RecordingSet:
    """Read a folder of recordings.

    Raises
    ------
    FileError
        If the folder or its ``experiments.csv`` is missing or empty, names a file that is not
        there, or any file is not what `read_postures` accepts.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(f"{folder}: no such folder; check the path")
    index = folder / INDEX_FILE
    if not index.is_file():
        raise FileError(f"{folder}: holds no {INDEX_FILE}; it is no folder of recordings")
    header, rows = _read_table(index, _INDEX_COLUMNS)
    if not rows:
        raise FileError(f"{index}: lists no recording; give at least 1 row")
    recordings: list[Recording] = []
    for i, row in enumerate(rows):
        values = dict(zip(header, row, strict=True))
        recordings.append(_recording_of_row(folder, f"{index}: row {i + 2}", values))
    try:
        return RecordingSet(tuple(recordings))
    except InputError as error:
        raise FileError(f"{index}: {error}") from error


def write_recordings(recordings: RecordingSet, folder: Path) -> None:
    """Write a folder of recordings, as a whole or not at all.

    The folder is written under a temporary name and renamed; one that was there is replaced.

    Raises
    ------
    FileError
        If the parent folder is missing, or ``folder`` exists and holds anything but recordings.
    """
    folder = Path(folder)
    if not folder.parent.is_dir():
        raise FileError(f"{folder}: folder '{folder.parent}' does not exist; create it first")
    if folder.exists():
        _check_replaceable(folder)
    with naming(folder):
        scratch = Path(tempfile.mkdtemp(prefix=".", dir=folder.parent))
    try:
        with naming(folder, scratch=scratch):
            fresh = scratch / "new"
            fresh.mkdir()
            for recording in recordings:
                text = _postures_text(recording.time, recording.q)
                (fresh / f"{recording.name}.csv").write_text(text, encoding="utf-8")
            (fresh / INDEX_FILE).write_text(_index_text(recordings), encoding="utf-8")
            _swap(fresh, folder, scratch / "old")
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _swap(fresh: Path, folder: Path, aside: Path) -> None:
    replaced = folder.exists()
    if replaced:
        folder.rename(aside)
    try:
        fresh.rename(folder)
    except OSError:
        if replaced:
            aside.rename(folder)
        raise


def _check_replaceable(folder: Path) -> None:
    if not folder.is_dir():
        raise FileError(f"{folder}: is a file; give the name of a folder")
    others = [entry.name for entry in folder.iterdir() if entry.suffix != ".csv"]
    if others or (any(folder.iterdir()) and not (folder / INDEX_FILE).is_file()):
        culprit = others[0] if others else next(folder.iterdir()).name
        raise FileError(
            f"{folder}: holds '{culprit}', which is no recording; choose a new or empty folder"
        )


def _recording_of_row(folder: Path, where: str, values: dict[str, str]) -> Recording:
    file = values["file"]
    if Path(file).name != file or not file.endswith(".csv") or file == INDEX_FILE:
        raise FileError(f"{where}, column file: '{file}' must name a .csv file in the same folder")
    numbers: dict[str, float] = {}
    for column in ("number", "hand_length_m", "hand_breadth_m"):
        try:
            numbers[column] = int(values[column]) if column == "number" else float(values[column])
        except ValueError:
            raise FileError(
                f"{where}, column {column}: '{values[column]}' is not a number; correct it"
            ) from None
    time, q = read_postures(folder / file)
    try:
        return Recording(
            name=file.removesuffix(".csv"),
            time=time,
            q=q,
            number=int(numbers["number"]),
            subject=values["subject"],
            object=values["object"],
            task=values["task"],
            hand=HandSize(numbers["hand_length_m"], numbers["hand_breadth_m"]),
        )
    except InputError as error:
        raise FileError(f"{where}: {error}") from error


def _read_table(path: Path, columns: tuple[str, ...]) -> tuple[list[str], list[list[str]]]:
    try:
        rows = [row for row in csv.reader(io.StringIO(read_text(path))) if row]
    except csv.Error as error:
        raise FileError(f"{path}: not a CSV file ({error}); export it again") from error
    if not rows:
        raise FileError(f"{path}: is empty; its first row must name the columns")
    header = [cell.strip() for cell in rows[0]]
    for column in columns:
        if header.count(column) != 1:
            found = "twice" if column in header else "missing"
            raise FileError(f"{path}: row 1: column {column} is {found}; name each column once")
    extra = next((column for column in header if column not in columns), None)
    if extra is not None:
        raise FileError(f"{path}: row 1: column {extra} is not expected; remove it")
    for i, row in enumerate(rows[1:]):
        if len(row) != len(header):
            raise FileError(
                f"{path}: row {i + 2} has {len(row)} values for {len(header)} columns; complete it"
            )
    return header, [[cell.strip() for cell in row] for row in rows[1:]]


def _postures_text(time: Array, q: Array) -> str:
    lines = [",".join(_POSTURE_COLUMNS)]
    # + 0.0 turns -0.0 into 0.0, so that equal postures are equal text.
    for t, angles in zip(time, np.round(np.rad2deg(q), 6) + 0.0, strict=True):
        lines.append(",".join([f"{t:.6f}", *(f"{angle:.6f}" for angle in angles)]))
    return "\n".join(lines) + "\n"


def _index_text(recordings: RecordingSet) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(_INDEX_COLUMNS)
    for r in recordings:
        sizes = (f"{r.hand.length:.6g}", f"{r.hand.breadth:.6g}")
        writer.writerow([f"{r.name}.csv", r.number, r.subject, r.object, r.task, *sizes])
    return stream.getvalue()

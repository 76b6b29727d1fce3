"""Folders of recordings: a CSV file each, and ``experiments.csv``, which says what they show.

`handsim.recordings.posture_file` says what a file of a recording holds. ``experiments.csv`` has the
columns of `INDEX_COLUMNS`; further ones are kept. Those of `SAID_COLUMNS` may be missing, as they
are in folders of earlier versions: the hand is then a right one.
"""

import csv
import io
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.files import check_output_folder, replacing_folder
from handsim.recordings.delimited import read_table
from handsim.recordings.gaps import bridge_joints
from handsim.recordings.posture_file import (
    checked_postures,
    postures_text,
    read_posture_table,
)
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.sides import on_one_side
from handsim.types import HandSize, Progress, Side

INDEX_FILE = "experiments.csv"
INDEX_COLUMNS = (
    *("file", "number", "subject", "object", "task", "hand_length_m", "hand_breadth_m"),
)
"""Columns of ``experiments.csv`` that have to be there."""
SAID_COLUMNS = ("side", "session", "notes")
"""Columns that are read where they are there; ``side`` is always written."""
SIDE_WORDS: dict[str, Side] = {"right": "right", "r": "right", "left": "left", "l": "left"}
"""What a cell may call a side, in small letters."""
SIDE_COLUMNS = ("side", "handedness", "hand", "hand_side")
"""Columns that may say the side; only the first of them must."""


def read_recordings(
    folder: Path,
    progress: Progress | None = None,
    *,
    bridge_s: float = 0.0,
    side: Side | None = None,
    radians: bool = False,
) -> RecordingSet:
    """Read a folder of recordings.

    Left hands whose abductions have the signs of a right hand's glove are mirrored, and their notes
    say so.

    Parameters
    ----------
    folder
    progress
        Called with the fraction done.
    bridge_s
        Longest gap between two values of a sensor that is bridged [s].
    side
        Of all recordings, instead of what ``experiments.csv`` says.
    radians
        Whether the files hold radians, whatever their headers say.

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
    table = read_table(index, words=True)
    for column in dict.fromkeys((*INDEX_COLUMNS, *table.header)):
        if table.header.count(column) != 1:
            found = "twice" if column in table.header else "missing"
            where = f"{index}: row {table.header_line}: column {column} is {found}"
            raise FileError(f"{where}; name each column once")
    if not len(table):
        raise FileError(f"{index}: lists no recording; give at least 1 row")
    recordings: list[Recording] = []
    for i, cells in enumerate(table.texts(range(table.n_columns))):
        values = dict(zip(table.header, cells, strict=True))
        where = f"{index}: row {table.numbers[i]}"
        if side is not None:
            values["side"] = side
        recordings.append(_recording_of_row(folder, where, values, bridge_s, radians))
        if progress is not None:
            progress((i + 1) / len(table))
    return on_one_side(recordings, str(index))


def stored_notes(folder: Path) -> frozenset[str]:
    """Return the notes that a folder of recordings holds, without what reading it adds."""
    table = read_table(Path(folder) / INDEX_FILE, words=True)
    if "notes" not in table.header:
        return frozenset()
    cells = table.texts([table.header.index("notes")])
    return frozenset(note for (cell,) in cells for note in _notes_in(cell))


def write_recordings(recordings: RecordingSet, folder: Path) -> None:
    """Write a folder of recordings, as a whole or not at all.

    The folder is written under a temporary name and renamed; one that was there is replaced.

    Raises
    ------
    FileError
        If the parent folder is missing, or ``folder`` exists and holds anything but recordings.
    """
    folder = Path(folder)
    check_folder_target(folder)
    with replacing_folder(folder) as fresh:
        for recording in recordings:
            text = postures_text(recording.time, recording.q, recording.channels)
            (fresh / f"{recording.name}.csv").write_text(text, encoding="utf-8")
        (fresh / INDEX_FILE).write_text(_index_text(recordings), encoding="utf-8")


def check_folder_target(folder: Path) -> None:
    """Check that recordings could be written to a folder, before any work is done for them.

    Raises
    ------
    FileError
        As `write_recordings`.
    """
    if not folder.parent.is_dir():
        raise FileError(f"{folder}: folder '{folder.parent}' does not exist; create it first")
    check_output_folder(folder.parent)  # where it is written under another name, and renamed
    if folder.exists():
        _check_replaceable(folder)


def _check_replaceable(folder: Path) -> None:
    if not folder.is_dir():
        raise FileError(f"{folder}: is a file; give the name of a folder")
    others = [entry.name for entry in folder.iterdir() if entry.suffix != ".csv"]
    if others or (any(folder.iterdir()) and not (folder / INDEX_FILE).is_file()):
        culprit = others[0] if others else next(folder.iterdir()).name
        raise FileError(
            f"{folder}: holds '{culprit}', which is no recording; choose a new or empty folder"
        )


def _recording_of_row(
    folder: Path, where: str, values: Mapping[str, str], bridge_s: float, radians: bool
) -> Recording:
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
    content = read_posture_table(folder / file)
    if radians:
        content = replace(content, angles=np.rad2deg(content.angles))
    angles, bridged = bridge_joints(content.time, content.angles, bridge_s)
    time, q = checked_postures(replace(content, angles=angles))
    side, said = _side(where, values)
    notes = _notes_in(values.get("notes", ""))
    further = [each for each in (*content.notes, *bridged, *said) if each not in notes]
    known = (*INDEX_COLUMNS, *SAID_COLUMNS)
    try:
        return Recording(
            name=file.removesuffix(".csv"),
            time=time,
            q=q,
            number=int(numbers["number"]),
            subject=values["subject"],
            object=values["object"],
            task=values["task"],
            hand=HandSize(numbers["hand_length_m"], numbers["hand_breadth_m"], side),
            session=values.get("session", ""),
            channels=content.channels,
            extra={name: value for name, value in values.items() if name not in known},
            notes=(*notes, *further),
        )
    except InputError as error:
        raise FileError(f"{where}: {error}") from error


def _notes_in(cell: str) -> list[str]:
    return [note for note in cell.split("; ") if note]


def _side(where: str, values: Mapping[str, str]) -> tuple[Side, list[str]]:
    """Return the side of a row, and what to say where another column was taken for it."""
    column = next((name for name in SIDE_COLUMNS if name in values), None)
    if column is None or not values[column]:
        return "right", []
    side = SIDE_WORDS.get(values[column].lower())
    if column != "side":
        return (side, [f"side {side} by column {column}"]) if side else ("right", [])
    if side is None:
        raise FileError(f"{where}, column side: '{values[column]}' is neither right nor left")
    return side, []


def _index_text(recordings: RecordingSet) -> str:
    """Return ``experiments.csv``; ``session`` and ``notes`` only where there are any."""
    told = [
        {
            "side": r.hand.side,
            "session": r.session,
            "notes": "; ".join(n.replace(";", ",") for n in r.notes),
        }
        for r in recordings
    ]
    said = [name for name in SAID_COLUMNS if name == "side" or any(each[name] for each in told)]
    extra = list(dict.fromkeys(name for r in recordings for name in r.extra))
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*INDEX_COLUMNS, *said, *extra])
    for r, of_recording in zip(recordings, told, strict=True):
        sizes = (f"{r.hand.length:.6g}", f"{r.hand.breadth:.6g}")
        row = [f"{r.name}.csv", r.number, r.subject, r.object, r.task, *sizes]
        row += [of_recording[name] for name in said]
        writer.writerow([*row, *(r.extra.get(name, "") for name in extra)])
    return stream.getvalue()

"""Who did what in which file: by ``experiments.csv`` beside the files, and by options."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from handsim.disk import naming
from handsim.errors import FileError
from handsim.files import is_file
from handsim.recordings.columns.frames import Labels
from handsim.recordings.delimited import read_table
from handsim.recordings.folder import (
    INDEX_COLUMNS,
    INDEX_FILE,
    SAID_COLUMNS,
    SIDE_COLUMNS,
    SIDE_WORDS,
)
from handsim.recordings.importers.layout import UNKNOWN_HAND, ImportOptions
from handsim.types import HandSize

_SUFFIXES = frozenset({".csv", ".tsv", ".txt", ".dat", ".tab", ".asc", ".log"})
_NO_NAME = re.compile(r"[^\w.+-]+")


def listed_files(files: Sequence[Path]) -> Iterator[tuple[Path, dict[str, str]]]:
    """Yield files, folders and ``experiments.csv`` replaced by theirs, with what is said of each.

    Raises
    ------
    FileError
        If there is none, one is missing, or an ``experiments.csv`` is damaged.
    """
    said: dict[Path, dict[str, dict[str, str]]] = {}
    found: list[Path] = []
    for file in files:
        folder = file.parent if file.name == INDEX_FILE else file
        if not _is_folder(folder) or (file.name != INDEX_FILE and folder is not file):
            found.append(file)
            continue
        said[folder] = _index(folder)
        with naming(folder, "read"):
            inside = sorted(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)
        listed = [folder / name for name in said[folder]]
        others = [path for path in inside if path.name.lower() not in (INDEX_FILE, "readme.txt")]
        found += listed or others
        if not (listed or others):
            raise FileError(f"{folder}: holds no table; name the files themselves")
    named = {file.parent for file in files if file.name == INDEX_FILE}
    for path in dict.fromkeys(found):
        if path.parent in named and path.name == INDEX_FILE:
            continue
        if path.parent not in said:
            said[path.parent] = _index(path.parent)
        yield path, said[path.parent].get(path.name, {})


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def _index(folder: Path) -> dict[str, dict[str, str]]:
    """What ``experiments.csv`` says, by file; nothing where there is none."""
    index = folder / INDEX_FILE
    if not is_file(index):
        return {}
    table = read_table(index, words=True)
    if "file" not in table.header:
        raise FileError(f"{index}: row {table.header_line}: column file is missing; add it")
    rows = [dict(zip(table.header, cells, strict=True))
            for cells in table.texts(range(table.n_columns))]  # fmt: skip
    for row, number in zip(rows, table.numbers, strict=True):
        if Path(row["file"]).name != row["file"] or not row["file"]:
            raise FileError(
                f"{index}: row {number}, column file: '{row['file']}' must name a file in the "
                "same folder"
            )
    return {row["file"]: row for row in rows}


def labels_of(path: Path, number: int, said: Mapping[str, str], options: ImportOptions) -> Labels:
    """Return the labels of a file; options come before what is said of it.

    Raises
    ------
    FileError
        If a number or the side is none.
    """
    known = {*INDEX_COLUMNS, *SAID_COLUMNS, *SIDE_COLUMNS}
    subject = str(options.subject) if options.subject is not None else said.get("subject", "")
    stem = _NO_NAME.sub("-", path.stem).strip("-.") or f"recording-{number}"
    return Labels(
        name=stem,
        number=int(_number(path, said, "number", number)),
        subject=subject or "1",
        object=options.object or said.get("object") or "unknown",
        task=options.task or said.get("task") or "unknown",
        hand=hand_of(said, options, path),
        session=said.get("session", ""),
        extra={key: value for key, value in said.items() if key not in known},
    )


def hand_of(said: Mapping[str, str], options: ImportOptions, path: Path = Path()) -> HandSize:
    """Return size and side of the hand; options come before what is said.

    Raises
    ------
    FileError
        If a size is no number, or the side neither right nor left.
    """
    size = options.hand or UNKNOWN_HAND
    length, breadth = size.length, size.breadth
    if options.hand is None:
        length = _number(path, said, "hand_length_m", length)
        breadth = _number(path, said, "hand_breadth_m", breadth)
    if options.side:
        return HandSize(length, breadth, options.side)
    for column in SIDE_COLUMNS:
        text = said.get(column, "").lower()
        if text in SIDE_WORDS:
            return HandSize(length, breadth, SIDE_WORDS[text])
        if text and column == "side":
            raise FileError(f"{path}: side '{text}' is neither right nor left; correct it")
    return HandSize(length, breadth, size.side)


def _number(path: Path, said: Mapping[str, str], key: str, default: float) -> float:
    text = said.get(key, "")
    if not text:
        return default
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = float("nan")
    if not 0 < value < 1e9:
        raise FileError(f"{path}: {key} '{text}' is no number above 0; correct it")
    return value

"""Files that are never half written and never half read.

A write goes to a temporary name in the same folder and is renamed at the end; whoever looks sees
the old file or the new one. Archives are ``.npz`` without pickles that carry their kind, a schema
number and JSON metadata.
"""

import json
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import FileError

MAX_ARCHIVE_BYTES = 4 * 1024**3
"""Uncompressed size above which an archive is refused before anything of it is read."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` that takes its place if the block succeeds.

    The temporary name keeps the suffix, since encoders choose their format by it.

    Raises
    ------
    FileError
        If the folder does not exist or cannot be written.
    """
    path = Path(path)
    if path.is_dir():
        raise FileError(f"{path}: is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise FileError(f"{path}: folder '{path.parent}' does not exist; create it first")
    try:
        handle, name = tempfile.mkstemp(prefix=".", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror}); choose another folder")
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file as a whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_archive(
    path: Path,
    kind: str,
    schema: int,
    metadata: Mapping[str, Any],
    arrays: Mapping[str, npt.NDArray[Any]],
) -> None:
    """Write named arrays and JSON metadata as one compressed ``.npz``.

    The same content gives the same bytes: members carry no time of writing.
    """
    header = json.dumps({"kind": kind, "schema": schema, **metadata}, sort_keys=True)
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, header=np.array(header), **arrays)


def read_archive(
    path: Path, kind: str, newest_schema: int
) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Read back what `write_archive` wrote.

    Returns
    -------
    metadata
        The JSON metadata, ``kind`` and ``schema`` included.
    arrays
        The named arrays.

    Raises
    ------
    FileError
        If the file is missing, damaged, of another kind or of a newer schema.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError(f"{path}: no such file; check the path")
    try:
        header, arrays = _read_members(path)
    except FileError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise a dozen different classes
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileError(
            f"{path}: not a readable {kind} file ({reason}); it may be cut off, make it again"
        ) from error
    if header.get("kind") != kind:
        raise FileError(f"{path}: holds a '{header.get('kind')}', not a {kind}; check the path")
    schema = header.get("schema")
    if not isinstance(schema, int) or not 1 <= schema <= newest_schema:
        raise FileError(
            f"{path}: schema {schema} is not among 1 to {newest_schema}; update handsim to read it"
        )
    return header, arrays


def _read_members(path: Path) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    with zipfile.ZipFile(path) as members:
        total = sum(member.file_size for member in members.infolist())
    if total > MAX_ARCHIVE_BYTES:
        raise FileError(
            f"{path}: claims {total} bytes, more than the limit of {MAX_ARCHIVE_BYTES}; not read"
        )
    with np.load(path, allow_pickle=False) as stored:
        header = json.loads(str(stored["header"]))
        arrays = {name: stored[name] for name in stored.files if name != "header"}
    if not isinstance(header, dict):
        raise FileError(f"{path}: its header is not a table; it was not written by handsim")
    return header, arrays


def data_folder(name: str) -> Path:
    """Return the folder ``models`` or ``assets``, in a checkout or in an installed package.

    Raises
    ------
    FileError
        If neither is there.
    """
    package = Path(__file__).parent
    for folder in (package / "_data" / name, package.parent / name):
        if folder.is_dir():
            return folder
    raise FileError(f"{name}: not found beside the package; install handsim again")

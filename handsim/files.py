"""Files that are never half written and never half read.

A write goes to a temporary name in the same folder and is renamed at the end; whoever looks sees
the old file or the new one. Archives are ``.npz`` without pickles that carry their kind, a schema
number and JSON metadata.
"""

import errno
import json
import os
import secrets
import shutil
import zipfile
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from handsim.disk import naming
from handsim.errors import FileError

MAX_ARCHIVE_BYTES = 512 * 1024**2
"""Uncompressed size above which an archive is refused before anything of it is read."""
MAX_TEXT_BYTES = 64 * 1024**2
"""Size above which a text file is refused; a minute of postures at 100 Hz takes 1.5 MB."""


def check_target(path: Path) -> None:
    """Check that a file of that name could be written.

    Raises
    ------
    FileError
        If it is a folder or a device, its folder does not exist, or neither may be written.
    """
    with naming(path):
        if path.is_dir():
            raise FileError(f"{path}: is a folder; give the name of a file")
        if not path.parent.is_dir():
            raise FileError(f"{path}: folder '{path.parent}' does not exist; create it first")
        if path.exists() and not path.is_file():  # what is put in the place of a device hides it
            raise FileError(f"{path}: is not a plain file; give the name of one")
        if not os.access(path.parent, os.W_OK):
            raise _not_writable(path.parent)


def check_output_folder(folder: Path) -> None:
    """Check that files could be written to a folder, which may have to be made in its own.

    Raises
    ------
    FileError
        If it is a file, the folder that it is in does not exist, or may not be written.
    """
    with naming(folder):
        if folder.exists() and not folder.is_dir():
            raise FileError(f"{folder}: is a file; give the name of a folder")
        if not folder.parent.is_dir():
            raise FileError(f"{folder}: folder '{folder.parent}' does not exist; create it first")
        written = folder if folder.is_dir() else folder.parent
        if not os.access(written, os.W_OK):
            raise _not_writable(written)


def _not_writable(folder: Path) -> OSError:
    """Return what the system would say, before any work is done for a file there."""
    read_only = os.statvfs(folder).f_flag & os.ST_RDONLY if hasattr(os, "statvfs") else 0
    code = errno.EROFS if read_only else errno.EACCES
    return OSError(code, os.strerror(code), str(folder))


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a temporary path beside ``path`` that takes its place if the block succeeds.

    The temporary name keeps the suffix, since encoders choose their format by it.

    Raises
    ------
    FileError
        If the folder does not exist or cannot be written, or the disk is full.
    """
    path = Path(path)
    check_target(path)
    temporary = path.with_name(f".{secrets.token_hex(6)}{path.suffix}")
    try:
        with naming(path, scratch=temporary):
            # Made here with the usual permissions: to ask for them would set them for all threads.
            os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            yield temporary
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def replacing_folder(folder: Path) -> Generator[Path]:
    """Yield a new folder that takes the place of ``folder`` if the block succeeds.

    Whether what is there may be replaced is for the caller to check.

    Raises
    ------
    FileError
        If the folder that it is in cannot be written, or the disk is full.
    """
    import tempfile

    with naming(folder):
        scratch = Path(tempfile.mkdtemp(prefix=".", dir=folder.parent))
    try:
        with naming(folder, scratch=scratch):
            fresh = scratch / "new"
            fresh.mkdir()
            yield fresh
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


def write_text(path: Path, text: str) -> None:
    """Write a text file as a whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def read_text(path: Path) -> str:
    """Read a text file.

    Raises
    ------
    FileError
        If it is missing, too large or not UTF-8.
    """
    path = Path(path)
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    try:
        with naming(path, "read"):
            size = path.stat().st_size
            if size > MAX_TEXT_BYTES:
                raise FileError(f"{path}: {size} bytes, more than {MAX_TEXT_BYTES}; split it")
            return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: cannot be read as text ({error}); it must be UTF-8") from error


def is_file(path: Path) -> bool:
    """Whether there is a file; a name that no file can have is the name of none."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long a name, a null character in it
        return False


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
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    try:
        with naming(path, "read"):
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


def read_arrays(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Read the arrays of anyone's ``.npz`` or ``.npy``, whatever they hold but Python objects.

    Returns
    -------
    By their names; that of a ``.npy`` is empty. Members of an archive that are no arrays are left
    out.

    Raises
    ------
    FileError
        If the file is missing, damaged, too large, or holds no array without Python objects.
    """
    path = Path(path)
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    arrays: dict[str, npt.NDArray[Any]] = {}
    objects = False
    try:
        with naming(path, "read"):
            for name, stream in _array_streams(path):
                try:
                    arrays[name] = _read_stream(stream, name)
                except _ObjectsError:
                    objects = True
    except FileError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise a dozen different classes
        reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        raise FileError(
            f"{path}: not a readable file of arrays ({reason}); save it again by numpy.savez"
        ) from error
    if not arrays:
        what = "only Python objects" if objects else "no arrays"
        raise FileError(f"{path}: holds {what}; save numbers by numpy.savez")
    return arrays


def as_floats(array: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Return numbers of any width as float64, without a word about those that are none."""
    with np.errstate(all="ignore"):
        return np.asarray(array, dtype=np.float64)


def _array_streams(path: Path) -> Iterator[tuple[str, IO[bytes]]]:
    """Open the arrays of a file one by one, once the whole is known not to be too large."""
    if not zipfile.is_zipfile(path):
        _check_size(path, path.stat().st_size)
        with path.open("rb") as stream:
            yield "", stream
        return
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        _check_size(path, sum(member.file_size for member in members))
        for member in members:
            if member.filename.endswith(".npy"):
                with archive.open(member) as stream:
                    yield member.filename.removesuffix(".npy"), stream


def _check_size(path: Path, total: int) -> None:
    if total > MAX_ARCHIVE_BYTES:
        raise FileError(
            f"{path}: claims {total} bytes, more than the limit of {MAX_ARCHIVE_BYTES}; not read"
        )


def _read_members(path: Path) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        _check_size(path, sum(member.file_size for member in members))
        arrays = {m.filename.removesuffix(".npy"): _read_array(archive, m) for m in members}
    header = json.loads(str(arrays.pop("header")))
    if not isinstance(header, dict):
        raise FileError(f"{path}: its header is not a table; it was not written by handsim")
    return header, arrays


def _read_array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> npt.NDArray[Any]:
    with archive.open(member) as stream:
        return _read_stream(stream, member.filename)


class _ObjectsError(ValueError):
    """An array holds Python objects, which only a pickle could bring back."""


def _read_stream(stream: IO[bytes], name: str) -> npt.NDArray[Any]:
    """Read one array. ``np.load`` would allocate whatever its header claims, before reading it."""
    version = np.lib.format.read_magic(stream)
    read_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }[version]
    shape, fortran, dtype = read_header(stream)
    if dtype.hasobject:
        raise _ObjectsError(f"{name} holds Python objects")
    content = bytearray(stream.read())  # its checksum is compared at the end
    return np.ndarray(shape, dtype, content, order="F" if fortran else "C")


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

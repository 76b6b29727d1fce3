"""What the system refuses about a file, as an error that names the file and the remedy."""

import errno
import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from handsim.errors import FileError

_OTHER_DISK = "choose a folder on another disk"
_REMEDIES = {
    errno.EACCES: "change its permissions or those of its folder, or choose another",
    errno.EPERM: "change its permissions or those of its folder, or choose another",
    errno.EROFS: _OTHER_DISK,
    errno.EDQUOT: f"delete files of yours, or {_OTHER_DISK}",
    errno.EFBIG: _OTHER_DISK,
    errno.EIO: f"the disk may be failing: {_OTHER_DISK}",
    errno.ENAMETOOLONG: "give a shorter name; 255 bytes are the most on usual disks",
    errno.EISDIR: "give the name of a file",
    errno.ENOTDIR: "part of it is a file and no folder; choose another",
    errno.ENOENT: "check the path, and create its folder first",
    errno.EEXIST: "choose another name",
    errno.ENOTEMPTY: "choose another name",
    errno.ELOOP: "its links lead round in a circle; choose another",
    errno.EMFILE: "close some, or raise the limit by ulimit -n",
    errno.ENFILE: "close some programs",
    errno.EBUSY: "wait for what is using it, or choose another",
    errno.ETXTBSY: "wait for what is using it, or choose another",
}


def refused(path: Path, error: OSError, done: str = "used", written: int = 0) -> FileError:
    """Return an error that says what the system refused, and what to do.

    Parameters
    ----------
    path
        The file or folder as the user named it.
    error
        What the system said.
    done
        What was tried, such as ``written``.
    written
        How many bytes of the file there was space for; they are free again.
    """
    reason = error.strerror or str(error) or type(error).__name__
    if error.errno == errno.ENOSPC:
        return FileError(f"{path}: cannot be {done} ({reason}); {space_remedy(path, written)}")
    remedy = _REMEDIES.get(error.errno or 0, "choose another")
    return FileError(f"{path}: cannot be {done} ({reason}); {remedy}")


def space_remedy(path: Path, written: int = 0) -> str:
    """Say how much space there is for a file that needs more, and what to do."""
    folder = next((each for each in path.absolute().parents if each.is_dir()), Path("/"))
    free = shutil.disk_usage(folder).free + written
    return f"it needs more than the {_size(free)} free in {folder}: free some, or {_OTHER_DISK}"


def _size(n_bytes: int) -> str:
    units = ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))
    factor, unit = next(((f, unit) for f, unit in units if n_bytes >= f), (1.0, "bytes"))
    return f"{n_bytes / factor:.3g} {unit}"


@contextmanager
def naming(path: Path, done: str = "written", scratch: Path | None = None) -> Generator[None]:
    """Turn what the system refuses about a file into an error that names it.

    What it refuses about other files goes through, as do pipes that break.

    Parameters
    ----------
    path
        The file or folder as the user named it.
    done
        What is tried.
    scratch
        What is written in its place, and renamed at the end; by default ``path`` itself.

    Raises
    ------
    FileError
    """
    scratch = scratch or path
    try:
        yield
    except ConnectionError:
        raise
    except OSError as error:
        if error.errno is None or not _concerns(error, (path, scratch)):
            raise
        raise refused(path, error, done, _bytes_in(scratch)) from error


def _concerns(error: OSError, paths: tuple[Path, ...]) -> bool:
    """Whether an error is about one of these, what is in or above it, or nothing with a name."""
    if not isinstance(error.filename, str | os.PathLike):
        return error.filename is None
    named = Path(error.filename)
    return any(named == path or path in named.parents or named in path.parents for path in paths)


def _bytes_in(path: Path) -> int:
    """Return the size of a file or folder that is about to be removed, 0 where there is none."""
    try:
        files = path.rglob("*") if path.is_dir() else (path,)
        return sum(each.stat().st_size for each in files if each.is_file())
    except OSError:
        return 0

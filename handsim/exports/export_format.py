"""Which format a file or folder has, by its name or as it is called."""

from pathlib import Path
from typing import Literal

from handsim.errors import InputError, UnknownNameError

ExportFormat = Literal["pandas", "hdf5", "lerobot", "rerun"]

SUFFIXES: dict[ExportFormat, tuple[str, ...]] = {
    "pandas": (".parquet", ".csv"),
    "hdf5": (".h5", ".hdf5"),
    "lerobot": (),
    "rerun": (".rrd",),
}
"""How the names of files end; a LeRobot data set is a folder."""
_CALLED: dict[str, ExportFormat] = {"parquet": "pandas", "csv": "pandas"}
"""What else formats are called; a data frame is in one of two kinds of files."""
EXPORT_FORMATS: tuple[str, ...] = (*SUFFIXES, *_CALLED)


def export_format(path: Path, named: str | None = None) -> ExportFormat:
    """Return the format in which to write to ``path``.

    Parameters
    ----------
    path
    named
        What the user calls it. A name without a suffix may then be that of a file; where nothing is
        named, it is that of a folder.

    Raises
    ------
    UnknownNameError
        If there is no format of that name.
    InputError
        If the suffix is of no format, or not of the one named.
    """
    if named is not None:
        return _named(path, named.lower())
    suffix = path.suffix.lower()
    if not suffix:
        return "lerobot"
    for name, own in SUFFIXES.items():
        if suffix in own:
            return name
    known = ", ".join(each for own in SUFFIXES.values() for each in own)
    raise InputError(
        f"{path}: suffix '{path.suffix}' is not one of {known}; a name without a suffix, or "
        "--to lerobot, makes a LeRobot data set"
    )


def _named(path: Path, named: str) -> ExportFormat:
    for name, own in SUFFIXES.items():
        if name == _CALLED.get(named, named):
            wanted = (f".{named}",) if named in _CALLED else own
            suffix = path.suffix.lower()
            if wanted and suffix not in wanted and (suffix or named == "csv"):
                raise InputError(
                    f"{path}: suffix '{path.suffix}' is not one of {', '.join(wanted)}, in which "
                    f"{named} is written; change the name"
                )
            return name
    raise UnknownNameError("format", named, EXPORT_FORMATS)

"""Read recordings of other layouts, by the name of the layout."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.recording import RecordingSet

ENTRY_POINTS = "handsim.importers"
"""Group of entry points by which other packages add layouts; each leads to a `Layout`."""
_OWN = {
    "handsim": "handsim_folder",
    "table": "tables",
    "cyberglove": "cyberglove",
    "ninapro": "ninapro.repetitions",
    "keypoints": "keypoints",
    "markers": "markers",
    "adroit": "adroit",
    "west-rtg": "west_rtg",
}
FORMATS: tuple[str, ...] = tuple(_OWN)
"""Names of the layouts that handsim itself reads."""


def layouts() -> dict[str, Callable[[], Layout]]:
    """Return what loads each layout, those of other packages last; one of them replaces none."""
    found = {name: _loader(module) for name, module in _OWN.items()}
    for point in entry_points(group=ENTRY_POINTS):
        found.setdefault(point.name, point.load)
    return found


def _loader(module: str) -> Callable[[], Layout]:
    return lambda: import_module(f"handsim.recordings.importers.{module}").LAYOUT


def layout_named(name: str) -> Layout:
    """Return a layout.

    Raises
    ------
    UnknownNameError
        If there is none of that name.
    InputError
        If another package registers what is no layout.
    """
    known = layouts()
    if name not in known:
        raise UnknownNameError("format", name, tuple(known))
    layout: Any = known[name]()
    if not isinstance(layout, Layout):
        raise InputError(
            f"entry point {name} of group {ENTRY_POINTS} leads to a {type(layout).__name__}; it "
            "must be a handsim.recordings.importers.layout.Layout"
        )
    return layout


def import_recordings(
    files: Sequence[Path],
    format: str,
    subject: int | None = None,
    options: ImportOptions | None = None,
) -> RecordingSet:
    """Read recordings of another layout.

    Parameters
    ----------
    files
        In any order.
    format
        Name of the layout, one of `layouts`.
    subject
        Number of the subject, from 1, where the layout numbers them.
    options
        What else is said about the files.

    Raises
    ------
    FileError
        If a file is missing, damaged or not of the layout.
    InputError
        If an option is out of its range, or the layout has no use for it.
    UnknownNameError
        If the format is not known.
    """
    said = options or ImportOptions()
    if subject is not None:
        said = replace(said, subject=subject)
    return layout_named(format)([Path(file) for file in files], said)

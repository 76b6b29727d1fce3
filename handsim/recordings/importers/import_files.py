"""Read recordings published in a layout of their own, by the name of the layout."""

from collections.abc import Callable, Sequence
from pathlib import Path

from handsim.errors import UnknownNameError
from handsim.recordings.importers.west_rtg import read_west_rtg
from handsim.recordings.recording import RecordingSet

READERS: dict[str, Callable[[Sequence[Path], int | None], RecordingSet]] = {
    "west-rtg": read_west_rtg,
}
"""What reads each layout: from files, and the number of a subject or None, to recordings."""
FORMATS: tuple[str, ...] = tuple(READERS)
"""Names of the layouts that `import_recordings` reads."""


def import_recordings(
    files: Sequence[Path], format: str, subject: int | None = None
) -> RecordingSet:
    """Read recordings published in a layout of their own, cut to the reach-to-grasp phase.

    Parameters
    ----------
    files
        The published files, in any order.
    format
        One of `FORMATS`.
    subject
        Number of the subject, from 1; all subjects where it is left out.

    Raises
    ------
    FileError
        If a file is missing, damaged or not of the layout.
    InputError
        If the subject is not among those in the files.
    UnknownNameError
        If the format is not known.
    """
    if format not in READERS:
        raise UnknownNameError("format", format, FORMATS)
    return READERS[format](files, subject)

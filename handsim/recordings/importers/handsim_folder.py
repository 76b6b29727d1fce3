"""handsim's own folders, with gaps bridged, sides stated or radians turned into degrees."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from handsim.errors import FileError, InputError
from handsim.recordings.folder import INDEX_FILE, read_recordings
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.recording import RecordingSet
from handsim.wording import number_of


def read_folder(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read one folder of recordings, named itself or by its ``experiments.csv``.

    Raises
    ------
    FileError
        As `read_recordings`, or if more than one folder is named.
    InputError
        If the angles are said to be counts.
    """
    if options.units == "counts":
        raise InputError("format handsim reads angles; give counts of a glove to format table")
    folders = {file.parent if file.name == INDEX_FILE else file for file in files}
    if len(folders) != 1:
        raise FileError(f"{number_of(len(folders), 'folder')}; format handsim reads one at a time")
    recordings = read_recordings(
        folders.pop(), bridge_s=options.bridge_s, side=options.side, radians=options.units == "rad"
    )
    if options.hand is None:
        return recordings
    size = options.hand
    return RecordingSet(tuple(replace(r, hand=replace(size, side=r.hand.side)) for r in recordings))


LAYOUT = Layout(
    "handsim",
    "a folder of handsim's own CSV files: to bridge gaps or to state side, units or hand size",
    read_folder,
    frozenset({"bridge_s", "side", "units", "hand"}),
)

"""The reaches of a person that are shipped: markers fitted, cut and thinned out.

``python assets/people/make.py RECORDING.tsv [FOLDER]`` makes ``pillow`` again from the published
recording (README.md beside this).
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from handsim.recordings.cutting.cut import cut_recordings
from handsim.recordings.folder import write_recordings
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.recording import Recording, RecordingSet

KEPT = ("palm", "elbow", "shoulder", "object", "aperture")
"""First parts of the names of the channels that are kept."""
EVERY = 2  # of 100 frames a second: reaching movements hold next to nothing above 3 Hz
SOURCE = "dfki-ric/hand_embodiment test/data/recording.tsv (BSD-3-Clause)"


def reaches(file: Path) -> RecordingSet:
    """Import the published recording, cut its reaches out and thin them out."""
    options = ImportOptions(object="pillow", task="pillow-grasp")
    whole = import_recordings([file], "markers", options=options)
    found = cut_recordings(whole).recordings
    return RecordingSet(tuple(_thinned(each, i) for i, each in enumerate(found, start=1)))


def _thinned(recording: Recording, number: int) -> Recording:
    channels = {
        name: np.round(values[::EVERY], 4)
        for name, values in recording.channels.items()
        if name.split("_")[0] in KEPT and not name.startswith("object_q")
    }
    return replace(
        recording,
        name=f"pillow-{number:02d}",
        time=recording.time[::EVERY],
        q=np.deg2rad(np.round(np.rad2deg(recording.q[::EVERY]), 2)),
        channels=channels,
        extra={"source": SOURCE},
    )


def without_trailing_zeros(folder: Path) -> None:
    """Shorten the numbers in all files: three quarters of their digits are zeros."""
    for file in folder.glob("pillow-*.csv"):
        header, *rows = file.read_text(encoding="utf-8").splitlines()
        short = [
            ",".join(f"{float(cell):.6g}" if cell else "" for cell in row.split(","))
            for row in rows
        ]
        file.write_text("\n".join([header, *short]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    target = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent / "pillow"
    write_recordings(reaches(Path(sys.argv[1])), target)
    without_trailing_zeros(target)

"""Make what lies in this folder: eigengrasps of the built-in recordings, then both hands.

``python models/hand/make.py`` writes ``eigengrasps.csv`` (mean posture and principal components),
which `handsim.hand.eigengrasps` reads for the keyframes, ``right_hand.xml`` and ``left_hand.xml``
with keyframes and scenes, and a scene of both. The hand itself knows nothing of learning.
"""

from pathlib import Path

import numpy as np

from handsim.files import data_folder, write_text
from handsim.hand.export import SURROUNDINGS, keyframes_of, write_hand
from handsim.hand.scene_files import write_both
from handsim.joints import JOINT_NAMES
from handsim.learning.subspace import PostureSubspace
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import RecordingSet
from handsim.types import SIDES, HandSize

N_EIGENGRASPS = 3
"""As many as the paper keeps (its Sec. VI-B)."""


def eigengrasps_text(recordings: RecordingSet) -> str:
    """Return a CSV table of the mean posture and of one standard deviation along each component.

    Rows ``mean``, ``eigengrasp_1`` ...; columns ``name`` and the joints with ``_deg``, rounded to
    0.01 deg.

    Raises
    ------
    InputError
        If the recordings vary in too few directions.
    """
    subspace = PostureSubspace(N_EIGENGRASPS).fit(np.vstack([r.q for r in recordings]))
    deviations = np.sqrt(subspace.explained_variance_)[:, None] * subspace.components_
    rows = [",".join(("name", *(f"{joint}_deg" for joint in JOINT_NAMES)))]
    names = ("mean", *(f"eigengrasp_{i + 1}" for i in range(N_EIGENGRASPS)))
    for name, q in zip(names, np.rad2deg([subspace.mean_, *deviations]), strict=True):
        # Adding 0 makes -0 a 0.
        rows.append(",".join((name, *(f"{angle:.2f}" for angle in np.round(q, 2) + 0.0))))
    return "\n".join(rows) + "\n"


def main(folder: Path = Path(__file__).parent) -> None:
    """Write the table of eigengrasps, then the hands, whose keyframes are made of it."""
    recordings = read_recordings(data_folder("assets") / "experiments")
    write_text(folder / "eigengrasps.csv", eigengrasps_text(recordings))
    sizes = {side: HandSize(side=side) for side in SIDES}
    for size in sizes.values():
        write_hand(size, folder)
    write_both(folder, SURROUNDINGS, {side: keyframes_of(size) for side, size in sizes.items()})


if __name__ == "__main__":
    main()

"""Write the mean posture and the eigengrasps of recordings, for the hand model's keyframes.

``python -m handsim.learning.eigengrasps RECORDINGS FILE.csv``; the file is read by
`handsim.hand.eigengrasps`, since the hand knows nothing of learning.
"""

import argparse
from pathlib import Path

import numpy as np

from handsim.files import write_text
from handsim.joints import JOINT_NAMES
from handsim.learning.subspace import PostureSubspace
from handsim.motion.recording import RecordingSet, read_recordings

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


def main() -> None:
    """Write the table of the recordings named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", type=Path)
    parser.add_argument("file", type=Path)
    arguments = parser.parse_args()
    write_text(arguments.file, eigengrasps_text(read_recordings(arguments.recordings)))


if __name__ == "__main__":
    main()

"""The built-in experiments: the demonstrator's reaches as a virtual data glove reads them.

They stand in for the paper's 24 recordings, which were not published, and are synthetic: made by
script and simulation, not by a person. ``python assets/make_experiments.py [FOLDER]`` makes them
again.
"""

import sys
from pathlib import Path

from handsim.grasping.planning.demonstrator import demonstrated_reach
from handsim.recordings.folder import write_recordings
from handsim.recordings.recording import RecordingSet
from handsim.tasks.table_one import TASKS


def built_in_experiments() -> RecordingSet:
    """Make the recordings; rest posture, timing and noise come from the task's number in Table I.

    A demonstration that does not hold is none and is left out.
    """
    reaches = (demonstrated_reach(task) for task in TASKS)
    return RecordingSet(tuple(reach for reach in reaches if reach is not None))


if __name__ == "__main__":
    here = Path(__file__).parent / "experiments"
    write_recordings(built_in_experiments(), Path(sys.argv[1]) if len(sys.argv) > 1 else here)

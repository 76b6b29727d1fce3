"""Where the files of a LeRobot data set are, in codebase version v3.0.

data/chunk-000/file-000.parquet           a row a frame, episode after episode
meta/info.json                            features, rate, where files are
meta/stats.json                           by which learners scale
meta/tasks.parquet                        sentences and their numbers
meta/episodes/chunk-000/file-000.parquet  a row an episode: where it is, its statistics
meta/handsim.json                         outcomes, conditions, subjects, what was left out
videos/observation.images.<camera>/chunk-000/file-000.mp4
"""

from pathlib import Path

from handsim.errors import FileError
from handsim.files import check_output_folder

VERSION = "v3.0"
CHUNK = 1000
"""Most files in a folder."""
DATA_MB, VIDEO_MB = 100, 200
"""Sizes beyond which another file is begun [MB]."""

_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA_PATH = f"data/{_FILE}.parquet"
VIDEO_PATH = f"videos/{{video_key}}/{_FILE}.mp4"
"""In the words of ``info.json``."""
EPISODES_PATH = f"meta/episodes/{_FILE}.parquet"
INFO, STATS, TASKS = "meta/info.json", "meta/stats.json", "meta/tasks.parquet"
FACTS = "meta/handsim.json"
"""What LeRobot does not ask for; it tells that a folder was written here."""


def file_of(number: int) -> dict[str, int]:
    """Return chunk and number within it of the file of that number, from 0."""
    return {"chunk_index": number // CHUNK, "file_index": number % CHUNK}


def made(path: Path) -> Path:
    """Return the path of a file, its folder made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def check_data_set_folder(folder: Path) -> None:
    """Check that a data set could be written to a folder, before any work is done for it.

    Raises
    ------
    FileError
        If its parent is missing or locked, or it holds anything but a data set written here.
    """
    check_output_folder(folder)
    check_output_folder(folder.parent)  # where it is written under another name, and renamed
    if folder.exists() and any(folder.iterdir()) and not (folder / FACTS).is_file():
        found = min(folder.iterdir()).name
        raise FileError(
            f"{folder}: holds '{found}', which `handsim export` did not write; choose a new or "
            "empty folder"
        )

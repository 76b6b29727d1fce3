"""What is to be exported, given as objects or as files, as a row of episodes."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from handsim.errors import FileError, InputError
from handsim.exports.episode import Episode, Shown
from handsim.exports.posture_episode import posture_episode, recording_episode
from handsim.exports.rollout_episode import rollout_episode
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout_file import read_rollout
from handsim.learning.controller import PostureSequence
from handsim.recordings.folder import INDEX_FILE, read_recordings
from handsim.recordings.posture_file import checked_postures, read_posture_table
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import Progress

Exported = Shown | RecordingSet | Iterable[Shown] | Mapping[str, Shown]
"""One movement, or several; a mapping gives them names."""


def is_one(exported: Exported) -> bool:
    """Whether it is one movement, and not several or a set of one."""
    # A posture sequence is a tuple, too.
    return isinstance(exported, Rollout | Recording | PostureSequence | Episode)


def episodes_of(exported: Exported) -> tuple[Episode, ...]:
    """Return movements as episodes whose names differ.

    Raises
    ------
    InputError
        If there are none, or one is nothing that can be exported.
    """
    if isinstance(exported, Rollout | Recording | PostureSequence | Episode):
        return (_episode(exported),)
    if isinstance(exported, Mapping):
        named = [replace(_episode(each), name=str(name)) for name, each in exported.items()]
    else:
        named = [_episode(each) for each in exported]
    if not named:
        raise InputError("nothing to export; give 1 movement or more")
    return named_apart(named)


def read_sources(paths: Sequence[Path], progress: Progress | None = None) -> tuple[Episode, ...]:
    """Read movements from files and folders.

    Parameters
    ----------
    paths
        Rollouts (``.npz``), posture sequences (``.csv``), folders of recordings or of rollouts.
    progress
        Called with the fraction done.

    Raises
    ------
    FileError
        If one is missing, damaged, or nothing of these.
    """
    files = [file for path in paths for file in _files(Path(path))]
    episodes: list[Episode] = []
    for i, file in enumerate(files, start=1):
        episodes += _read(file)
        if progress is not None:
            progress(i / len(files))
    return named_apart(episodes)


def named_apart(episodes: Sequence[Episode]) -> tuple[Episode, ...]:
    """Return episodes with a number after the name of those whose name another had before."""
    taken: set[str] = set()
    apart: list[Episode] = []
    for episode in episodes:
        stem = episode.name.replace("/", "-") or episode.kind
        name, number = stem, 1
        while name in taken:
            number += 1
            name = f"{stem}-{number}"
        taken.add(name)
        apart.append(episode if name == episode.name else replace(episode, name=name))
    return tuple(apart)


def _episode(shown: object) -> Episode:
    if isinstance(shown, Episode):
        return shown
    if isinstance(shown, Rollout):
        return rollout_episode(shown)
    if isinstance(shown, Recording):
        return recording_episode(shown)
    if isinstance(shown, PostureSequence):
        return posture_episode("postures", shown.time, shown.q)
    raise InputError(
        f"a {type(shown).__name__} cannot be exported; give rollouts, recordings or posture "
        "sequences"
    )


def _files(path: Path) -> list[Path]:
    """Return a file or a folder of recordings as it is, and the files of a folder of rollouts."""
    if not path.is_dir() or (path / INDEX_FILE).is_file():
        return [path]
    rollouts = sorted(path.glob("*.npz"), key=_as_people_count)
    if not rollouts:
        raise FileError(
            f"{path}: holds neither {INDEX_FILE} nor rollouts (.npz); name a folder of one of them"
        )
    return rollouts


def _as_people_count(path: Path) -> list[tuple[int, str]]:
    """Return by what files are sorted: ``cube``, ``cube-2``, ``cube-10``."""
    parts = re.split(r"(\d+)", path.stem)
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _read(path: Path) -> list[Episode]:
    if path.is_dir():
        return [recording_episode(recording) for recording in read_recordings(path)]
    if path.suffix.lower() == ".csv":
        content = read_posture_table(path)
        time, q = checked_postures(content)
        return [posture_episode(path.stem, time, q, content.channels)]
    if path.suffix.lower() == ".npz":
        try:
            return [rollout_episode(read_rollout(path), path.stem)]
        except FileError:
            raise
        except InputError as error:
            raise FileError(f"{path}: {error}") from error
    if not path.exists():
        raise FileError(f"{path}: no such file; check the path")
    raise FileError(
        f"{path}: suffix '{path.suffix}'; give rollouts (.npz), posture sequences (.csv), or "
        "folders of recordings or rollouts"
    )

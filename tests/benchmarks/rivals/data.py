"""Sets of movements: folders of recordings in handsim's format, and handwriting."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.learning.subspace import PostureSubspace
from handsim.recordings.folder import read_recordings
from handsim.types import Array

from .protocol import Movement

N_FRAMES = 200
"""Frames that are kept of a stroke of handwriting."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A movement as it was recorded.

    Attributes
    ----------
    object
    time : (n,) [s]
    q : (n, m)
        22 joint angles [rad], or the place of a pen, in units of the spread of its set.
    """

    object: str
    time: Array
    q: Array


@dataclass(frozen=True, eq=False)
class Space:
    """Coordinates in which movements are learned and compared."""

    subspace: PostureSubspace | None

    def movement(self, trial: Trial) -> Movement:
        """Project a trial."""
        return Movement(trial.object, self.project(trial.q), trial.time)

    def project(self, q: Array) -> Array:
        """Turn what was recorded (n, m) into coordinates (n, d)."""
        return self.subspace.transform(q) if self.subspace else q

    def lift(self, z: Array) -> Array:
        """Turn coordinates (n, d) into what was recorded (n, m), not clipped to joint ranges."""
        return self.subspace.inverse_transform(z) if self.subspace else z


@dataclass(frozen=True, eq=False)
class TrialSet:
    """Movements of one person, or strokes of one shape.

    Attributes
    ----------
    name
    trials
    n_components
        Principal components that are learned; None leaves coordinates as they are.
    unit, per_rad
        In which errors over time are told, and how many of it are one unit of `Trial.q`.
    """

    name: str
    trials: tuple[Trial, ...]
    n_components: int | None
    unit: str
    per_rad: float

    def space(self, chosen: Sequence[int]) -> Space:
        """Return the coordinates by what is known of some trials."""
        if self.n_components is None:
            return Space(None)
        q = np.vstack([self.trials[i].q for i in chosen])
        return Space(PostureSubspace(self.n_components).fit(q))


def read_sets(folder: Path, n_components: int = 3) -> tuple[TrialSet, ...]:
    """Read a folder: one set a person of recordings, or one a file of handwriting.

    Raises
    ------
    FileError
        If it holds neither, or a file of it is damaged.
    """
    if (folder / "experiments.csv").is_file():
        return _people(folder, n_components)
    shapes = sorted(folder.glob("*.npz"))
    if not shapes:
        raise FileError(f"{folder}: neither experiments.csv nor .npz files of handwriting in it")
    return tuple(_shape(file) for file in shapes)


def _people(folder: Path, n_components: int) -> tuple[TrialSet, ...]:
    recordings = read_recordings(folder)
    subjects = dict.fromkeys(each.subject for each in recordings)
    per_rad = float(np.rad2deg(1.0))
    return tuple(
        TrialSet(
            subject,
            tuple(Trial(r.object, r.time, r.q) for r in recordings if r.subject == subject),
            n_components,
            "deg",
            per_rad,
        )
        for subject in subjects
    )


def _shape(file: Path) -> TrialSet:
    """Read ``pos`` (strokes, frames, 2) [mm] and ``t`` (strokes, frames) [s].

    Lengths are divided by the root of the mean squared distance from the destinations, so that
    learners whose lengths are tuned for postures find movements of about the same size.
    """
    try:
        with np.load(file) as archive:
            places = np.array(archive["pos"], dtype=float)
            times = np.array(archive["t"], dtype=float)
    except (OSError, ValueError, KeyError) as error:
        raise FileError(f"{file}: not a file of handwriting ({error}); give pos and t") from error
    if places.ndim != 3 or places.shape[:2] != times.shape or len(places[0]) < 2:
        raise FileError(f"{file}: pos {places.shape} and t {times.shape}; give (n, frames, 2)")
    kept = np.unique(np.linspace(0, places.shape[1] - 1, N_FRAMES).round().astype(int))
    spread = float(np.sqrt(np.mean(np.sum((places - places[:, -1:]) ** 2, axis=2))))
    trials = tuple(
        Trial(file.stem, time[kept], place[kept] / spread)
        for place, time in zip(places, times, strict=True)
    )
    return TrialSet(file.stem, trials, None, "mm", spread)

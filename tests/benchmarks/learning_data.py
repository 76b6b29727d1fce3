"""The recordings that the learning benchmarks run on, and how they are scored."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.learning.subspace import PostureSubspace
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.paths import path_error
from handsim.recordings.importers.import_files import import_recordings

DATA = Path(__file__).parents[2] / "../shared/data/reach_to_grasp"
FILES = [DATA / f"{letter}_R2G_SUBJECTbyOBJECT_raw.mat" for letter in "Xt"]
SUBJECTS = (1, 2, 3, 4)


@dataclass(frozen=True)
class Subject:
    """Recorded paths [rad] in 3 principal components, their times [s] and objects."""

    number: int
    paths: list[np.ndarray]
    times: list[np.ndarray]
    objects: list[str]

    @property
    def starts(self) -> np.ndarray:
        return np.array([path[0] for path in self.paths])

    @property
    def goals(self) -> np.ndarray:
        return np.array([path[-1] for path in self.paths])


def load(number: int) -> Subject:
    if not DATA.is_dir():
        sys.exit(f"{DATA}: the published recordings are not there; see the README beside this file")
    recordings = import_recordings(FILES, "west-rtg", number)
    subspace = PostureSubspace(3).fit(np.vstack([r.q for r in recordings]))
    return Subject(
        number,
        [subspace.transform(r.q) for r in recordings],
        [r.time for r in recordings],
        [r.object for r in recordings],
    )


def ratio(rollouts: list[FlowPath], paths: list[np.ndarray]) -> float:
    """Mean path error over that of straight lines."""
    errors = [path_error(r.points, p) for r, p in zip(rollouts, paths, strict=True)]
    return float(np.sum(errors) / np.sum([path_error(p[[0, -1]], p) for p in paths]))


def roll_out(
    directions: Callable[[np.ndarray, np.ndarray], np.ndarray], paths: list[np.ndarray]
) -> list[FlowPath]:
    return follow(
        directions, np.array([path[0] for path in paths]), np.array([path[-1] for path in paths])
    )

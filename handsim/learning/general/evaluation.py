"""Scores of a field of any data, in its unit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.paths import path_error
from handsim.result import Result
from handsim.types import Array


@dataclass(frozen=True)
class NavigationScores(Result):
    """How close the paths of a field come to given ones.

    Attributes
    ----------
    ratio
        Mean path error over mean straight error; None where the latter is 0.
    n_arrived, n_paths
    certified
        Whether all destinations of the field are proved.
    path_error, straight_error
        Means, in the unit of the paths: root-mean-square distance at equal fractions of arc length
        of the field's path, and of the straight line from start to destination.
    per_path
        ``arrived, path_error, straight_error`` of each.
    """

    ratio: float | None
    n_arrived: int
    n_paths: int
    certified: bool
    path_error: float
    straight_error: float
    per_path: tuple[dict[str, float | bool], ...]


def scored(
    navigation: NavigationFunction,
    paths: Sequence[Array],
    goals: Sequence[Array],
    scale: float,
    certified: bool,
) -> NavigationScores:
    """Follow a field from the starts of paths to destinations.

    Parameters
    ----------
    navigation
    paths, goals
        (n_i, n) and (n,) [rad].
    scale : [rad per unit]
    certified
        Told on.
    """
    starts = np.array([path[0] for path in paths])
    found = follow(navigation.directions, starts, np.array(goals))
    errors = [path_error(f.points, p) / scale for f, p in zip(found, paths, strict=True)]
    lines = [
        path_error(np.array([path[0], goal]), path) / scale
        for path, goal in zip(paths, goals, strict=True)
    ]
    error, line = float(np.mean(errors)), float(np.mean(lines))
    return NavigationScores(
        ratio=error / line if line > 0.0 else None,
        n_arrived=sum(each.arrived for each in found),
        n_paths=len(found),
        certified=certified,
        path_error=error,
        straight_error=line,
        per_path=tuple(
            {"arrived": f.arrived, "path_error": e, "straight_error": s}
            for f, e, s in zip(found, errors, lines, strict=True)
        ),
    )

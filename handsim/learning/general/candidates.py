"""Fields that are tried for the same paths, and the choice among them.

No setting is best for all data: where branches of a path run side by side a canyon has to be
narrow, where paths begin far apart it has to be wide. A linear solve takes a tenth of a second. So
several are made, the most promising is refined, and the best that is proved for its destinations is
kept.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import ceil
from typing import NamedTuple

import numpy as np

from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.general.band import fitted_coefficients
from handsim.learning.general.potential import Remaining, Wishes, canyon, cost_to_go
from handsim.learning.general.refinement import Tried, refined, tried
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import STEP
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.workspace import lay_basis
from handsim.types import Array

_DEGREE = 3
_CELLS = {1: 30, 2: 22, 3: 6}  # along the longest side of the paths' box
MOST_DIMENSIONS = max(_CELLS)
"""In more the bands of `band` are too wide, and directions are fitted instead."""
_N_REFINED = 1
_SHRUNK = (0.97, 0.9, 0.75, 0.5)  # factors of chi tried where a field is not proved
_N_SHRUNK = 2
_N_COMPARED = 2  # proved fields that are followed in short steps
_Proof = Callable[[NavigationFunction], bool]


class _Canyon(NamedTuple):
    """Width and depth of `canyon`, weights of `fitted_coefficients`, cells beyond the paths."""

    width: float
    depth: float
    slope: float
    reach: float


_CANYONS = (
    _Canyon(0.015, 0.2, 3e-6, 2.0),
    _Canyon(0.02, 0.3, 1e-5, 1.2),
    _Canyon(0.02, 0.5, 3e-5, 2.0),
    _Canyon(0.028, 0.3, 3e-5, 2.0),
    _Canyon(0.03, 0.3, 3e-5, 1.2),
    _Canyon(0.04, 0.3, 1e-4, 2.0),
)
_LEAVING = (6.0, 12.0, 20.0)  # of `cost_to_go`
_IN_SPACE = slice(
    1, None, 2
)  # of those for paths in three dimensions, where a solve takes a second
_BEND = 1e-7


def towards_one(
    paths: Sequence[Array], k: float, n_rounds: int, seed: int
) -> Iterator[list[Tried]]:
    """Yield fields to the one destination of all paths: first drafts, then refined ones."""
    drafts = list(_drafts(paths, k, seed))
    yield drafts
    best = sorted(drafts, key=_merit, reverse=True)[:_N_REFINED]
    for draft in best:
        yield refined(draft, paths, n_rounds)
    level = straight(paths, k)
    yield [level, *refined(level, paths, n_rounds)]


def towards_many(paths: Sequence[Array], k: float, seed: int) -> Iterator[list[Tried]]:
    """Yield fields to the destinations of paths, each of which may have its own."""
    for certified in (False, True):
        learner = DirectionLearner(k=k, seed=seed, certified=certified).fit(paths)
        name = "directions" + (", held to the descent condition" if certified else "")
        yield [tried(learner.navigation_, paths, name)]


def straight(paths: Sequence[Array], k: float) -> Tried:
    """Return the field of straight lines, which is proved wherever a destination may lie."""
    basis, width = _laid(paths, 1.2)
    return _field(paths, basis, width, np.zeros(basis.n_coefficients), k, "straight lines")


def best_proved(fields: Sequence[Tried], paths: Sequence[Array], is_proved: _Proof) -> Tried | None:
    """Return the best field that is proved, shrunk if that is better than any as it is.

    chi times a small enough factor meets the descent condition. Fields are ranked by roll-outs in
    long steps, and those that come to be chosen from are followed again in short ones.
    """
    proved, failed = list[Tried](), list[Tried]()
    for each in sorted(fields, key=_merit, reverse=True):
        if is_proved(each.navigation):
            proved.append(tried(each.navigation, paths, each.origin, STEP))
        else:
            failed.append(each)
        if len(proved) == _N_COMPARED:
            break
    for each in failed[:_N_SHRUNK]:
        for factor in _SHRUNK:
            less = tried(_times(each.navigation, factor), paths, f"{each.origin}, x {factor:g}")
            if any(less.merit <= other.merit for other in proved):
                break
            if is_proved(less.navigation):
                proved.append(tried(less.navigation, paths, less.origin, STEP))
                break
    return max(proved, key=_merit, default=None)


def _merit(field: Tried) -> tuple[int, float]:
    return field.merit


def _drafts(paths: Sequence[Array], k: float, seed: int) -> Iterator[Tried]:
    """Yield what linear solves give."""
    remaining, rng = Remaining(paths), np.random.default_rng(seed)
    few = _IN_SPACE if paths[0].shape[1] > 2 else slice(None)
    for setting in _CANYONS[few]:
        basis, width = _laid(paths, setting.reach)
        wishes = canyon(remaining, setting.width, setting.depth, rng)
        c = _solved(basis, [wishes], setting.slope)
        name = f"canyon {setting.width:g} wide"
        yield _field(paths, basis, width, c, k, name)
    basis, width = _laid(paths, 1.2)
    for leaving in _LEAVING[few]:
        c = _solved(basis, cost_to_go(remaining, basis, leaving), 0.0)
        yield _field(paths, basis, width, c, k, f"cost to go, {leaving:g} x aside")


def _solved(basis: TensorBasis, wishes: Sequence[Wishes], slope: float) -> Array:
    points = np.vstack([each.points for each in wishes])
    values = np.concatenate([each.values for each in wishes])
    weights = np.concatenate([each.weights for each in wishes])
    return fitted_coefficients(basis, points, values, weights, _BEND, slope)


def _field(
    paths: Sequence[Array], basis: TensorBasis, width: Array, c: Array, k: float, origin: str
) -> Tried:
    obstacle = ExponentialObstacle(TensorBSpline(basis, c), width)
    return tried(NavigationFunction(obstacle, k), paths, origin)


def _laid(paths: Sequence[Array], reach: float) -> tuple[TensorBasis, Array]:
    """Lay knots in cells that are about cubes."""
    points = np.vstack(paths)
    extent = points.max(axis=0) - points.min(axis=0)
    n = len(extent)
    if n > MOST_DIMENSIONS:  # for straight lines only
        return lay_basis(list(paths), reach=reach)
    cell = extent.max() / _CELLS[n]
    beyond = _DEGREE + ceil(2 * reach)
    shape = tuple(ceil(float(side / cell)) + beyond for side in extent)
    return lay_basis(list(paths), shape, reach=reach)


def _times(navigation: NavigationFunction, factor: float) -> NavigationFunction:
    """Return the navigation function with chi times a factor."""
    obstacle = navigation.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    chi = TensorBSpline(obstacle.chi.basis, factor * obstacle.chi.coefficients)
    return replace(navigation, obstacle=ExponentialObstacle(chi, obstacle.width))

"""The potential that paths to one destination ask for, as values at points.

The flow of phi climbs psi = chi - ln gamma_d. Along a path psi may rise as one likes, as long as it
rises to infinity at the end: psi = -2 ln l does, with l the length that is left. Then all paths to
one destination agree wherever they are as far from it, and a spline through

    chi = 2 ln |z - z_goal| - 2 ln l

is found by one linear solve. Beside the paths psi falls, so that they attract. There are two kinds
of wishes for what lies there and beyond:

- a *canyon*: values on the paths and at displaced points near them, on which psi is lower. Nothing
  is asked elsewhere; the membrane of `band` spreads chi there without bumps of its own.
- the *cost to go*: everywhere psi = -2 ln min_j (l_j + c d_j), with d_j the distance to point j of
  a path. Leaving a path costs c times as much as going along it, so that no path is cut short as
  long as c is greater than the ratio of a detour and its shortcut. It has no minimum of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.learning.fit.field_samples import random_normals
from handsim.navigation.bspline import TensorBasis
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.reproducible import dots, exp, log, mean, norms, total, units
from handsim.types import Array

_N_PER_PATH = 80  # points of each path
_LAST_FRACTION = 0.98  # of a path: beyond, l is too small a number
_ALIKE = 0.1  # distance of paths, by mean lengths, over which they share their length
_SAME_BRANCH = 0.1  # of the mean length: farther apart along a path is another branch of it
_NEAREST = 0.02  # to the destination, by mean lengths, at which a value is asked for
_ROUND = 0.02  # radius of the bottom of the cost to go, by mean lengths
_GRID = {1: 100, 2: 40, 3: 16}  # points along each dimension at which the cost to go is asked for
_GRID_WEIGHT = 0.02  # of all of them together, relative to the paths


@dataclass(frozen=True)
class Wishes:
    """Values of chi that are asked for.

    Attributes
    ----------
    points : (N, n) [rad]
    values, weights : (N,)
    """

    points: Array
    values: Array
    weights: Array


class Remaining:
    """Points of all paths and the length that is left from each.

    Paths that run close to each other share their length: neighbours are to agree.

    Parameters
    ----------
    paths
        (n_i, n) [rad], to one destination.

    Attributes
    ----------
    goal : (n,) [rad]
    mean_length : [rad]
    points, left : (paths, 80, n), (paths, 80) [rad]
    fractions : (80,)
    """

    def __init__(self, paths: Sequence[Array]) -> None:
        self.goal = paths[0][-1]
        self.fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
        self.points = np.array([at_arc_length(path, self.fractions) for path in paths])
        own = np.array([arc_length(path)[-1] for path in paths])
        self.mean_length = float(mean(own))
        apart = self.points[:, None] - self.points[None]
        squares = mean(dots(apart, apart), -1) / (_ALIKE * self.mean_length) ** 2
        share = exp(-0.5 * squares)
        lengths = total(share * own, 1) / total(share, 1)
        self.left = lengths[:, None] * (1.0 - self.fractions)

    def distances(self, z: Array) -> Array:
        """Return the distances (N, paths * 80) of points (N, n) from those of the paths."""
        flat = self.points.reshape(-1, z.shape[1])
        square = np.zeros((len(z), len(flat)))
        for i in range(z.shape[1]):
            away = z[:, i, None] - flat[:, i]
            square += away * away
        return np.sqrt(square)

    def wished(self, z: Array, left: Array, lower: Array, weight: float) -> Wishes:
        """Return chi for psi = -2 ln left - lower at points, but next to the destination."""
        away = norms(z - self.goal)[:, 0]
        use = (away > _NEAREST * self.mean_length) & (left > 0.0)
        values = 2.0 * log(away[use] / left[use]) - lower[use]
        return Wishes(z[use], values, np.full(len(values), weight / max(len(values), 1)))


def canyon(remaining: Remaining, width: float, depth: float, rng: np.random.Generator) -> Wishes:
    """Ask for psi on the paths, and for less of it beside them.

    Parameters
    ----------
    remaining
    width
        Of the canyon to each side, by mean lengths of the paths.
    depth
        By how much psi is lower at its edge.
    rng
    """
    use = remaining.fractions < _LAST_FRACTION
    radius = width * remaining.mean_length
    n = remaining.points.shape[-1]
    points = [remaining.points[:, use].reshape(-1, n)]
    left = remaining.left[:, use].ravel()
    lefts, lowers = [left], [np.zeros_like(left)]
    tangents = units(np.gradient(remaining.points, axis=1))[:, use].reshape(-1, n)
    all_left = remaining.left.ravel()
    for _ in range(n - 1):
        normals = random_normals(tangents, rng)
        for offset in (0.5, -0.5, 1.0, -1.0):
            z = points[0] + offset * radius * normals
            distance = remaining.distances(z)
            nearest = np.argmin(distance, axis=1)
            own = np.abs(all_left[nearest] - left) < _SAME_BRANCH * remaining.mean_length
            aside = distance[np.arange(len(z)), nearest][own] / radius
            points.append(z[own])
            lefts.append(all_left[nearest][own])
            lowers.append(depth * aside * aside)
    return remaining.wished(np.vstack(points), np.concatenate(lefts), np.concatenate(lowers), 1.0)


def cost_to_go(remaining: Remaining, basis: TensorBasis, leaving: float) -> list[Wishes]:
    """Ask for psi on the paths and on a grid over the workspace.

    Parameters
    ----------
    remaining
    basis
        Of chi.
    leaving
        Cost of a distance from the paths relative to one along them.
    """
    n = len(basis.shape)
    axes = [np.linspace(a, b, _GRID[n]) for a, b in zip(basis.lower, basis.upper, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)
    use = remaining.fractions < _LAST_FRACTION
    result: list[Wishes] = []
    for z, weight in ((grid, _GRID_WEIGHT), (remaining.points[:, use].reshape(-1, n), 1.0)):
        cost = np.empty(len(z))
        for first in range(0, len(z), 1000):
            part = slice(first, first + 1000)
            distance = remaining.distances(z[part])
            bottom = _ROUND * remaining.mean_length
            rounded = np.sqrt(distance * distance + bottom * bottom) - bottom
            cost[part] = (remaining.left.ravel() + leaving * rounded).min(axis=1)
        result.append(remaining.wished(z, cost, np.zeros(len(z)), weight))
    return result

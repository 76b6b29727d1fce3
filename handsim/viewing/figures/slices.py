"""Planes through the workspace, and the fields of a navigation function on them."""

from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.navigation.function import NavigationFunction
from handsim.types import Array


@dataclass(frozen=True, eq=False)
class Slice:
    """A grid of points on a plane along two components, over the whole workspace.

    Fields on it have one row for each value of ``second`` and one column for each of ``first``, as
    matplotlib takes them.

    Attributes
    ----------
    components
        The two that vary, from 0.
    first, second : (m,) [rad]
        Coordinates along them.
    points : (m * m, n) [rad]
        Row after row.
    """

    components: tuple[int, int]
    first: Array
    second: Array
    points: Array

    def ln_beta(self, navigation: NavigationFunction) -> Array:
        """Return ln of the obstacle function, (m, m)."""
        return self._rows(navigation.obstacle.log_jets(self.points, navigation.k, 0)[0])

    def phi(self, navigation: NavigationFunction, z_goal: Array) -> Array:
        """Return the navigation function to a destination (n,) [rad], (m, m)."""
        return self._rows(navigation.jets(self.points, z_goal, 0)[0])

    def flow(self, navigation: NavigationFunction, z_goal: Array) -> Array:
        """Return the part in the plane of the unit flow to a destination (n,) [rad], (m, m, 2)."""
        directions = navigation.directions(self.points, z_goal)
        return self._rows(directions[:, list(self.components)])

    def _rows(self, values: Array) -> Array:
        return values.reshape(len(self.second), len(self.first), *values.shape[1:])


def slice_through(
    navigation: NavigationFunction,
    point: Array,
    components: tuple[int, int] = (0, 1),
    resolution: int = 121,
) -> Slice:
    """Lay a plane along two components through a point.

    Parameters
    ----------
    navigation
        Its workspace is what the plane spans.
    point : (n,) [rad]
        Gives the components that do not vary.
    components
        The two that vary, from 0.
    resolution
        Points along each.

    Raises
    ------
    InputError
        If the components are not two different ones of the subspace.
    """
    n = navigation.n_dimensions
    i, j = components
    if i == j or not (0 <= i < n and 0 <= j < n):
        raise InputError(f"components {components}; give two different ones of 0 to {n - 1}")
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    first = np.linspace(float(low[i]), float(high[i]), resolution)
    second = np.linspace(float(low[j]), float(high[j]), resolution)
    points = np.tile(point, (resolution**2, 1))
    points[:, i], points[:, j] = np.tile(first, resolution), np.repeat(second, resolution)
    return Slice((i, j), first, second, points)


def level_shell(
    navigation: NavigationFunction, z_goal: Array, level: float, resolution: int = 25
) -> Array:
    """Return the level set of phi about a destination, in three dimensions.

    Along each ray from the destination it is where phi first reaches the level; a ray along which
    it does not ends at the workspace.

    Parameters
    ----------
    navigation
        Of three dimensions.
    z_goal : (3,) [rad]
    level
        Between 0 and 1.
    resolution
        Rays from pole to pole; there are twice as many around.

    Returns
    -------
    (resolution, 2 * resolution, 3) [rad]
    """
    if navigation.n_dimensions != 3:
        raise InputError(f"shells of {navigation.n_dimensions} dimensions; give three")
    polar = np.linspace(0, np.pi, resolution)[:, None]
    around = np.linspace(0, 2 * np.pi, 2 * resolution)[None]
    rays = np.stack(
        [
            np.sin(polar) * np.cos(around),
            np.sin(polar) * np.sin(around),
            np.cos(polar) + 0 * around,
        ],
        axis=-1,
    ).reshape(-1, 3)
    low, high = navigation.obstacle.lower - z_goal, navigation.obstacle.upper - z_goal
    safe = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
    reach = np.maximum(low / safe, high / safe).min(axis=1)
    shares = np.linspace(0.0, 1.0, 41)[1:]
    points = z_goal + (shares[:, None, None] * reach[:, None] * rays).reshape(-1, 3)
    phi = navigation.jets(points, z_goal, 0)[0].reshape(len(shares), len(rays))
    phi = np.vstack([np.zeros(len(rays)), phi])
    beyond = phi >= level
    first = np.where(beyond.any(axis=0), beyond.argmax(axis=0), len(shares))
    column = np.arange(len(rays))
    before, after = phi[first - 1, column], phi[first, column]
    part = np.clip((level - before) / np.maximum(after - before, 1e-12), 0.0, 1.0)
    radius = reach * (first - 1 + part) / len(shares)
    return (z_goal + radius[:, None] * rays).reshape(resolution, 2 * resolution, 3)

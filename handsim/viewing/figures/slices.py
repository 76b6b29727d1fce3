"""What was learned, as data to be looked at: the content of the paper's Figs. 1b, 3, 4, 5 and 7."""

from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.joints import N_JOINTS
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.function import NavigationFunction
from handsim.types import Array


@dataclass(frozen=True)
class Slice:
    """Fields on a plane through the destination, along two components.

    Attributes
    ----------
    first, second : (m,) [rad]
        Coordinates along the two components.
    ln_beta, phi : (m, m)
        ln of the obstacle function and the navigation function; row i is ``first[i]``. The level
        sets of ``phi`` are those of Fig. 1b.
    flow : (m, m, 2)
        Part of the unit flow -grad phi / |grad phi| that lies in the plane.
    """

    first: Array
    second: Array
    ln_beta: Array
    phi: Array
    flow: Array


def slice_through(
    navigation: NavigationFunction,
    z_goal: Array,
    components: tuple[int, int] = (0, 1),
    resolution: int = 61,
) -> Slice:
    """Sample obstacle, navigation function and flow on a plane through the destination.

    Parameters
    ----------
    navigation
    z_goal : (n,) [rad]
    components
        The two that vary, from 0; the others stay at the destination.
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
    first, second = (np.linspace(low[c], high[c], resolution) for c in components)
    z = np.tile(navigation.check_goal(z_goal), (resolution**2, 1))
    z[:, i], z[:, j] = np.repeat(first, resolution), np.tile(second, resolution)
    square = (resolution, resolution)
    return Slice(
        first=first,
        second=second,
        ln_beta=navigation.obstacle.log_jets(z, navigation.k, 0)[0].reshape(square),
        phi=navigation.jets(z, z_goal, 0)[0].reshape(square),
        flow=navigation.directions(z, z_goal)[:, [i, j]].reshape(*square, 2),
    )


def flow_lattice(
    navigation: NavigationFunction, z_goal: Array, per_dimension: int = 8
) -> tuple[Array, Array, Array]:
    """Return points (N, n) [rad], unit flow (N, n) and phi (N,) on a lattice (Fig. 4)."""
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    inner = np.linspace(0.0, 1.0, per_dimension + 2)[1:-1]
    axes = [a + (b - a) * inner for a, b in zip(low, high, strict=True)]
    z = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(low))
    return z, navigation.directions(z, z_goal), navigation.jets(z, z_goal, 0)[0]


def eigengrasps(subspace: PostureSubspace, deviations: float = 2.0) -> Array:
    """Return postures (n_components, 2, 22) [rad], each component at minus and plus deviations.

    Parameters
    ----------
    subspace
    deviations
        Distance from the mean posture, in standard deviations of the recordings.
    """
    reach = deviations * np.sqrt(subspace.explained_variance_)
    ends = np.stack([-np.diag(reach), np.diag(reach)], axis=1)
    return subspace.inverse_transform(ends)


def cumulative_variance(q: Array) -> Array:
    """Return the fraction of variance in the first 1, 2, ... 22 components (Fig. 5), (22,).

    Parameters
    ----------
    q : (n, 22) [rad]
    """
    deviation = q - q.mean(axis=0)
    singular = np.zeros(N_JOINTS)
    found = np.linalg.svd(deviation, compute_uv=False)
    singular[: len(found)] = found
    total = np.cumsum(singular**2)
    return total / max(float(total[-1]), np.finfo(float).tiny)

"""Critical points of a navigation function, which may trap the flow.

They are looked for where a field cannot be certified. A critical point other than the destination
is a zero of v = gamma_d grad(ln beta) / k - grad gamma_d. The Hessian of phi there tells a minimum,
in which the flow ends, from a saddle and a maximum, which almost all paths leave.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from handsim.navigation.function import NavigationFunction
from handsim.types import Array

Kind = Literal["minimum", "saddle", "maximum", "degenerate"]

_NEWTON_STEPS = 40
_LONGEST_STEP = np.deg2rad(5.0)
_SAME = np.deg2rad(0.1)  # closer zeros are one critical point


@dataclass(frozen=True)
class CriticalPoint:
    """A zero of grad phi other than the destination.

    Attributes
    ----------
    z : (n,) [rad]
    kind
        By the signs of the Hessian's eigenvalues; ``degenerate`` if one is next to zero.
    eigenvalues : (n,)
        Of the Hessian of phi, increasing.
    """

    z: Array
    kind: Kind
    eigenvalues: Array


def grid(navigation: NavigationFunction, per_dimension: int) -> Array:
    """Return the centres (per_dimension**n, n) of equal boxes that fill the workspace."""
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    fractions = (np.arange(per_dimension) + 0.5) / per_dimension
    axes = [a + (b - a) * fractions for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(low))


def critical_points(
    navigation: NavigationFunction, z_goal: Array, starts: Array
) -> list[CriticalPoint]:
    """Search critical points other than the destination by Newton's method from many starts.

    Parameters
    ----------
    navigation
    z_goal : (n,) [rad]
    starts : (N, n) [rad]
        A search finds what is near enough to a start; it proves nothing.
    """
    z = np.array(starts, dtype=float)
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    for _ in range(_NEWTON_STEPS):
        residual, jacobian = _zero_function(navigation, z, z_goal)
        # A floor under the singular values keeps steps finite where the Jacobian degenerates.
        step = -np.einsum("nij,nj->ni", np.linalg.pinv(jacobian, rcond=1e-10), residual)
        length = np.linalg.norm(step, axis=1, keepdims=True)
        step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(length, 1e-300))
        z = np.clip(z + step, low, high)
    residual, jacobian = _zero_function(navigation, z, z_goal)
    scale = np.linalg.norm(jacobian, axis=(1, 2))
    converged = np.linalg.norm(residual, axis=1) < 1e-8 * scale
    inside = ((z > low + 1e-9) & (z < high - 1e-9)).all(axis=1)
    away = np.linalg.norm(z - z_goal, axis=1) > _SAME
    return [
        _classified(navigation, one, z_goal) for one in _different(z[converged & inside & away])
    ]


def _zero_function(navigation: NavigationFunction, z: Array, z_goal: Array) -> tuple[Array, Array]:
    """v (N, n) and its Jacobian (N, n, n)."""
    k = navigation.k
    _, grad_ln, hess_ln = navigation.obstacle.log_jets(z, k, 2)
    gamma, pull = navigation.attraction(z, z_goal)
    residual = (gamma / k)[:, None] * grad_ln - 2.0 * pull
    jacobian = (2.0 / k) * grad_ln[:, :, None] * pull[:, None, :]
    jacobian += (gamma / k)[:, None, None] * hess_ln - 2.0 * navigation.metrics(z_goal)
    return residual, jacobian


def _classified(navigation: NavigationFunction, z: Array, z_goal: Array) -> CriticalPoint:
    eigenvalues: Array = np.linalg.eigvalsh(navigation.jets(z[None], z_goal, 2)[2][0]).astype(float)
    kind: Kind = "saddle"
    if np.abs(eigenvalues).min() < 1e-6 * np.abs(eigenvalues).max():
        kind = "degenerate"
    elif eigenvalues[0] > 0:
        kind = "minimum"
    elif eigenvalues[-1] < 0:
        kind = "maximum"
    return CriticalPoint(z, kind, eigenvalues)


def _different(points: Array) -> list[Array]:
    kept: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) > _SAME for other in kept):
            kept.append(point)
    return kept

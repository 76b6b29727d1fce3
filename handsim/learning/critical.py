"""Where a navigation function might trap: its critical points, and the starts that do not arrive.

For fields that cannot be certified. A critical point other than the destination is a zero of
v = gamma_d grad(ln beta) / k - grad gamma_d; the Hessian of phi there tells a minimum, a trap, from
a saddle and a maximum, which repel almost everything.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from handsim.learning.certificate import certify
from handsim.learning.controller import GraspController
from handsim.learning.navigation import NavigationFunction
from handsim.learning.paths import FlowPath, follow

Array = npt.NDArray[np.float64]
Kind = Literal["minimum", "saddle", "maximum", "degenerate"]

_NEWTON_STEPS = 40
_LONGEST_STEP = np.deg2rad(5.0)
_SAME = np.deg2rad(0.1)  # closer zeros are one critical point
_MAX_LISTED = 100  # minima listed by `certification`, so that its answer stays readable


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


def not_arriving(
    navigation: NavigationFunction, z_goal: Array, starts: Array
) -> tuple[Array, list[FlowPath]]:
    """Return the starts (m, n) whose paths do not arrive, and those paths."""
    paths = follow(navigation.directions, starts, np.broadcast_to(z_goal, starts.shape))
    lost = [i for i, path in enumerate(paths) if not path.arrived]
    return starts[lost], [paths[i] for i in lost]


def certification(
    controller: GraspController,
    per_dimension: int = 5,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Certify a controller; where that fails, look for what traps it.

    Parameters
    ----------
    controller
    per_dimension
        Starts along each dimension of the grid.
    progress
        Called with the fraction done.

    Returns
    -------
    dict
        ``k``; ``k_min``, the least exponent with which the proof succeeds, None if none;
        ``certified``; ``reason``; ``supremum``, the proven bound of the descent quantity;
        ``n_minima`` (the destinations themselves among them)``, n_saddles, n_maxima`` over all
        destinations; ``other_minima``: name of the destination and place [deg] of the traps found
        (at most 100); ``starts`` on a grid times destinations, and the ``arrivals`` among them;
        ``lost_starts`` as ``other_minima``.
    """
    navigation = controller.navigation
    goals = np.array([d.z_goal for d in controller.demonstrations])
    proof = certify(navigation, goals)
    starts = grid(navigation, per_dimension)
    counts = {"minimum": 0, "saddle": 0, "maximum": 0, "degenerate": 0}
    traps: list[dict[str, Any]] = []
    lost_starts: list[dict[str, Any]] = []
    for i, demonstration in enumerate(controller.demonstrations):
        if progress:
            progress(i / len(goals))
        goal = demonstration.z_goal
        lost, paths = not_arriving(navigation, goal, starts)
        lost_starts += [_place(demonstration.name, z) for z in lost]
        counts["minimum"] += 1
        if proof.certified:  # there is nothing to be found
            continue
        ends = np.array([path.points[-1] for path in paths]).reshape(-1, starts.shape[1])
        for found in critical_points(navigation, goal, np.vstack([starts, ends])):
            counts[found.kind] += 1
            if found.kind == "minimum":
                traps.append(_place(demonstration.name, found.z))
    n_runs = len(starts) * len(goals)
    return {
        "k": navigation.k,
        "k_min": proof.k_min,
        "certified": proof.certified,
        "reason": proof.reason,
        "supremum": None if proof.supremum is None else proof.supremum.upper,
        "n_minima": counts["minimum"],
        "n_saddles": counts["saddle"],
        "n_maxima": counts["maximum"],
        "other_minima": traps[:_MAX_LISTED],
        "starts": n_runs,
        "arrivals": n_runs - len(lost_starts),
        "lost_starts": lost_starts[:_MAX_LISTED],
    }


def _place(name: str, z: Array) -> dict[str, Any]:
    return {"destination": name, "z_deg": [round(float(x), 2) for x in np.rad2deg(z)]}


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

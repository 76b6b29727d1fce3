"""The paper's inverse problem: the experiments E, the functional J and what surrounds it.

Eq. (8), on recorded points x with velocities u and destinations q_d,

    grad beta = (k u / gamma_d) (gamma_d^k + beta)^(1/k + 1) + (k grad gamma_d / gamma_d) beta

and its least-squares form J of Sec. V-B.2. Corrections to the paper are listed in `pde_fit`.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handsim.learning.direction.samples import random_normals
from handsim.learning.fit.designs import JetDesign
from handsim.navigation.bspline import TensorBasis
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.reproducible import dots, norms, powers, total, units
from handsim.types import Array

_N_PER_PATH = 60
_REST = 0.15  # of a path's peak speed: slower samples are rest, not motion


@dataclass(frozen=True)
class Experiments:
    """The paper's E = {X, U, q_d}: points, velocities and destinations, (N, n) each."""

    points: Array
    velocities: Array
    goals: Array

    def __add__(self, other: "Experiments") -> "Experiments":
        """Return both together."""
        return Experiments(
            np.vstack([self.points, other.points]),
            np.vstack([self.velocities, other.velocities]),
            np.vstack([self.goals, other.goals]),
        )


class Functional:
    """J of Sec. V-B.2 and its gradient by the coefficients.

    Parameters
    ----------
    basis
    experiments
        Points at which the PDE is asked for.
    destinations : (m, n)
    k, weights, floor
        Exponent, w1 to w4, beta_0.
    """

    def __init__(
        self,
        basis: TensorBasis,
        experiments: Experiments,
        destinations: Array,
        k: float,
        weights: tuple[float, float, float, float],
        floor: float,
    ) -> None:
        self.basis, self.k, self.weights, self.floor = basis, k, weights, floor
        away = experiments.points - experiments.goals
        gamma = dots(away, away)
        self._gamma_k = powers(gamma, k)
        self._drive = k * experiments.velocities / gamma[:, None]  # k u / gamma_d
        self._pull = 2.0 * k * away / gamma[:, None]  # k grad gamma_d / gamma_d
        self._at_points = JetDesign(basis, experiments.points)
        self._at_goals = JetDesign(basis, destinations)
        self._at_boundary = JetDesign(basis, boundary_points(basis))

    def __call__(self, c: Array) -> tuple[float, Array]:
        """Return J and its gradient."""
        w_pde, w_sp, w_dp, w_bn = self.weights
        beta, residual, by_beta = self._residual(c)
        weighted = (2.0 * w_pde / self._gamma_k)[:, None] * residual
        value = 0.5 * float(total(dots(weighted, residual)))
        slope_beta = dots(weighted, by_beta)
        low, low_slope = switch(beta - self.floor)
        value += w_sp * float(total(low))
        gradient = self._at_points.pulled_back(slope_beta + w_sp * low_slope, weighted.T)
        low, low_slope = switch(self._at_goals(c)[0] - self.floor)
        value += w_dp * float(total(low))
        gradient += self._at_goals.pulled_back(w_dp * low_slope)
        if w_bn > 0.0:
            high, high_slope = switch(-self._at_boundary(c)[0])
            value += w_bn * float(total(high))
            gradient -= self._at_boundary.pulled_back(w_bn * high_slope)
        return value / len(beta), gradient / len(beta)

    def parts(self, c: Array) -> dict[str, float]:
        """Return the four sums of J, without weights."""
        beta, residual, _ = self._residual(c)
        return {
            "J_PDE": float(total(dots(residual, residual) / self._gamma_k)),
            "J_sp": float(total(switch(beta - self.floor)[0])),
            "J_dp": float(total(switch(self._at_goals(c)[0] - self.floor)[0])),
            "J_bn": float(total(switch(-self._at_boundary(c)[0])[0])),
        }

    def _residual(self, c: Array) -> tuple[Array, Array, Array]:
        """Beta (N,), the residual of Eq. (8) (N, n) and its derivative by beta (N, n).

        Below beta = -gamma_d^k the root is not real; its argument is taken as 0 there.
        """
        beta, slopes = self._at_points(c)
        grad = slopes.T
        argument = np.maximum(self._gamma_k + beta, 0.0)
        power = powers(argument, 1.0 / self.k)
        residual = grad - self._drive * (argument * power)[:, None] - self._pull * beta[:, None]
        by_beta = -self._drive * ((1.0 + 1.0 / self.k) * power)[:, None] - self._pull
        return beta, residual, by_beta


def switch(x: Array) -> tuple[Array, Array]:
    """Return s(x) = |x|^3 for x <= 0 and 0 above, and its derivative (the paper prints x^3)."""
    below = np.minimum(x, 0.0)
    return -(below * below * below), -3.0 * below * below


def forward_differences(time: Array, path: Array) -> tuple[Array, Array, Array]:
    """Return points (m, n), velocities (m, n) and destination (n,) of a recorded path (m + 1, n).

    The paper's III-A: forward differences, the last point is the destination and has no velocity.
    """
    return path[:-1], np.diff(path, axis=0) / np.diff(time)[:, None], path[-1]


def remaining_speeds(paths: list[Array], phi_max: float, cut: float) -> Experiments:
    """Return the experiments with speeds in proportion to the arc length left, |u| = rate l.

    Its integral along a path is rate * length^2 / 2; ``rate`` is common to all paths.

    Parameters
    ----------
    paths
        (n_i, n), each ending at its destination.
    phi_max
        Largest path integral of speed.
    cut
        Fraction of arc length left out at the end.
    """
    fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
    use = fractions <= 1.0 - cut
    rate = phi_max / max(0.5 * arc_length(path)[-1] ** 2 for path in paths)
    parts = []
    for path in paths:
        points = at_arc_length(path, fractions)
        left = arc_length(path)[-1] * (1.0 - fractions)[:, None]
        velocities = rate * left * units(np.gradient(points, axis=0))
        goals = np.broadcast_to(path[-1], points.shape)
        parts.append(Experiments(points[use], velocities[use], goals[use]))
    return _together(parts)


def measured_speeds(
    paths: list[Array], times: list[Array], phi_max: float, cut: float
) -> Experiments:
    """Return the experiments with velocities as measured, slower than 15 % of the peak left out.

    Parameters as in `remaining_speeds`; ``times`` are (n_i,) [s].
    """
    parts, integrals = [], []
    for path, time in zip(paths, times, strict=True):
        points, velocities, goal = forward_differences(time, path)
        speed = norms(velocities)[:, 0]
        length = arc_length(path)
        integrals.append(float(total(speed * np.diff(length))))
        use = (speed > _REST * speed.max()) & (length[:-1] <= (1.0 - cut) * length[-1])
        goals = np.broadcast_to(goal, points.shape)
        parts.append(Experiments(points[use], velocities[use], goals[use]))
    together = _together(parts)
    scale = phi_max / max(integrals)
    return Experiments(together.points, scale * together.velocities, together.goals)


def beside(experiments: Experiments, rng: np.random.Generator) -> Experiments:
    """Points up to 10 deg beside the path, whose velocities lead back to it."""
    parts = []
    speed = norms(experiments.velocities)
    tangent = units(experiments.velocities)
    left = norms(experiments.points - experiments.goals)
    if experiments.points.shape[1] == 1:  # on a line there is no side
        return experiments
    for _ in range(4):
        beyond = np.minimum(0.1, 0.3 * left) * rng.random((len(left), 1))
        aside = random_normals(tangent, rng) * beyond
        velocities = speed * units(tangent - 6.0 * aside)
        parts.append(Experiments(experiments.points + aside, velocities, experiments.goals))
    return _together(parts)


def boundary_points(basis: TensorBasis, per_dimension: int = 7) -> Array:
    """Return points on all faces of the workspace."""
    n = len(basis.shape)
    low, high = basis.lower, basis.upper
    axes = [np.linspace(a, b, per_dimension) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)
    return grid[((grid == low) | (grid == high)).any(axis=1)]


def vanishing_on_boundary(basis: TensorBasis) -> npt.NDArray[np.bool_]:
    """Return which coefficients (prod(m_i),) have splines that vanish on the boundary.

    As long as the others stay 0, so does beta there: Eq. (5) by construction (V-A.2).
    """
    grids = np.meshgrid(*[np.arange(m) for m in basis.shape], indexing="ij")
    p = basis.degree
    inner = [(g >= p) & (g < m - p) for g, m in zip(grids, basis.shape, strict=True)]
    return np.logical_and.reduce(inner).ravel()


def _together(parts: list[Experiments]) -> Experiments:
    return Experiments(
        np.vstack([part.points for part in parts]),
        np.vstack([part.velocities for part in parts]),
        np.vstack([part.goals for part in parts]),
    )

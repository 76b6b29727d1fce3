"""The paper's inverse problem: the experiments E, the functional J, the boundary conditions.

Eq. (3) asks that u = -grad phi on recorded points x with velocities u and destinations q_d. Solved
for grad beta (Eqs. 6 and 7) and with phi of Eq. (2) this is Eq. (8),

    grad beta = (k u / gamma_d) (gamma_d^k + beta)^(1/k + 1) + (k grad gamma_d / gamma_d) beta

and its least-squares form J of Sec. V-B.2. All corrections to the paper are listed in
`learning.pde.learner`, and each is named again where it is made.
"""

from collections.abc import Sequence

import numpy as np

from handsim.errors import InputError
from handsim.learning.fit.designs import JetDesign
from handsim.learning.fit.field_samples import FieldSamples, random_normals
from handsim.navigation.bspline import TensorBasis
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.reproducible import dots, norms, powers, total, units
from handsim.types import Array, Mask

_N_PER_PATH = 60
_REST = 0.15  # of a path's peak speed: slower samples are rest, not motion
_PULL = 6.0  # back to the path, per displacement (in units of 100 deg)


class Functional:
    """J of Sec. V-B.2 and its gradient by the coefficients.

    J = (w1 J_PDE + w2 J_sp + w3 J_dp + w4 J_bn) / N with

    - J_PDE = sum |residual of Eq. (8)|^2 / gamma_d^k,
    - J_sp = sum s(beta - beta_0) over the points, for Eq. (4),
    - J_dp = sum s(beta - beta_0) over the destinations, for Eq. (4),
    - J_bn = sum s(-beta) over the boundary, for Eq. (5); the paper prints s(beta), which would
      penalise the negative beta that it asks for,

    and s as `switch`. The paper stacks the coefficients of Eq. (9) into a vector of sum(m_i)
    numbers; there are prod(m_i).

    Parameters
    ----------
    basis
    experiments
        Points, velocities and destinations with which Eq. (8) should hold; no point is
        a destination, where 1 / gamma_d^k is infinite.
    destinations : (m, n)
    k, weights, floor
        Exponent, w1 to w4, beta_0.
    """

    def __init__(
        self,
        basis: TensorBasis,
        experiments: FieldSamples,
        destinations: Array,
        k: float,
        weights: tuple[float, float, float, float],
        floor: float,
    ) -> None:
        self.basis, self.k, self.weights, self.floor = basis, k, weights, floor
        away = experiments.points - experiments.goals
        gamma = dots(away, away)
        self._gamma_k = powers(gamma, k)
        self._drive = k * experiments.vectors / gamma[:, None]  # k u / gamma_d
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
        """Return beta (N,), the residual of Eq. (8) (N, n) and its derivative by beta (N, n).

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
    """Return s(x) = |x|^3 for x <= 0 and 0 above, and its derivative.

    The paper (Sec. V-B.2) prints x^3, which is negative: minimising it would drive beta to
    minus infinity.
    """
    below = np.minimum(x, 0.0)
    return -(below * below * below), -3.0 * below * below


def forward_differences(time: Array, path: Array) -> tuple[Array, Array, Array]:
    """Return points (m, n), velocities (m, n) and destination (n,) of a recorded path (m + 1, n).

    The paper's Sec. III-A: the velocities are forward differences; the last point is the
    destination and has no velocity.
    """
    return path[:-1], np.diff(path, axis=0) / np.diff(time)[:, None], path[-1]


def remaining_speeds(paths: Sequence[Array], phi_max: float, cut: float) -> FieldSamples:
    """Return the experiments with speeds in proportion to the arc length left, |u| = rate l.

    Two corrections to the paper. People start at rest, where phi has no critical point, so that
    recorded speeds are replaced. And phi falls by at most 1 along a path, so that the integral of
    speed over arc length, rate * length^2 / 2, is bounded: one ``rate`` for all paths makes the
    largest ``phi_max``.

    Parameters
    ----------
    paths
        (n_i, n), each ending at its destination.
    phi_max
        Largest path integral of speed.
    cut
        Fraction of arc length left out at the end, where 1 / gamma_d^k in J_PDE is singular.
    """
    fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
    use = fractions <= 1.0 - cut
    rate = phi_max / max(0.5 * arc_length(path)[-1] ** 2 for path in paths)
    parts: list[FieldSamples] = []
    for path in paths:
        points = at_arc_length(path, fractions)
        left = arc_length(path)[-1] * (1.0 - fractions)[:, None]
        velocities = rate * left * units(np.gradient(points, axis=0))
        goals = np.broadcast_to(path[-1], points.shape)
        parts.append(FieldSamples(points[use], velocities[use], goals[use]))
    return FieldSamples.together(parts)


def measured_speeds(
    paths: Sequence[Array], times: Sequence[Array], phi_max: float, cut: float
) -> FieldSamples:
    """Return the experiments with velocities as measured, multiplied by one common factor.

    Points slower than 15 % of the peak are left out: people start and end at rest, and phi is not
    critical at the start. The factor is that of one time scale for all paths, chosen so that the
    largest integral of speed over arc length is ``phi_max``.

    Parameters as in `remaining_speeds`; ``times`` are (n_i,) [s].

    Raises
    ------
    InputError
        If there are not as many times as paths, and as points on each.
    """
    if [len(time) for time in times] != [len(path) for path in paths]:
        raise InputError("times and paths differ in length; give one time for each point")
    parts: list[FieldSamples] = []
    integrals: list[float] = []
    for path, time in zip(paths, times, strict=True):
        points, velocities, goal = forward_differences(time, path)
        speed = norms(velocities)[:, 0]
        length = arc_length(path)
        integrals.append(float(total(speed * np.diff(length))))
        use = (speed > _REST * speed.max()) & (length[:-1] <= (1.0 - cut) * length[-1])
        goals = np.broadcast_to(goal, points.shape)
        parts.append(FieldSamples(points[use], velocities[use], goals[use]))
    together = FieldSamples.together(parts)
    scale = phi_max / max(integrals)
    return FieldSamples(together.points, scale * together.vectors, together.goals)


def beside(experiments: FieldSamples, rng: np.random.Generator) -> FieldSamples:
    """Return points up to 10 deg beside the path, whose velocities lead back to it.

    The paper has no such points.
    """
    parts: list[FieldSamples] = []
    speed = norms(experiments.vectors)
    tangent = units(experiments.vectors)
    left = norms(experiments.points - experiments.goals)
    if experiments.points.shape[1] == 1:  # on a line there is no side
        return experiments
    for _ in range(4):
        beyond = np.minimum(0.1, 0.3 * left) * rng.random((len(left), 1))
        aside = random_normals(tangent, rng) * beyond
        turned = experiments.displaced(tangent, aside, _PULL)
        parts.append(FieldSamples(turned.points, speed * turned.vectors, turned.goals))
    return FieldSamples.together(parts)


def boundary_points(basis: TensorBasis, per_dimension: int = 7) -> Array:
    """Return points on all faces of the workspace."""
    n = len(basis.shape)
    low, high = basis.lower, basis.upper
    ends = zip(low, high, strict=True)
    axes = [np.linspace(float(a), float(b), per_dimension) for a, b in ends]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)
    return grid[((grid == low) | (grid == high)).any(axis=1)]


def vanishing_on_boundary(basis: TensorBasis) -> Mask:
    """Return which coefficients (prod(m_i),) have splines that vanish on the boundary.

    As long as the others stay 0, so does beta there: Eq. (5) by construction (Sec. V-A.2).
    """
    grids = np.meshgrid(*[np.arange(m) for m in basis.shape], indexing="ij")
    p = basis.degree
    inner = [(g >= p) & (g < m - p) for g, m in zip(grids, basis.shape, strict=True)]
    return np.logical_and.reduce(inner).ravel()

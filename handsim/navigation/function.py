"""Navigation functions over the subspace, Eq. (2) of the paper, and the flow of Eq. (1).

phi(z, z_goal) = gamma_d / (gamma_d^k + beta)^(1/k),  u = -grad phi,  gamma_d = |z - z_goal|^2 as in
the paper, or squared in a metric that depends on the destination (`navigation.metric`).

Obstacles (`navigation.obstacle`) give ln beta, because beta and gamma_d^k span many decades. With
it the control law of Sec. V-C of the paper is

    u = beta (gamma_d^k + beta)^(-1/k - 1) (gamma_d grad(ln beta) / k - grad gamma_d)

so that the flow points along v = gamma_d grad(ln beta) / k - grad gamma_d.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from math import exp, inf, log
from struct import Struct
from typing import Any

import numpy as np

from handsim.errors import InputError
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import TINY_BETA, LogEvaluator, Obstacle
from handsim.reproducible import dots, units
from handsim.types import Array
from handsim.wording import number_of

MAX_K = 1e6
"""Largest exponent; doubles have no room for the powers of larger ones."""
Rows = list[list[float]]
"""A matrix (n, n)."""
_EDGE = 1e-9  # of the workspace: nearer to its boundary than this, rounding decides what is outside


def check_exponent(k: float) -> None:
    """Raise InputError unless k is from 2 to `MAX_K`."""
    if not 2 <= k <= MAX_K:
        raise InputError(f"k = {k:g}; give 2 or more, up to {MAX_K:g}")


def inside_box(z_goal: Array, low: Array, high: Array) -> Array:
    """Return a destination as an array, if it is one that lies inside a box, all (n,) [rad].

    Raises
    ------
    InputError
        If it has the wrong size, is not finite or lies outside.
    """
    goal, edge = np.asarray(z_goal, dtype=float), _EDGE * (high - low)
    if goal.shape != low.shape or not np.isfinite(goal).all():
        raise InputError(
            f"destination of shape {goal.shape}; give {number_of(len(low), 'finite coordinate')}"
        )
    outside = np.flatnonzero((goal <= low + edge) | (goal >= high - edge))
    if outside.size:
        i = int(outside[0])
        raise InputError(
            f"destination {np.rad2deg(goal[i]):.1f} deg in component {i + 1} is outside the "
            f"workspace of {np.rad2deg(low[i]):.1f} to {np.rad2deg(high[i]):.1f} deg; choose a "
            "posture nearer to the recorded ones"
        )
    return goal


@dataclass(frozen=True)
class NavigationFunction:
    """phi of Eq. (2) for an obstacle and an exponent.

    Parameters
    ----------
    obstacle
    k
        Exponent, at least 2 (the paper: a natural number but 0 and 1).
    metric
        Of gamma_d; by default M = I, as in the paper.

    Raises
    ------
    InputError
        If k is less than 2 or more than `MAX_K`.
    """

    obstacle: Obstacle
    k: float
    metric: DestinationMetric | None = None

    def __post_init__(self) -> None:
        """Check the exponent."""
        check_exponent(self.k)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is cached: functions within functions cannot be pickled."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def n_dimensions(self) -> int:
        """Dimension of the subspace."""
        return len(self.obstacle.lower)

    @property
    def inner(self) -> tuple[Array, Array]:
        """Corners (n,) [rad] of the box of possible destinations, without the closing layer."""
        return self.obstacle.inner

    def check_goal(self, z_goal: Array) -> Array:
        """Return a destination as an array, if the navigation function can lead there.

        Raises
        ------
        InputError
            If it has the wrong size, lies outside the workspace, in its closing layer (where paths
            to it need not arrive) or where beta is not positive.
        """
        goal = inside_box(z_goal, *self.inner)
        if self.obstacle.evaluator(self.k)(goal.tolist())[0] <= log(TINY_BETA) + 1e-9:
            raise InputError(
                "the obstacle function is not positive at the destination; choose a posture "
                "nearer to the recorded ones"
            )
        return goal

    def evaluator(self) -> "FlowEvaluator":
        """Return an object that evaluates single points without making arrays."""
        return FlowEvaluator(self.obstacle.evaluator(self.k), self.k, self._of_one)

    @cached_property
    def _of_one(self) -> Callable[[list[float]], Rows]:
        if self.metric is not None:
            return _metric_of_one(self.metric)
        identity: Rows = np.eye(self.n_dimensions).tolist()
        return lambda _: identity

    def metrics(self, z_goal: Array) -> Array:
        """Return the metrics M (..., n, n) of gamma_d at destinations (..., n)."""
        if self.metric is None:
            return np.broadcast_to(np.eye(self.n_dimensions), (*z_goal.shape, self.n_dimensions))
        return self.metric.at(z_goal)

    def attraction(self, z: Array, z_goal: Array) -> tuple[Array, Array]:
        """Return gamma_d (N,) and half its gradient (N, n), for goals (n,) or (N, n)."""
        away = z - z_goal
        pull = dots(self.metrics(z_goal), away[..., None, :])
        return dots(pull, away), pull

    def value_and_gradient(self, z: Array, z_goal: Array) -> tuple[float, Array]:
        """Return phi and grad phi (n,) [1/rad] at one point (n,)."""
        gradient = np.empty(len(z))
        return self.evaluator().value_and_gradient(z, z_goal, gradient), gradient

    def direction(self, z: Array, z_goal: Array) -> Array:
        """Return the unit vector (n,) of the flow -grad phi at one point; 0 at a critical point.

        Outside the workspace the obstacle of its nearest point is taken.
        """
        direction = np.empty(len(z))
        self.evaluator().direction(z, z_goal, direction)
        return direction

    def directions(self, z: Array, z_goal: Array) -> Array:
        """Return unit vectors of the flow (N, n) at points (N, n), goals (n,) or (N, n)."""
        gamma, pull = self.attraction(z, z_goal)
        _, grad_ln, _ = self.obstacle.log_jets(z, self.k, 1)
        return units((gamma / self.k)[:, None] * grad_ln - 2.0 * pull)

    def jets(self, z: Array, z_goal: Array, order: int = 1) -> tuple[Array, Array, Array]:
        """Return phi (N,) of Eq. (2), grad phi (N, n) [1/rad] and its Hessians (N, n, n) [1/rad^2].

        Derivatives above ``order`` are left as empty arrays.

        Parameters
        ----------
        z : (N, n) [rad]
        z_goal : (n,) or (N, n) [rad]
        order : 0, 1 or 2
        """
        k = self.k
        gamma, pull = self.attraction(z, z_goal)
        ln_beta, grad_ln, hess_ln = self.obstacle.log_jets(z, k, order)
        with np.errstate(divide="ignore"):
            ln_gamma = np.log(gamma)
        ln_sum = np.logaddexp(ln_beta, k * ln_gamma)
        inverse_root = np.exp(-ln_sum / k)
        phi = gamma * inverse_root
        if order == 0:
            return phi, np.empty((len(z), 0)), np.empty((len(z), 0, 0))
        share = np.exp(ln_beta - ln_sum)
        slope = 2.0 * pull - (gamma / k)[:, None] * grad_ln
        gradient = (inverse_root * share)[:, None] * slope
        if order == 1:
            return phi, gradient, np.empty((len(z), 0, 0))
        # grad phi = D s v with D = (gamma^k + beta)^(-1/k), s = beta / (gamma^k + beta) and
        # v = grad gamma - gamma grad(ln beta) / k; r = (1 - s) / gamma stays finite at the goal.
        r = np.exp((k - 1) * ln_gamma - ln_sum)
        chi_rate = (k * r * gamma - share) / k
        outer = (-2.0 * (k + 1) * r)[:, None] * pull + chi_rate[:, None] * grad_ln
        curvature = 2.0 * self.metrics(z_goal) - (gamma / k)[:, None, None] * hess_ln
        curvature += slope[:, :, None] * outer[:, None, :]
        curvature -= (2.0 / k) * grad_ln[:, :, None] * pull[:, None, :]
        return phi, gradient, (inverse_root * share)[:, None, None] * curvature


def _metric_of_one(metric: DestinationMetric) -> Callable[[list[float]], Rows]:
    """Return a function of one destination [rad] that returns its metric.

    It takes a fifteenth of the time of `DestinationMetric.at`, and differs by rounding alone;
    which, unlike that of `at`, depends on the processor. The latest answer is kept.
    """
    n = metric.logs.shape[1]
    # -|z_goal - z_j|^2 / (2 reach^2) is linear in (z_goal, 1, |z_goal|^2); of S_0 it is 0.
    half = 0.5 / metric.reach**2
    by_square = np.full(len(metric.centres), -half)
    offsets = -half * (metric.centres**2).sum(axis=1)
    exponents = np.column_stack([2.0 * half * metric.centres, offsets, by_square])
    exponents = np.vstack([np.zeros(n + 2), exponents])
    logs = np.ascontiguousarray(metric.logs.reshape(-1, n * n).T)
    pack: Callable[..., None] = Struct(f"{n + 2}d").pack_into
    from scipy.linalg import get_lapack_funcs

    (syev,) = get_lapack_funcs(("syev",))  # three times as fast as numpy.linalg.eigh
    put_together = _put_together_three if n == 3 else _put_together
    latest: list[tuple[list[float], Rows]] = []

    def of_one(z_goal: list[float]) -> Rows:
        for answered, found in latest:
            if answered == z_goal:
                return found
        terms, square = np.empty(n + 2), 0.0
        for x in z_goal:
            square += x * x
        pack(terms, 0, *z_goal, 1.0, square)
        shares = exponents.dot(terms)
        np.exp(shares, shares)
        log = logs.dot(shares).reshape(n, n)
        values, vectors, _ = syev(log.T, 1, 0, 8 * n, 1)  # in place: to copy takes longer
        found = put_together(values, vectors)
        latest[:] = [(z_goal, found)]
        return found

    return of_one


def _put_together(values: Array, vectors: Array) -> Rows:
    """Return the exponential of a symmetric matrix from its eigenvalues and eigenvectors."""
    return (vectors * np.exp(values)).dot(vectors.T).tolist()


def _put_together_three(values: Array, vectors: Array) -> Rows:
    """Return the same in 3 dimensions, where single products are faster than arrays."""
    p, q, r = map(exp, values.tolist())
    (a, b, c), (d, e, f), (g, h, i) = vectors.tolist()
    pa, qb, rc, pd, qe, rf = p * a, q * b, r * c, p * d, q * e, r * f
    ad, ag, dg = pa * d + qb * e + rc * f, pa * g + qb * h + rc * i, pd * g + qe * h + rf * i
    return [
        [pa * a + qb * b + rc * c, ad, ag],
        [ad, pd * d + qe * e + rf * f, dg],
        [ag, dg, p * g * g + q * h * h + r * i * i],
    ]


@dataclass
class FlowEvaluator:
    """phi, its gradient and its flow at single points, for loops in which each microsecond counts.

    Results are written into arrays that the caller gives; no others are made. Each thread needs an
    evaluator of its own. The first point in a knot cell takes some 40 microseconds longer than
    later ones.

    Attributes
    ----------
    log_jet
        Obstacle, see `Obstacle.evaluator`.
    k
        Exponent.
    metrics
        Metric of a destination, by rows. The latest answer is kept.
    """

    log_jet: LogEvaluator
    k: float
    metrics: Callable[[list[float]], Rows]
    _goal: list[float] = field(default_factory=list[float], repr=False)
    _metric: Rows = field(default_factory=list[list[float]], repr=False)

    def value_and_gradient(self, z: Array, z_goal: Array, gradient: Array) -> float:
        """Return phi, Eq. (2), and write grad phi (n,) [1/rad] at one point into ``gradient``."""
        k, here = self.k, z.tolist()
        ln_beta, *grad_ln = self.log_jet(here)
        gamma, pull = self._attraction(here, z_goal)
        ln_power = k * log(gamma) if gamma > 0.0 else -inf
        larger, smaller = (ln_beta, ln_power) if ln_beta > ln_power else (ln_power, ln_beta)
        ln_sum = larger + log(1.0 + exp(smaller - larger))
        inverse_root = exp(-ln_sum / k)  # (gamma^k + beta)^(-1/k)
        scale = inverse_root * exp(ln_beta - ln_sum)  # share: beta / (gamma^k + beta)
        for i, (a, b) in enumerate(zip(pull, grad_ln, strict=True)):
            gradient[i] = scale * (2.0 * a - gamma / k * b)
        return gamma * inverse_root

    def direction(self, z: Array, z_goal: Array, direction: Array) -> None:
        """Write the unit vector (n,) of the flow of Eq. (1) at one point into ``direction``."""
        here = z.tolist()
        _, *grad_ln = self.log_jet(here)
        gamma, pull = self._attraction(here, z_goal)
        rate = gamma / self.k
        flow = [rate * b - 2.0 * a for a, b in zip(pull, grad_ln, strict=True)]
        length = sum([x * x for x in flow]) ** 0.5 or 1.0
        for i, x in enumerate(flow):
            direction[i] = x / length

    def _attraction(self, here: list[float], z_goal: Array) -> tuple[float, list[float]]:
        """Return gamma_d and half its gradient."""
        goal = z_goal.tolist()
        if goal != self._goal:
            self._goal, self._metric = goal, self.metrics(goal)
        away = [a - b for a, b in zip(here, goal, strict=True)]
        pull = [sum([m * a for m, a in zip(row, away, strict=True)], 0.0) for row in self._metric]
        return sum([p * a for p, a in zip(pull, away, strict=True)], 0.0), pull

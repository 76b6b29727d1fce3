"""Proof that a navigation function leads to its destination from everywhere in the workspace.

Along the flow |z - z_goal|^2 falls exactly where (z - z_goal) . grad(ln beta) < 2 k, in whatever
metric gamma_d is, since (z - z_goal) . grad(ln gamma_d) = 2 for any. If that holds in the whole
workspace, |z - z_goal|^2 is a strict Lyapunov function: z_goal is the only critical point and every
start converges. The condition is sufficient, not necessary.

That excludes critical points inside. Starts arrive if no path leaves the workspace, too. The
closing factor sees to it where there is one, in any metric. Where beta is a spline itself, the flow
points inwards on a face with outer normal e if e . grad beta |z - z_goal|^2 <= 2 k beta
e . (z - z_goal) on it, which gives a second least exponent. That holds without a metric of
destinations alone: in another one M (z - z_goal) may point outwards.

The bound. For a spline f and a fixed destination, (z - z_goal) . grad f is on every knot cell
a polynomial of the degree of f, so it lies between the least and the greatest of its Bernstein
coefficients; it is affine in z_goal, so a box of destinations is worst at a corner. Cells are
split in halves where the bound is not yet decided, which sharpens it quadratically; coefficients
at the corners of a cell are values of the polynomial, so they refute. Bounds are rounded outward
by what the sums can be off (`_rounding_of`), and a margin of 1e-9 is kept on top. Coefficients,
goals or exponents that are not finite prove nothing.

beta = beta_0 exp(k chi): k drops out of the condition, (z - z_goal) . grad chi < 2, and the
closing factor only helps, (z - z_goal) . grad(ln beta_0) <= 0, for destinations inside the
closing layer. beta itself a spline: (z - z_goal) . grad beta < 2 k beta with beta > 0, hence
k_min = sup (z - z_goal) . grad beta / (2 beta), the number whose existence the paper cites.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handsim.navigation._bernstein import Cells, corner_index
from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle, SplineObstacle
from handsim.reproducible import total
from handsim.types import Array, Mask

_ROUNDING = 1e-9
_MAX_CELLS = 200_000  # undecided at once; beyond, the bound is returned as far as it got
_SMALLEST = np.deg2rad(1e-6)


@dataclass(frozen=True)
class Bound:
    """Bracket of a supremum over the workspace.

    Attributes
    ----------
    lower, upper
        The supremum lies between them; ``lower`` is attained at ``where``.
    where : (n,) [rad]
    rounding
        What the rounding of sums may have changed in either.
    """

    lower: float
    upper: float
    where: Array
    rounding: float

    @property
    def outward(self) -> float:
        """The upper end, rounded outward: what a proof may lean on."""
        return self.upper + self.rounding


@dataclass(frozen=True)
class Certificate:
    """Outcome of the attempt to prove convergence.

    Attributes
    ----------
    certified
        Whether every start in the workspace is proved to reach every destination of the box.
    k_min
        Least exponent, 2 or more, with which the proof succeeds; None if there is none.
    supremum
        Bracket of the descent quantity: of (z - z_goal) . grad chi, which must stay under 2,
        or of (z - z_goal) . grad beta / (2 beta), which must stay under k. None where beta is not
        positive in the whole workspace.
    reason
        One line that says why.
    """

    certified: bool
    k_min: float | None
    supremum: Bound | None
    reason: str


def certify(navigation: NavigationFunction, goals: Array, tolerance: float = 1e-3) -> Certificate:
    """Try to prove convergence from everywhere to every destination in a box.

    Parameters
    ----------
    navigation
    goals : (m, n) [rad]
        Destinations; the smallest box around them is proved.
    tolerance
        Width to which the supremum is narrowed down.
    """
    low, high = np.min(goals, axis=0), np.max(goals, axis=0)
    obstacle = navigation.obstacle
    if not _is_finite(navigation, goals):
        return Certificate(False, None, None, "a coefficient or a destination is not finite")
    if isinstance(obstacle, ExponentialObstacle):
        lower, upper = obstacle.inner
        inner = (low >= lower) & (high <= upper)
        if not inner.all():
            return Certificate(False, None, None, "a destination lies in the closing layer")
        bound = descent_supremum(obstacle.chi, low, high, tolerance)
        certified = bound.outward < 2.0 - _ROUNDING
        extent = f"is at most {bound.outward:.4f}" if certified else f"reaches {bound.lower:.4f}"
        worst = f"(z - z_goal) . grad chi {extent}, the limit is 2"
        return Certificate(certified, 2.0 if certified else None, bound, worst)
    if isinstance(obstacle, SplineObstacle):
        if navigation.metric is not None:
            nothing = "no proof is known for beta as a spline with a metric of destinations"
            return Certificate(False, None, None, nothing)
        return _certify_spline(obstacle.beta, navigation.k, low, high, tolerance)
    return Certificate(False, None, None, "no proof is known for this kind of obstacle")


def _is_finite(navigation: NavigationFunction, goals: Array) -> bool:
    """Whether all numbers that the proof is about are numbers."""
    obstacle, metric = navigation.obstacle, navigation.metric
    held: list[Array] = [goals, np.array(navigation.k)]
    if isinstance(obstacle, ExponentialObstacle):
        held += [obstacle.chi.coefficients, obstacle.width]
    elif isinstance(obstacle, SplineObstacle):
        held += [obstacle.beta.coefficients]
    if metric is not None:
        held += [metric.centres, metric.logs]
    return all(np.isfinite(each).all() for each in held)


def descent_supremum(chi: TensorBSpline, low: Array, high: Array, tolerance: float = 1e-3) -> Bound:
    """Bracket the supremum of (z - z_goal) . grad chi over workspace and box of destinations.

    Parameters
    ----------
    chi
    low, high : (n,) [rad]
        Corners of the box of destinations.
    tolerance
        Width of the bracket aimed at.
    """
    cells = Cells.of(chi)
    best, where = -np.inf, cells.origin[0]
    decided = -np.inf  # greatest upper bound among cells already set aside
    while True:
        coefficients = _descent_coefficients(cells, low, high)
        corners = coefficients[corner_index(coefficients)].reshape(len(coefficients), -1)
        top = np.unravel_index(np.argmax(corners), corners.shape)
        if corners[top] > best:
            best = float(corners[top])
            where = cells.corner(int(top[0]), int(top[1]))
        upper = coefficients.reshape(len(coefficients), -1).max(axis=1)
        undecided = upper > best + tolerance
        decided = max(decided, float(upper[~undecided].max(initial=-np.inf)))
        off = float(_rounding_of(cells, low, high).max())
        if not undecided.any():
            return Bound(best, max(decided, best), where, off)
        if _spent(cells, undecided):
            return Bound(best, max(decided, float(upper.max())), where, off)
        cells = cells.take(undecided).halved()


def violations(
    chi: TensorBSpline, low: Array, high: Array, limit: float, most: int = 1000
) -> Array:
    """Return points (m, n) at which (z - z_goal) . grad chi passes a limit or nearly does.

    They are the places of the Bernstein coefficients above the limit, the largest first, on cells
    halved once: where a fit under that limit has to be held.
    """
    cells = Cells.of(chi)
    most_there = _descent_coefficients(cells, low, high).reshape(len(cells.origin), -1).max(axis=1)
    # Coefficients on halves are means of those on the whole: elsewhere none is above.
    possible = most_there + 2.0 * _rounding_of(cells, low, high) > limit
    cells = cells.take(possible).halved()
    coefficients = _descent_coefficients(cells, low, high)
    above = np.argwhere(coefficients > limit)
    largest = np.argsort(-coefficients[tuple(above.T)], kind="stable")[:most]
    cell, place = above[largest, 0], above[largest, 1:]
    return cells.origin[cell] + cells.size[cell] * place / chi.basis.degree


def _certify_spline(
    beta: TensorBSpline, k: float, low: Array, high: Array, tolerance: float
) -> Certificate:
    """Bracket sup (z - z_goal) . grad beta / (2 beta) by splitting cells, best first by level."""
    cells = Cells.of(beta)
    best, where, decided = -np.inf, cells.origin[0], -np.inf
    while True:
        value = cells.coefficients.reshape(len(cells.origin), -1)
        at_corners = cells.coefficients[corner_index(cells.coefficients)]
        at_corners = at_corners.reshape(len(value), -1)
        if at_corners.min() <= 0.0:
            return Certificate(False, None, None, "beta is not positive in the whole workspace")
        slope = _descent_coefficients(cells, low, high)
        corners = slope[corner_index(slope)].reshape(len(slope), -1) / (2.0 * at_corners)
        top = np.unravel_index(np.argmax(corners), corners.shape)
        if corners[top] > best:
            best = float(corners[top])
            where = cells.corner(int(top[0]), int(top[1]))
        upper = _greatest_ratio(slope.reshape(len(slope), -1), 2.0 * value)
        undecided = upper > best + tolerance
        decided = max(decided, float(upper[~undecided].max(initial=-np.inf)))
        if not undecided.any():
            break
        if _spent(cells, undecided):
            return Certificate(False, None, None, "the bound is not decided within its budget")
        cells = cells.take(undecided).halved()
    least = 2.0 * cells.coefficients.reshape(len(cells.origin), -1).min(axis=1)
    off = float((_rounding_of(cells, low, high) / least).max())
    bound = Bound(best, max(decided, best), where, off)
    leaving = _greatest_on_faces(Cells.of(beta), low, high)
    k_min = max(2.0, bound.outward + _ROUNDING, leaving + _ROUNDING)
    if not np.isfinite(k_min):
        return Certificate(False, None, bound, "paths may leave the workspace, whatever k")
    return Certificate(k >= k_min, k_min, bound, f"k = {k:g}, and {k_min:.4f} is enough")


def _greatest_on_faces(cells: Cells, low: Array, high: Array) -> float:
    """Upper bound of e . grad beta |z - z_goal|^2 / (2 beta e . (z - z_goal)) on all faces."""
    n, degree = cells.origin.shape[1], cells.coefficients.shape[1] - 1
    lower, upper = cells.origin.min(axis=0), (cells.origin + cells.size).max(axis=0)
    greatest = 0.0
    for i in range(n):
        for outward in (-1, 1):
            face = lower[i] if outward < 0 else upper[i]
            nearest = low[i] - face if outward < 0 else face - high[i]
            if nearest <= 0:
                return np.inf  # a destination on the face
            edge = cells.origin[:, i] if outward < 0 else cells.origin[:, i] + cells.size[:, i]
            own = cells.take(edge == face)
            ends = np.moveaxis(own.coefficients, i + 1, -1)
            ends = ends[..., :2] if outward < 0 else ends[..., -2:]
            beta = ends[..., 0 if outward < 0 else 1].reshape(len(own.origin), -1)
            slope = outward * degree * np.diff(ends, axis=-1).reshape(len(beta), -1)
            slope = slope / own.size[:, i, None]
            reach = total(own.farthest(low, high) ** 2, 1)[:, None] / nearest
            rising = np.maximum(slope, 0.0)
            greatest = max(greatest, float(_greatest_ratio(rising * reach, 2.0 * beta).max()))
    return greatest * (1 + 1e-12)


def _rounding_of(cells: Cells, low: Array, high: Array) -> Array:
    """Bounds (N,) of what rounding may have changed in the descent quantity on cells.

    A coefficient is a sum of a few dozen products, each off by a rounding of the largest; its
    differences are divided by the size of the cell and multiplied with distances to destinations.
    """
    degree = cells.coefficients.shape[1] - 1
    extent = cells.farthest(low, high)
    largest = np.abs(cells.coefficients).reshape(len(extent), -1).max(axis=1)
    slopes = 2.0 * degree * largest[:, None] * extent / cells.size
    n_sums = 4 * (degree + 1) ** 2 * len(low)
    return n_sums * np.finfo(float).eps * total(slopes, 1)


def _greatest_ratio(numerator: Array, denominator: Array) -> Array:
    """Upper bounds (N,) of ratios of polynomials from coefficients (N, m); inf if undecided."""
    most: Array = numerator.max(axis=1)
    least: Array = denominator.min(axis=1)
    divisor = np.where(most > 0.0, least, denominator.max(axis=1))
    return np.where(least > 0.0, most / np.where(least > 0.0, divisor, 1.0), np.inf)


def _spent(cells: Cells, undecided: Mask) -> bool:
    """Whether another round would pass the budget, or cells are too small to matter."""
    children = np.count_nonzero(undecided) * 2 ** cells.origin.shape[1]
    return children > _MAX_CELLS or bool(cells.size.max() < _SMALLEST)


def _descent_coefficients(cells: Cells, low: Array, high: Array) -> Array:
    """Bernstein coefficients of (z - z_goal) . grad f at the worst corner z_goal for each.

    The derivative along one dimension has degree one less, and (z_i - z_goal_i) brings it back: the
    product of Bernstein polynomials of degrees p - 1 and 1. Its coefficient j is made of those of
    the derivative beside it, by the linear one's values at the two ends of the cell.
    """
    c = cells.coefficients
    degree: int = c.shape[1] - 1
    sums = np.zeros_like(c)
    for i in range(len(low)):
        rows, rows_of_sums = np.moveaxis(c, i + 1, 0), np.moveaxis(sums, i + 1, 0)
        extent = (slice(None), *(None,) * (rows.ndim - 2))
        start, size = cells.origin[:, i][extent], cells.size[:, i][extent]
        slopes = [degree * (after - before) / size for before, after in pairwise(rows)]
        at_start = [slope * ((degree - j) / degree) for j, slope in enumerate(slopes)]
        at_end = [slope * ((j + 1) / degree) for j, slope in enumerate(slopes)]
        ends = [(start - goal, start + size - goal) for goal in (low[i], high[i])]
        for j in range(degree + 1):
            of_goals: list[Array] = []
            for from_start, from_end in ends:
                if j == 0:
                    of_goals.append(at_start[0] * from_start)
                elif j == degree:
                    of_goals.append(at_end[-1] * from_end)
                else:
                    of_goals.append(at_start[j] * from_start + at_end[j - 1] * from_end)
            rows_of_sums[j] += np.maximum(*of_goals)
    return sums

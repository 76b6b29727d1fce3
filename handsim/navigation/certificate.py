"""Proof that a navigation function leads to its destination from everywhere in the workspace.

Along the flow |z - z_goal|^2 falls exactly where (z - z_goal) . grad(ln beta) < 2 k, in whatever
metric gamma_d is, since (z - z_goal) . grad(ln gamma_d) = 2 for any. If that holds in the whole
workspace, |z - z_goal|^2 is a strict Lyapunov function: z_goal is the only critical point and every
start converges. The condition is sufficient, not necessary.

The bound. For a spline f and a fixed destination, (z - z_goal) . grad f is on every knot cell
a polynomial of the degree of f, so it lies between the least and the greatest of its Bernstein
coefficients; it is affine in z_goal, so a box of destinations is worst at a corner. Cells are
split in halves where the bound is not yet decided, which sharpens it quadratically; coefficients
at the corners of a cell are values of the polynomial, so they refute. Rounding is of the order
of 1e-13 of the coefficients, and a margin of 1e-9 is kept.

beta = beta_0 exp(k chi): k drops out of the condition, (z - z_goal) . grad chi < 2, and the
closing factor only helps, (z - z_goal) . grad(ln beta_0) <= 0, for destinations inside the
closing layer. beta itself a spline: (z - z_goal) . grad beta < 2 k beta with beta > 0, hence
k_min = sup (z - z_goal) . grad beta / (2 beta), the number whose existence the paper cites.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle, SplineObstacle
from handsim.reproducible import product, total
from handsim.types import Array, Index, Mask

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
    """

    lower: float
    upper: float
    where: Array


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
    if isinstance(obstacle, ExponentialObstacle):
        inner = (low >= obstacle.lower + obstacle.width) & (high <= obstacle.upper - obstacle.width)
        if not inner.all():
            return Certificate(False, None, None, "a destination lies in the closing layer")
        bound = descent_supremum(obstacle.chi, low, high, tolerance)
        certified = bound.upper < 2.0 - _ROUNDING
        extent = f"is at most {bound.upper:.4f}" if certified else f"reaches {bound.lower:.4f}"
        worst = f"(z - z_goal) . grad chi {extent}, the limit is 2"
        return Certificate(certified, 2.0 if certified else None, bound, worst)
    if isinstance(obstacle, SplineObstacle):
        return _certify_spline(obstacle.beta, navigation.k, low, high, tolerance)
    return Certificate(False, None, None, "no proof is known for this kind of obstacle")


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
    cells = _Cells.of(chi)
    best, where = -np.inf, cells.origin[0]
    decided = -np.inf  # greatest upper bound among cells already set aside
    while True:
        coefficients = _descent_coefficients(cells, low, high)
        corners = coefficients[_corner_index(coefficients)].reshape(len(coefficients), -1)
        top = np.unravel_index(np.argmax(corners), corners.shape)
        if corners[top] > best:
            best = float(corners[top])
            where = cells.corner(int(top[0]), int(top[1]))
        upper = coefficients.reshape(len(coefficients), -1).max(axis=1)
        undecided = upper > best + tolerance
        decided = max(decided, float(upper[~undecided].max(initial=-np.inf)))
        if not undecided.any():
            return Bound(best, max(decided, best), where)
        if _spent(cells, undecided):
            return Bound(best, max(decided, float(upper.max())), where)
        cells = cells.take(undecided).halved()


def violations(
    chi: TensorBSpline, low: Array, high: Array, limit: float, most: int = 1000
) -> Array:
    """Return points (m, n) at which (z - z_goal) . grad chi passes a limit or nearly does.

    They are the places of the Bernstein coefficients above the limit, the largest first, on cells
    halved once: where a fit under that limit has to be held.
    """
    cells = _Cells.of(chi).halved()
    coefficients = _descent_coefficients(cells, low, high)
    above = np.argwhere(coefficients > limit)
    largest = np.argsort(-coefficients[tuple(above.T)], kind="stable")[:most]
    cell, place = above[largest, 0], above[largest, 1:]
    return cells.origin[cell] + cells.size[cell] * place / chi.basis.degree


def _certify_spline(
    beta: TensorBSpline, k: float, low: Array, high: Array, tolerance: float
) -> Certificate:
    """Bracket sup (z - z_goal) . grad beta / (2 beta) by splitting cells, best first by level."""
    cells = _Cells.of(beta)
    best, where, decided = -np.inf, cells.origin[0], -np.inf
    while True:
        value = cells.coefficients.reshape(len(cells.origin), -1)
        at_corners = cells.coefficients[_corner_index(cells.coefficients)]
        at_corners = at_corners.reshape(len(value), -1)
        if at_corners.min() <= 0.0:
            return Certificate(False, None, None, "beta is not positive in the whole workspace")
        slope = _descent_coefficients(cells, low, high)
        corners = slope[_corner_index(slope)].reshape(len(slope), -1) / (2.0 * at_corners)
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
    bound = Bound(best, max(decided, best), where)
    k_min = max(2.0, bound.upper + _ROUNDING)
    return Certificate(k >= k_min, k_min, bound, f"k = {k:g}, and {k_min:.4f} is enough")


def _greatest_ratio(numerator: Array, denominator: Array) -> Array:
    """Upper bounds (N,) of ratios of polynomials from coefficients (N, m); inf if undecided."""
    most: Array = numerator.max(axis=1)
    least: Array = denominator.min(axis=1)
    divisor = np.where(most > 0.0, least, denominator.max(axis=1))
    return np.where(least > 0.0, most / np.where(least > 0.0, divisor, 1.0), np.inf)


def _spent(cells: "_Cells", undecided: Mask) -> bool:
    """Whether another round would pass the budget, or cells are too small to matter."""
    children = int(undecided.sum()) * 2 ** cells.origin.shape[1]
    return children > _MAX_CELLS or bool(cells.size.max() < _SMALLEST)


@dataclass(frozen=True)
class _Cells:
    """A spline on boxes, in Bernstein form.

    origin, size : (N, n); coefficients : (N, degree + 1, ..., degree + 1)
    """

    origin: Array
    size: Array
    coefficients: Array

    @classmethod
    def of(cls, spline: TensorBSpline) -> "_Cells":
        """One box a knot cell."""
        n, degree = spline.coefficients.ndim, spline.basis.degree
        c = spline.coefficients
        for r, axis in enumerate(spline.basis.axes):
            size = np.diff(axis.breaks)
            # Power coefficients in t = x - break, then in u = t / size, then Bernstein.
            powers = axis.pieces[:, :, 0] * size[:, None, None] ** np.arange(degree + 1)[:, None]
            to_cells = product(_power_to_bernstein(degree), powers)
            local = axis.first[:, None] + np.arange(degree + 1)
            # Axes already done lead as pairs (cell, power); the next to do is axis 2 r.
            gathered = np.moveaxis(np.take(c, local, axis=2 * r), (2 * r, 2 * r + 1), (0, 1))
            extent = (slice(None), slice(None), slice(None), *(None,) * (gathered.ndim - 2))
            summed = total(to_cells[extent] * gathered[:, None], 2)
            c = np.moveaxis(summed, (0, 1), (2 * r, 2 * r + 1))
        c = np.transpose(c, (*range(0, 2 * n, 2), *range(1, 2 * n, 2)))
        c = c.reshape((-1, *(degree + 1,) * n))
        breaks = [axis.breaks for axis in spline.basis.axes]
        origin = np.stack(np.meshgrid(*[b[:-1] for b in breaks], indexing="ij"), -1).reshape(-1, n)
        size = np.stack(np.meshgrid(*[np.diff(b) for b in breaks], indexing="ij"), -1)
        return cls(origin, size.reshape(-1, n), c)

    def take(self, which: Mask) -> "_Cells":
        return _Cells(self.origin[which], self.size[which], self.coefficients[which])

    def halved(self) -> "_Cells":
        """Split every box in halves along all dimensions."""
        origin, size, c = self.origin, self.size / 2, self.coefficients
        left = _left_half(c.shape[1] - 1)
        right = left[::-1, ::-1]
        for axis in range(origin.shape[1]):
            halves = [_along(half, c, axis + 1) for half in (left, right)]
            c = np.concatenate(halves)
            shift = np.zeros(origin.shape[1])
            shift[axis] = 1.0
            origin = np.concatenate([origin, origin + size * shift])
            size = np.concatenate([size, size])
        return _Cells(origin, size, c)

    def corner(self, cell: int, corner: int) -> Array:
        """Position of the corner that `_corner_index` lists at ``corner``."""
        n = len(self.origin[0])
        bits = (corner >> np.arange(n)[::-1]) & 1
        return self.origin[cell] + bits * self.size[cell]


def _descent_coefficients(cells: _Cells, low: Array, high: Array) -> Array:
    """Bernstein coefficients of (z - z_goal) . grad f at the worst corner z_goal for each.

    The derivative along one dimension has degree one less, and (z_i - z_goal_i) brings it back: the
    product of Bernstein polynomials of degrees p - 1 and 1.
    """
    degree: int = cells.coefficients.shape[1] - 1
    total = np.zeros_like(cells.coefficients)
    for i in range(len(low)):
        c = np.moveaxis(cells.coefficients, i + 1, -1)
        extent = (slice(None), *(None,) * (c.ndim - 1))
        slope = degree * np.diff(c, axis=-1) / cells.size[:, i][extent]
        at_start = slope * (np.arange(degree, 0, -1) / degree)  # weight of the linear at u = 0
        at_end = slope * (np.arange(1, degree + 1) / degree)
        start = cells.origin[:, i][extent]
        end = start + cells.size[:, i][extent]
        moved: list[Array] = []
        for goal in (low[i], high[i]):
            product = np.zeros_like(c)
            product[..., :-1] += at_start * (start - goal)
            product[..., 1:] += at_end * (end - goal)
            moved.append(product)
        total += np.moveaxis(np.maximum(*moved), -1, i + 1)
    return total


def _corner_index(coefficients: Array) -> tuple[Index, ...]:
    """Index of the coefficients at the corners of cells, last dimension fastest."""
    degree = coefficients.shape[1] - 1
    ends = [np.array([0, degree])] * (coefficients.ndim - 1)
    return np.ix_(np.arange(len(coefficients)), *ends)


def _power_to_bernstein(degree: int) -> Array:
    """u^i = sum over j >= i of C(j, i) / C(degree, i) B_j; (degree + 1, degree + 1)."""
    size = degree + 1
    return np.array([[comb(j, i) / comb(degree, i) for i in range(size)] for j in range(size)])


def _left_half(degree: int) -> Array:
    """De Casteljau at u = 1/2: coefficients on the left half."""
    size = degree + 1
    return np.array([[comb(j, i) / 2**j for i in range(size)] for j in range(size)])


def _along(matrix: Array, array: Array, axis: int) -> Array:
    last = np.moveaxis(array, axis, -1)
    return np.moveaxis(total(last[..., None, :] * matrix, -1), -1, axis)

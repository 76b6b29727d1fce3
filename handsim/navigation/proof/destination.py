r"""Proof, cell by cell, that no critical point but the destination can hold a path.

The descent condition (`navigation.certificate`) asks that the *distance* to the destination falls
everywhere. A path that first leads away from its destination breaks it. Here phi itself, which
always falls along its flow, does the work: if z_goal is the only critical point inside, every start
inside arrives. With v = gamma_d grad chi - 2 M (z - z_goal), the flow points along

    w = v + gamma_d / k grad ln beta_0,

and its last term is, for each face whose closing layer z is in, a positive multiple of the face's
inward normal. w is shown to have no zero but z_goal, on each cell by the first of these that holds:

1. *descent*: X . grad chi < 2 with X = z - z_goal. Then X . w < 0, since X . v is
   gamma_d (X . grad chi - 2), and X points outwards in the closing layer, where z_goal is not.
2. *turned descent*, outside the closing layer: the same with X = (I + M^-1 J)(z - z_goal), J skew.
   X . grad ln gamma_d = 2 holds for this X too, as e' J e = 0. J may be another one on each cell,
   since each point needs only one X, and nothing has to fall along paths.
3. *separation*: a fixed direction d with d . v > 0 on the cell, and d . normal >= 0 for the faces
   whose closing layer meets it. Then d . w > 0.

All are statements about polynomials on the cell, proved by their Bernstein coefficients. A cell on
which none holds is halved. Wherever w is not zero, 3. holds on small enough cells, and near z_goal
1. does. (In the closing layer the factor of the normal is taken to be any positive number.)

Where zeros of w remain, they may be ones that hold no path:

4. *instability*: a fixed e, normal to the faces' normals, with e' Dv e > 0 on the cell. At a zero
   of w, Dw is gamma_d times the Hessian of ln beta / k - ln gamma_d, of which phi is a falling
   function. So the Hessian of phi has a negative eigenvalue there: a saddle or a maximum.

What follows. phi is C^2 inside, 1 on the boundary and less inside. A start z_0 inside stays in
{phi <= phi(z_0)}, a compact set inside, on which phi falls strictly but at critical points. By
LaSalle's principle it tends to the set of these. If z_goal is the only one, **every** start
arrives. If the others are all unstable, **almost every** one does. For phi is definable in an
o-minimal structure (its pieces are made of polynomials, exp and ln), so that each solution tends to
a single point (Kurdyka 1998, Ann. Inst. Fourier 48(3):769-783). And the starts that tend to points
with a negative eigenvalue lie in countably many centre-stable manifolds of lower dimension and
their preimages under the flow, which have measure zero. This is what Koditschek and Rimon (1990)
ask of a navigation function, but that they want the other critical points non-degenerate.

For a box of destinations 1. is affine in z_goal, hence worst at a corner of the box. So is 2., and
3. is bounded by corners (`_Problem.fields`), if the metric is the same for all of them, as the
Euclidean is. With a metric of destinations 1. alone is tried on boxes; 4. never is.
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from handsim.navigation._bernstein import Cells
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.proof.polynomials import gradients, linear, quadratic, times
from handsim.navigation.proof.separation import separable, steepest
from handsim.reproducible import mean, total
from handsim.types import Array, Mask

_MOST_NUMBERS = 3_000_000
"""Coefficients computed in one attempt, about half a second's worth; beyond, it is given up."""
_MOST_HALVINGS = 12
_CROWDED_FROM = 4  # halvings, after which more cells than at first are not worth halving again
_UNSTABLE_FROM = 3  # halvings, before that cells are too large for one direction
_MARGIN = 1e-9  # kept from the limit 2, and relative around the closing layer
_TURNS = (0.5, -0.5, 1.0, -1.0, 2.0, -2.0)  # entries of J tried, in each plane of coordinates


@dataclass(frozen=True)
class DestinationProof:
    """Outcome of the attempt to prove that paths lead to a destination, or to a box of them.

    Attributes
    ----------
    certified
        Whether every start inside the workspace, or almost every one, is proved to arrive.
    everywhere
        Whether it is every one: there is no other critical point.
    reason
        One line that says what is proved, or why nothing is.
    undecided : (m, n) [rad]
        Centres of the cells that were left; empty where there is a proof.
    n_cells
        Cells looked at.
    """

    certified: bool
    everywhere: bool
    reason: str
    undecided: Array
    n_cells: int


def certify_destination(
    navigation: NavigationFunction, low: Array, high: Array | None = None
) -> DestinationProof:
    """Try to prove that every start inside, or almost every one, reaches a destination.

    Parameters
    ----------
    navigation
    low : (n,) [rad]
        The destination.
    high : (n,) [rad]
        Where given, all destinations of the box from ``low`` to ``high`` are proved at once.
    """
    low = np.array(low, dtype=float)
    high = low if high is None else np.array(high, dtype=float)
    obstacle, metric = navigation.obstacle, navigation.metrics(low)
    if not isinstance(obstacle, ExponentialObstacle):
        return _nothing(low, "no proof is known for this kind of obstacle")
    hindrance = _hindrance(navigation, obstacle, low, high, metric)
    if hindrance:
        return _nothing(low, hindrance)
    same = navigation.metric is None or bool((low == high).all())
    with np.errstate(all="ignore"):  # what overflows is not decided
        return _attempt(_Problem(obstacle, low, high, metric, same), _smoothness(obstacle) >= 2)


def _hindrance(
    navigation: NavigationFunction,
    obstacle: ExponentialObstacle,
    low: Array,
    high: Array,
    metric: Array,
) -> str:
    """Why nothing can be proved, or nothing at all."""
    held = (low, high, obstacle.chi.coefficients, obstacle.width, metric, np.array(navigation.k))
    lower, upper = obstacle.inner
    inner = (low >= lower) & (high <= upper)
    checks = (
        (all(np.isfinite(each).all() for each in held), "a coefficient or a goal is not finite"),
        (bool((low <= high).all()), "the box of destinations is empty"),
        (bool((inner & (obstacle.width > 0.0)).all()), "a destination lies in the closing layer"),
        (_is_positive_definite(metric), "the metric is not positive definite"),
        (_smoothness(obstacle) >= 1, "chi has kinks"),
    )
    return next((what for fine, what in checks if not fine), "")


def _attempt(problem: "_Problem", twice: bool) -> DestinationProof:
    """Halve cells until each is decided or the budget is spent."""
    cells = Cells.of(problem.obstacle.chi)
    n_first, n_cells, n_numbers, everywhere = len(cells.origin), 0, 0, True
    for halvings in range(_MOST_HALVINGS + 1):
        n_cells += len(cells.origin)
        n_numbers += len(cells.origin) * problem.n_numbers
        if halvings and n_numbers > _MOST_NUMBERS:
            break
        if halvings > _CROWDED_FROM and len(cells.origin) > n_first:
            break
        cells = cells.take(~problem.without_zero(cells))
        if len(cells.origin) and twice and problem.is_single and halvings >= _UNSTABLE_FROM:
            unstable = problem.unstable(cells)
            everywhere = everywhere and not unstable.any()
            cells = cells.take(~unstable)
        if not len(cells.origin):
            who = "every start arrives" if everywhere else "almost every start arrives"
            what = "there is no other critical point" if everywhere else "all others are unstable"
            nothing = np.empty((0, len(problem.low)))
            return DestinationProof(True, everywhere, f"{who}: {what}", nothing, n_cells)
        cells = cells.halved()
    reason = f"not decided on {len(cells.origin)} of {n_cells} cells"
    return DestinationProof(False, False, reason, cells.origin + 0.5 * cells.size, n_cells)


class _Problem:
    """What has to hold on cells, for the corners of a box of destinations."""

    def __init__(
        self, obstacle: ExponentialObstacle, low: Array, high: Array, metric: Array, same: bool
    ) -> None:
        self.obstacle, self.low, self.high = obstacle, low, high
        self.metric, self.has_one_metric = metric, same
        self.is_single = bool((low == high).all())
        ends = [(a,) if a == b else (a, b) for a, b in zip(low, high, strict=True)]
        self.corners = [np.array(corner) for corner in product(*ends)]
        half = 0.5 * (high - low)
        self.spread = float(total(half * half))  # squared distance of corners from the middle
        n, self.degree = len(low), obstacle.chi.basis.degree
        n_fields = len(self.corners) * (1 if self.is_single else 2)
        self.n_numbers = n * (self.degree + 3) ** n * n_fields
        self._largest = float(np.abs(obstacle.chi.coefficients).max())

    def without_zero(self, cells: Cells) -> Mask:
        """Whether one of the three tests holds on each cell."""
        gradient = gradients(cells.coefficients, cells.size)
        done = self._descends(cells, gradient, np.eye(len(self.low)))
        tests = [self._descends_turned, self._separated] if self.has_one_metric else []
        for test in tests:
            left = np.flatnonzero(~done)
            if not left.size:
                break
            done[left] = test(cells.take(~done), gradient[left])
        return done

    def unstable(self, cells: Cells) -> Mask:
        """Whether a zero on each cell would be a saddle or a maximum of phi."""
        n = len(self.low)
        field = self.fields(cells, gradients(cells.coefficients, cells.size))[0]
        slopes = np.stack([gradients(field[:, i], cells.size) for i in range(n)], axis=1)
        slopes = slopes.reshape(len(field), n, n, -1)
        below, above = self._in_layers(cells)
        free = (~(below | above)).astype(float)
        middle = mean(slopes, 3) * free[:, :, None] * free[:, None, :]
        e = steepest(0.5 * (middle + np.swapaxes(middle, 1, 2))) * free
        bend = total(total(e[:, None, :, None] * slopes, 2) * e[:, :, None], 1)
        rounding = 4.0 * field.shape[-1] * self._rounding(cells) * total(1.0 / cells.size, 1)
        return bend.min(axis=1) > rounding

    def fields(self, cells: Cells, gradient: Array) -> list[Array]:
        """Polynomials (N, n, ...) with d . v > 0 for all destinations where d . each > 0.

        With c the middle of the box and r the distance of its corners from it,

            d . v(z_goal) = d . grad chi |z - z_goal|^2 - 2 d . (z - z_goal).

        |z - z_goal|^2 = |z - c|^2 - 2 (z - c) . (z_goal - c) + |z_goal - c|^2 is affine in z_goal
        but for the last term, from 0 to r^2. Affine parts are least at corners; the last term does
        its worst as 0 where d . grad chi > 0 and as r^2 elsewhere. At corners it is r^2.
        """
        n = len(self.low)
        result: list[Array] = []
        for goal in self.corners:
            gamma = quadratic(cells, self.metric, goal)
            pull = linear(cells, 2.0 * self.metric, goal, self.degree + 2)
            result.append(times(gradient, gamma, n) - pull)
            if not self.is_single:
                result.append(times(gradient, gamma - self.spread, n) - pull)
        return result

    def _descends(self, cells: Cells, gradient: Array, matrix: Array) -> Mask:
        """Whether X . grad chi < 2 with X = matrix (z - z_goal)."""
        n = len(self.low)
        reach = cells.farthest(self.low, self.high)
        slopes = total(2.0 * self.degree * self._largest / cells.size * reach, 1)
        most = self._eps() * float(np.abs(matrix).max()) * n * slopes
        greatest = np.full(len(most), -np.inf)
        for goal in self.corners:
            rate = total(times(gradient, linear(cells, matrix, goal, 1), n), 1)
            greatest = np.maximum(greatest, rate.reshape(len(most), -1).max(axis=1))
        return greatest + most < 2.0 - _MARGIN

    def _descends_turned(self, cells: Cells, gradient: Array) -> Mask:
        """Whether the same holds for one of a few turned X; only outside the closing layer."""
        n = len(self.low)
        below, above = self._in_layers(cells)
        done = np.zeros(len(gradient), dtype=bool)
        inside = ~(below | above).any(axis=1)
        inverse = _inverse(self.metric)
        for (i, j), turn in product(combinations(range(n), 2), _TURNS):
            left = np.flatnonzero(inside & ~done)
            if not left.size:
                break
            matrix = np.eye(n)
            matrix += turn * (inverse[:, [i]] * np.eye(n)[j] - inverse[:, [j]] * np.eye(n)[i])
            done[left] = self._descends(cells.take(inside & ~done), gradient[left], matrix)
        return done

    def _separated(self, cells: Cells, gradient: Array) -> Mask:
        """Whether a fixed direction separates v, and the normals of faces, from zero."""
        n = len(self.low)
        fields = [each.reshape(len(gradient), n, -1) for each in self.fields(cells, gradient)]
        below, above = self._in_layers(cells)
        least, most = np.where(below, 0.0, -np.inf), np.where(above, 0.0, np.inf)
        return separable(np.concatenate(fields, axis=2), least, most, self._rounding(cells))

    def _in_layers(self, cells: Cells) -> tuple[Mask, Mask]:
        """Whether each cell meets the closing layers of the lower and upper faces, (N, n) each."""
        obstacle = self.obstacle
        slack = _MARGIN * (obstacle.upper - obstacle.lower)
        lower, upper = obstacle.inner
        below = cells.origin <= lower + slack
        above = cells.origin + cells.size >= upper - slack
        return below, above

    def _eps(self) -> float:
        return 64.0 * (self.degree + 1) ** 2 * float(np.finfo(float).eps)

    def _rounding(self, cells: Cells) -> Array:
        """Bounds (N,) of what rounding may have changed in a scalar product of v and a unit vector.

        A coefficient is a sum of some dozens of products, each off by a rounding of the largest.
        Cells inherit the roundings of those that they are halves of.
        """
        reach, size = cells.farthest(self.low, self.high), np.abs(self.metric)
        gamma = total(total(size * reach[:, :, None] * reach[:, None, :], 2), 1) + self.spread
        steep = total(2.0 * self.degree * self._largest / cells.size, 1)
        pull = total(total(2.0 * size * reach[:, None, :], 2), 1)
        return self._eps() * (gamma * steep + pull)


def _nothing(low: Array, reason: str) -> DestinationProof:
    return DestinationProof(False, False, reason, np.empty((0, len(low))), 0)


def _smoothness(obstacle: ExponentialObstacle) -> int:
    """How many continuous derivatives chi has: its degree less the most knots at one place."""
    basis = obstacle.chi.basis
    most = 1
    for knots, axis in zip(basis.knots, basis.axes, strict=True):
        inner = knots[(knots > axis.breaks[0]) & (knots < axis.breaks[-1])]
        if len(inner):
            most = max(most, int(np.unique(inner, return_counts=True)[1].max()))
    return basis.degree - most


def _is_positive_definite(matrix: Array) -> bool:
    """Whether a symmetric matrix is, by the pivots of its elimination."""
    if not np.array_equal(matrix, matrix.T):
        return False
    left = np.array(matrix, dtype=float)
    floor = 1e-12 * float(np.abs(left).max())
    for i in range(len(left)):
        if not left[i, i] > floor:
            return False
        left[i + 1 :] -= (left[i + 1 :, [i]] / left[i, i]) * left[i]
    return True


def _inverse(matrix: Array) -> Array:
    """Inverse of a small positive definite matrix, by Gauss and Jordan."""
    n = len(matrix)
    both = np.hstack([matrix, np.eye(n)])
    for i in range(n):
        both[i] = both[i] / both[i, i]
        for j in range(n):
            if j != i:
                both[j] = both[j] - both[j, i] * both[i]
    return both[:, n:]

"""The descent condition as a constraint of learning: (z - z_goal) . grad chi < limit.

Held by an augmented Lagrangian on points of the workspace (Nocedal and Wright 2006, ch. 17):
minimise cost + weight * mean(max(0, excess + shift)^2), then shift <- max(0, excess + shift). For
a certified fit, points are added at which the condition does not hold yet. If it still fails at the
end, chi is scaled down until it holds, which is possible since the condition is linear in chi.
"""

import numpy as np

from handsim.learning.direction.change_bounds import ChangeBounds
from handsim.learning.fit.designs import JetDesign
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.certificate import descent_supremum, violations
from handsim.reproducible import dot, total
from handsim.types import Array, Index

LIMIT = 2.0 - 1e-3
"""Greatest value of (z - z_goal) . grad chi in a certified field; the proof needs less than 2."""
_FEW = 0.3  # of the points; where it may be active at more, all are looked at again
_SAFE = 1e-6  # more than rounding


class DescentCondition:
    """Excess of the descent quantity over a limit, at points, for the worst of the destinations.

    Parameters
    ----------
    basis
        Of chi.
    goals : (m, n) [rad]
        Destinations; the corners of a box stand for all destinations in it.
    points : (N, n) [rad]
        Where the condition is held.
    limit, weight
        See the module's formula.
    """

    def __init__(
        self, basis: TensorBasis, goals: Array, points: Array, limit: float, weight: float
    ) -> None:
        self.basis, self.goals, self.limit = basis, _outermost(goals), limit
        self.weight = weight / len(points)
        self.points = points
        self.shift = np.zeros(len(points))
        self._lay(points)

    def __call__(self, c: Array) -> tuple[float, Array]:
        """Return the penalty of coefficients and its gradient."""
        where, design, excess, lever = self._possible(c)
        active = np.zeros(len(self.points))
        active[where] = np.maximum(excess + self.shift[where], 0.0)
        value = self.weight * dot(active, active)
        held = np.flatnonzero(active[where])  # few: elsewhere there is nothing to differentiate
        if not held.size:
            return value, np.zeros(len(c))
        slope = 2.0 * self.weight * active[where][held] * lever[:, held]
        return value, design.taken(held).pulled_back(None, slope)

    def tighten(self, c: Array) -> None:
        """Shift by what is still in excess, and add points where the certificate would fail."""
        self.shift = np.maximum(self._excess(c, self._design, self._columns)[0] + self.shift, 0.0)
        low, high = self.goals.min(axis=0), self.goals.max(axis=0)
        new = violations(TensorBSpline(self.basis, c), low, high, self.limit)
        kept = self.shift > 0.0
        self.shift = np.concatenate([self.shift[kept], np.zeros(len(new))])
        self._lay(np.vstack([self.points[kept], new]))

    def restored(self, c: Array) -> Array:
        """Scale coefficients so that the condition holds, by proof, in the whole workspace."""
        low, high = self.goals.min(axis=0), self.goals.max(axis=0)
        bound = descent_supremum(TensorBSpline(self.basis, c), low, high).upper
        return c * min(1.0, LIMIT / bound) if bound > 0.0 else c

    def _lay(self, points: Array) -> None:
        self.points = points
        self._columns = np.ascontiguousarray(points.T)
        self._design = JetDesign(self.basis, points)
        self._moved = ChangeBounds(self.basis, self._design, points, self.goals)
        self._known: tuple[Array, Array] | None = None

    def _possible(self, c: Array) -> tuple[Index, JetDesign, Array, Array]:
        """Return where the penalty may be active, the design there, and `_excess` there.

        Elsewhere it is not, by how far the coefficients are from those of which all is known.
        """
        if self._known:
            before, excess = self._known
            most = excess + self.shift + self._moved(c - before)
            where = np.flatnonzero(~(most < -_SAFE))
            if len(where) <= _FEW * len(most):
                design = self._design.taken(where)
                return where, design, *self._excess(c, design, self._columns[:, where])
        excess, lever = self._excess(c, self._design, self._columns)
        self._known = c.copy(), excess
        return np.arange(len(excess)), self._design, excess, lever

    def _excess(self, c: Array, design: JetDesign, points: Array) -> tuple[Array, Array]:
        """Excess (N,) and z - z_goal (n, N) for the worst destination, at points (n, N)."""
        grad, goals = design(c)[1], self.goals.T
        lifts = total(grad[:, None] * goals[:, :, None])  # z_goal . grad chi, (m, N)
        lever = points - goals.take(np.argmin(lifts, axis=0), axis=1)
        return total(lever * grad) - self.limit, lever


def _outermost(goals: Array) -> Array:
    """Return the corners of the convex hull of points (m, n): a linear function is least there."""
    n = goals.shape[1]
    if len(goals) <= 2**n:
        return goals
    if n == 1:
        return goals[[goals.argmin(), goals.argmax()]]
    from scipy.spatial import ConvexHull, QhullError

    try:
        return goals[ConvexHull(goals).vertices]
    except QhullError:  # flat, as destinations on one plane are
        return goals


def box_corners(points: Array) -> Array:
    """Return the corners (2**n, n) of the smallest box around points (m, n)."""
    bounds = [
        (float(a), float(b)) for a, b in zip(points.min(axis=0), points.max(axis=0), strict=True)
    ]
    return np.stack(np.meshgrid(*bounds, indexing="ij"), axis=-1).reshape(-1, points.shape[1])

"""Navigation functions that lead along a guide, with progress as a further coordinate.

A flow in the subspace alone cannot go back over the way that it came, and one obstacle for all
destinations cannot tell movements apart that pass the same posture. Therefore the state is
x = (z, s) with the progress s of the movement, and the navigation function is the one of Eq. (2) of
the paper in coordinates in which the guide p(s) is a straight line,

    y = z - p(s),   gamma_d = pull |y|^2 + length^2 (1 - s)^2,   beta = beta_0(z),

with beta_0 the closing factor of the workspace (`navigation.obstacle`), the outer boundary as
obstacle number zero. What people do is in the guide, not in beta. Coordinates of this kind are the
navigation transformations of Loizou (2017, IEEE Trans. Robot. 33(6):1516-1523).

Away from the boundary the flow goes straight, or with pull > 1 first towards the guide, so that
a hand on the guide stays on it, and

    dz/ds = p'(s) - pull (z - p(s)) / (1 - s).

Proof that every start arrives. Let e = (y, length (s - 1)). Then e . grad ln gamma_d = 2. And
e . grad ln beta_0 = (z - c(s)) . grad_z ln beta_0 with c(s) = p(s) + (1 - s) p'(s), which is never
positive if c(s) lies inside the closing layer for all s, since grad ln beta_0 points inwards on
each face. So e . grad phi > 0 but at e = 0, the destination, which is then the only critical
point. phi falls along the flow, its sublevel sets are compact (they keep off the boundary, where
phi = 1, and gamma_d is bounded on them), hence every start in the workspace arrives, at whatever
progress it begins. `GuidedField.leading` makes the workspace wide enough for that; `proven` checks.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from handsim.learning.guide.curve import Curve, interpolated
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import arc_length
from handsim.reproducible import dots, total_of, units
from handsim.types import Array

_STEP = np.deg2rad(4.0)  # the flow is straight but in the closing layer
_WITHIN = 4  # points of a path for each step: the guide bends where the flow is straight
_LEAST_LEFT = 0.05  # of the guide, where the flow is taken in a loop; see `GuidedField.velocity`


@dataclass(frozen=True, eq=False)
class GuidedField:
    """The navigation function of one query.

    Parameters
    ----------
    guide
        p(s) [rad], from a start to the destination.
    obstacle
        Workspace and closing layer; its chi is zero.
    k
        Exponent of Eq. (2).
    pull
        See the module's formula.
    """

    guide: Curve
    obstacle: ExponentialObstacle
    k: float
    pull: float

    @classmethod
    def leading(
        cls, path: Array, lower: Array, upper: Array, width: Array, k: float, pull: float
    ) -> "GuidedField":
        """Return the field of a path (m, n) in a box (n,), made wider where the proof needs it.

        Parameters
        ----------
        path
            Equally spaced, from the start to the destination [rad].
        lower, upper, width
            Box and closing layer of the learned workspace [rad].
        k
            Exponent.
        pull
            How much faster than along the guide the flow goes towards it.
        """
        guide = Curve(path)
        centres = np.vstack([guide.centres(), path])
        low = np.minimum(lower, centres.min(axis=0) - 2.0 * width)
        high = np.maximum(upper, centres.max(axis=0) + 2.0 * width)
        basis = TensorBasis.uniform(low, high, (4,) * len(low))
        chi = TensorBSpline(basis, np.zeros(basis.n_coefficients))
        return cls(guide, ExponentialObstacle(chi, width), k, pull)

    @property
    def z_goal(self) -> Array:
        """The destination (n,) [rad]."""
        return self.guide.points[-1]

    @cached_property
    def length(self) -> float:
        """Length of the guide [rad]."""
        return float(arc_length(self.guide.points)[-1])

    @cached_property
    def _inner(self) -> tuple[Array, Array]:
        return self.obstacle.inner

    @cached_property
    def _inner_numbers(self) -> tuple[list[float], list[float]]:
        low, high = self._inner
        return low.tolist(), high.tolist()

    @property
    def proven(self) -> bool:
        """Whether the proof holds: all numbers finite, and c(s) inside the closing layer."""
        low, high = self._inner
        centres = self.guide.centres()
        inside = ((centres > low) & (centres < high)).all()
        finite = np.isfinite(centres).all() and np.isfinite([self.k, self.pull, self.length]).all()
        return bool(inside and finite and self.pull > 0 and self.length > 0 and self.k >= 1)

    def straightened(self, z: Array, s: Array) -> Array:
        """Return e = (y, length (s - 1)), (N, n + 1), of states z (N, n) and s (N,)."""
        return np.column_stack([z - self.guide.at(s), self.length * (s - 1.0)])

    def restored(self, e: Array) -> tuple[Array, Array]:
        """Return z (N, n) and s (N,) of straightened coordinates (N, n + 1)."""
        s = 1.0 + e[:, -1] / self.length
        return e[:, :-1] + self.guide.at(s), s

    def flow(self, e: Array) -> Array:
        """Return unit vectors (N, n + 1) of -grad phi in straightened coordinates (N, n + 1)."""
        z, s = self.restored(e)
        return self._flow(e, z, s)

    def _flow(self, e: Array, z: Array, s: Array) -> Array:
        half = np.column_stack([self.pull * e[:, :-1], e[:, -1]])
        if self._free(z):
            return units(-2.0 * half)
        closing = self.obstacle.closure(z)[1]
        along = dots(closing, self.guide.slope(s)) / self.length
        gamma = dots(half, e)[:, None]
        by_e = np.column_stack([self._beside(closing), along])
        return units(gamma / self.k * by_e - 2.0 * half)

    def _beside(self, slope: Array) -> Array:
        """Return derivatives (N, n) by y from those by z."""
        return slope

    def _free(self, z: Array) -> bool:
        """Whether no wall is near any of some points (N, n)."""
        low, high = self._inner
        return bool(((z > low) & (z < high)).all())

    def path(self, z_start: Array, progress: float = 0.0) -> FlowPath:
        """Follow the flow from a start (n,) [rad] at some progress; the path is one of z."""
        start = self.straightened(np.asarray(z_start, dtype=float)[None], np.array([progress]))

        def flow(e: Array, _: Array) -> Array:
            return self.flow(e)

        found = follow(flow, start, np.zeros_like(start), _STEP)[0]
        last = len(found.points) - 1
        steps = np.linspace(0.0, last, last + 1)
        finer = np.linspace(0.0, last, _WITHIN * last + 1)
        points = self.restored(interpolated(finer, steps, found.points))[0]
        points[0] = z_start
        if found.arrived:
            points[-1] = self.z_goal
        return FlowPath(points, found.arrived, found.reason)

    def velocity(self, z: Array, progress: float, rate: float, closing: float) -> Array:
        """Return dz/dt (N, n) [rad/s] at postures (N, n) while progress rises.

        It is the flow, passed at the speed at which its progress rises so fast. In the closing
        layer progress may stand still; there the flow is passed as fast as the guide.

        Parameters
        ----------
        z : (N, n) [rad]
        progress
            s, from 0 to 1.
        rate : [1/s]
            ds/dt.
        closing : [1/s]
            (ds/dt) / (1 - s), limited as fits a loop with delays: `pull` times so fast a deviation
            from the guide is made up.
        """
        jet, left = self.guide.jet(progress), max(1.0 - progress, _LEAST_LEFT)
        forward = left * self.length
        if len(z) == 1:
            back = self._back(z[0].tolist(), jet[0], forward)
            if back is not None:
                share = closing * left
                return np.array([[rate * a + share * b for a, b in zip(jet[1], back, strict=True)]])
        point, slope = np.array(jet)
        y = z - point
        if self._free(z):  # the flow in closed form
            speed = np.sqrt(self.pull * self.pull * dots(y, y) + forward * forward)
            rising = np.maximum(forward, _LEAST_LEFT * speed)
            back = (-self.length * self.pull / rising)[:, None] * y
        else:
            e = np.column_stack([y, np.full(len(z), -forward)])
            flow = self._flow(e, z, np.full(len(z), progress))
            back = self.length * flow[:, :-1] / np.maximum(flow[:, -1:], _LEAST_LEFT)
        return rate * slope + closing * left * back

    def _back(
        self, z: Sequence[float], point: Sequence[float], forward: float
    ) -> list[float] | None:
        """Return the way back to the guide of one posture (n,), as `velocity` has it; for loops.

        None near a wall.
        """
        low, high = self._inner_numbers
        for a, x, b in zip(low, z, high, strict=True):
            if not a < x < b:
                return None
        y = [x - at for x, at in zip(z, point, strict=True)]
        speed = sqrt(self.pull * self.pull * total_of([a * a for a in y]) + forward * forward)
        factor = -self.length * self.pull / max(forward, _LEAST_LEFT * speed)
        return [factor * a for a in y]

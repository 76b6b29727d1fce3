"""Navigation functions that lead along a guide, with progress told by the place.

The one of `learning.guide.field`, on the states at which progress is the covered fraction of the
chord from the guide's start a to the destination b,

    s(z) = (z - a) . (b - a) / length^2,   length = |b - a|,

which makes it a function of z alone. The guide is a graph over the chord (`learning.guide.chord`):
p(s) - a - s (b - a) is at right angles to it. So y = z - p(s(z)) is, too, and e = (y, length (s -
1)) has n free numbers: two orthogonal parts of a vector of the subspace. z -> e shears the subspace
along the guide; it has an inverse, z = p(s) + y, and its determinant is 1.

The proof of `learning.guide.field` holds as it stands. Along e, the place changes by y + (s - 1)
p'(s), so e . grad ln beta_0 = (z - c(s)) . grad_z ln beta_0 with the same c(s), and what remains of
the argument does not ask how many coordinates there are.

A hand that is pushed goes on from where it is then, whatever the time. It cannot be led back over
the way that it came.
"""

from functools import cached_property

import numpy as np

from handsim.learning.guide.chord import across
from handsim.learning.guide.field import GuidedField
from handsim.navigation.paths import arc_length
from handsim.reproducible import dots, norms
from handsim.types import Array

_FINE = np.linspace(0.0, 1.0, 101)


class ChordField(GuidedField):
    """The navigation function of one query, of the place alone.

    Parameters as in `GuidedField`; the guide is a graph over its chord.
    """

    @cached_property
    def _chord(self) -> Array:
        return self.guide.points[-1] - self.guide.points[0]

    @cached_property
    def length(self) -> float:
        """Length of the chord [rad]; 1, as good as any, where it has none."""
        return float(norms(self._chord)[0]) or 1.0

    def covered(self, z: Array) -> Array:
        """Return s(z) (N,) at postures (N, n) [rad]; 1 where start and destination agree."""
        return 1.0 + dots(z - self.z_goal, self._chord) / self.length**2

    def straightened(self, z: Array, s: Array | None = None) -> Array:
        """Return e (N, n + 1) of postures z (N, n); progress is theirs, whatever ``s`` says."""
        return super().straightened(z, self.covered(z))

    def _beside(self, slope: Array) -> Array:
        return across(slope, self._chord)

    def velocity(self, z: Array, progress: float, rate: float, closing: float) -> Array:
        """Return dz/dt (N, n) [rad/s] at postures (N, n).

        It is the flow, passed such that ``closing`` times what is left of the guide is covered on
        it. Progress and its rate are not asked: the place tells how much is left.
        """
        s = self.covered(z)
        e = self.straightened(z)
        half = np.column_stack([self.pull * e[:, :-1], e[:, -1]])
        flow = self._flow(e, z, s)
        speed = closing * np.interp(s, _FINE, self._paces)[:, None] * norms(half)
        return speed * (flow[:, :-1] + flow[:, -1:] / self.length * self.guide.slope(s))

    @cached_property
    def _paces(self) -> Array:
        """(1 - A) / ((1 - s) A') at equal steps of s, with the covered fraction A of the length."""
        length = arc_length(self.guide.at(_FINE))
        covered = length / (length[-1] or 1.0)
        left = (1.0 - covered[:-1]) / (1.0 - _FINE[:-1])
        slope = np.gradient(covered, _FINE)[:-1]
        return np.append(left / np.where(slope > 0.0, slope, 1.0), 1.0)

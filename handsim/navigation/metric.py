"""How a destination attracts: gamma_d = (z - z_goal)' M(z_goal) (z - z_goal).

The paper takes M = I: where nothing obstructs, its flow is straight. People who reach for one thing
open the fingers before they close them and turn the wrist first for another; one obstacle for all
destinations cannot tell such movements apart, the metric of the destination can. With M symmetric
and positive definite gamma_d is zero at the destination alone and grows along every ray from it,
which is what Koditschek and Rimon (1990) ask of it. And since (z - z_goal) . grad ln gamma_d = 2
whatever M, the proof of convergence is the same for all M (`navigation.certificate`).

ln M is a smooth function of the destination,

    ln M(z_goal) = S_0 + sum_j K(z_goal, z_j) S_j,   K(a, b) = exp(-|a - b|^2 / (2 reach^2)),

with symmetric S: M is then positive definite for all values of S, and far from the destinations it
was learned at it tends to exp(S_0). (Logarithms make a vector space of the metrics: Arsigny et al.
2006, Magn. Reson. Med. 56(2):411-421.)
"""

from dataclasses import dataclass, field

import numpy as np

from handsim.navigation.matrix_exponential import exponential
from handsim.reproducible import dots, exp, total
from handsim.types import Array

_Answer = tuple[tuple[tuple[int, ...], bytes], Array]  # shape and bytes asked for, metrics
_Known = tuple[dict[bytes, int], Array]  # destinations as bytes to places, and their metrics


@dataclass(frozen=True)
class DestinationMetric:
    """The metric M of every destination.

    Parameters
    ----------
    centres : (m, n) [rad]
        Destinations z_j.
    logs : (1 + m, n, n)
        S_0, then the S_j; symmetric.
    reach : [rad]
        Distance over which destinations share their metric.
    """

    centres: Array
    logs: Array
    reach: float
    _latest: list[_Answer] = field(default_factory=list[_Answer], compare=False, repr=False)
    _known: list[_Known] = field(default_factory=list[_Known], compare=False, repr=False)

    def at(self, z_goal: Array) -> Array:
        """Return the metrics (..., n, n) of destinations (..., n) [rad].

        Paths are followed to the same destinations step after step, to fewer of them as paths end.
        Therefore the latest answer is kept, and the metrics of the latest set of destinations that
        had to be computed, each of which is computed once however often it is repeated.
        """
        shape = np.shape(z_goal)
        asked = (shape, np.asarray(z_goal, dtype=float).tobytes())
        for answered, metrics in self._latest[:1]:
            if answered == asked:
                return metrics
        goals = np.ascontiguousarray(np.reshape(z_goal, (-1, shape[-1])), dtype=float)
        metrics = self._found(goals).reshape(*shape, shape[-1])
        self._latest[:] = [(asked, metrics)]
        return metrics

    def _found(self, goals: Array) -> Array:
        """Return the metrics (N, n, n) of destinations (N, n), from what is known if all are."""
        keys = goals.view(f"V{goals.itemsize * goals.shape[1]}").ravel().tolist()
        for places, metrics in self._known[:1]:
            where = [places.get(key, -1) for key in keys]
            if -1 not in where:
                return metrics[where]
        different = dict(zip(keys, goals, strict=True))
        places = {key: place for place, key in enumerate(different)}
        metrics = self._computed(np.array(list(different.values())))
        self._known[:] = [(places, metrics)]
        return metrics[[places[key] for key in keys]]

    def _computed(self, goals: Array) -> Array:
        shares = gaussian_kernel(goals, self.centres, self.reach)
        logs = self.logs[0] + total(shares[:, :, None, None] * self.logs[1:], 1)
        return exponential(logs)


def gaussian_kernel(a: Array, b: Array, reach: float) -> Array:
    """Return K between points a (N, n) and b (m, n), (N, m)."""
    apart = a[:, None] - b[None]
    return exp(-0.5 * dots(apart, apart) / (reach * reach))

"""How a destination attracts: gamma_d = (z - z_goal)' M(z_goal) (z - z_goal).

The paper takes M = I: where nothing obstructs, its flow is straight. People who reach for one thing
open the fingers before they close them and turn the wrist first for another; one obstacle for all
destinations cannot tell such movements apart, the metric of the destination can. With M symmetric
and positive definite gamma_d is zero at the destination alone and grows along every ray from it,
which is what Koditschek and Rimon (1990) ask of it. And since (z - z_goal) . grad ln gamma_d = 2
whatever M, the proof of convergence is the same for all M (`certificate`).

ln M is a smooth function of the destination,

    ln M(z_goal) = S_0 + sum_j K(z_goal, z_j) S_j,   K(a, b) = exp(-|a - b|^2 / (2 reach^2)),

with symmetric S: M is then positive definite for all values of S, and far from the destinations it
was learned at it tends to exp(S_0). (Logarithms make a vector space of the metrics: Arsigny et al.
2006, Magn. Reson. Med. 56(2):411-421.)
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
_Asked = tuple[tuple[int, ...], bytes]


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
    _latest: list[tuple[_Asked, Array]] = field(default_factory=list, compare=False, repr=False)

    def at(self, z_goal: Array) -> Array:
        """Return the metrics (..., n, n) of destinations (..., n) [rad].

        The latest answer is kept: paths are followed to the same destinations step after step.
        """
        shape = np.shape(z_goal)
        asked = (shape, np.asarray(z_goal, dtype=float).tobytes())
        for answered, metrics in self._latest[:1]:
            if answered == asked:
                return metrics
        goals = np.reshape(z_goal, (-1, shape[-1]))
        shares = gaussian_kernel(goals, self.centres, self.reach)
        logs = self.logs[0] + np.einsum("ij,jkl->ikl", shares, self.logs[1:])
        metrics = exponential(*np.linalg.eigh(logs)).reshape(*shape, shape[-1])
        self._latest[:] = [(asked, metrics)]
        return metrics


def gaussian_kernel(a: Array, b: Array, reach: float) -> Array:
    """Return K between points a (N, n) and b (m, n), (N, m)."""
    squares = np.sum((a[:, None] - b[None]) ** 2, axis=-1)
    return np.exp(-0.5 * squares / reach**2)


def exponential(eigenvalues: Array, eigenvectors: Array) -> Array:
    """Return exp of symmetric matrices (N, n, n) by their eigenvalues and eigenvectors."""
    return (eigenvectors * np.exp(eigenvalues)[:, None, :]) @ np.swapaxes(eigenvectors, 1, 2)

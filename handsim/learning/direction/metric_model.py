"""The metric of destinations as a function of parameters, and its gradient, for learners.

ln M(z_goal) = sum_j f_j(z_goal) sum_b p_jb E_b, with E_b an orthonormal basis of the symmetric
matrices without trace (a factor of M drops out of the flow) and features f of the destination: 1,
and the kernel whitened on a few of the recorded destinations, f = L^-1 K(centres, z_goal) with
L L' = K(centres, centres). Then |p|^2 is the norm of the kernel's function space, the natural
penalty: it makes of each entry a Gaussian-process prior (Rasmussen and Williams 2006, ch. 6).
"""

from collections.abc import Callable
from itertools import product

import numpy as np
import numpy.typing as npt

from handsim.navigation.metric import DestinationMetric, Exponential, gaussian_kernel
from handsim.reproducible import lower_solved, total, upper_solved
from handsim.types import Array

_MOST_CENTRES = 40
_UNEXPLAINED = 0.02  # of the kernel's variance at a destination, from which on it is a centre


class MetricModel:
    """Metrics of recorded destinations as a function of parameters.

    Parameters
    ----------
    goals : (N, n) [rad]
        Recorded destinations, repeated as they may be.
    reach : [rad]
        See `DestinationMetric`.

    Attributes
    ----------
    goals : (m, n) [rad]
        The different ones among them.
    n_parameters
        None in one dimension, where there is nothing to turn.
    """

    def __init__(self, goals: Array, reach: float) -> None:
        self.goals = np.unique(goals, axis=0)
        self.reach = reach
        self._matrices = traceless_symmetric(goals.shape[1])
        self._centres, self._lower = _chosen(self.goals, reach)
        shares = gaussian_kernel(self._centres, self.goals, reach)
        whitened = lower_solved(self._lower, shares)
        self._features = np.vstack([np.ones(len(self.goals)), whitened])  # (f, m)
        self.n_parameters = len(self._matrices) * len(self._features)

    def metrics(self, p: Array) -> tuple[Array, Callable[[Array], Array]]:
        """Return M at `goals`, (m, n, n), and what takes a gradient by M back to one by ``p``."""
        found = Exponential(total(self._features[:, :, None, None] * self._weights(p)[:, None]))

        def pulled_back(slope: Array) -> Array:
            # The derivative of the exponential at a symmetric matrix is its own transpose.
            by_log = found.slopes(slope)
            by_entry = self._entries(by_log)
            return total(self._features[:, :, None] * by_entry, 1).ravel()

        return found.value, pulled_back

    def metric(self, p: Array) -> DestinationMetric:
        """Return the metric of every destination."""
        weights = self._weights(p)
        flat = weights[1:].reshape(len(self._centres), -1)
        logs = upper_solved(self._lower.T, flat).reshape(weights[1:].shape)
        return DestinationMetric(self._centres, np.concatenate([weights[:1], logs]), self.reach)

    def _weights(self, p: Array) -> Array:
        """Return the symmetric matrix of each feature, (f, n, n)."""
        shaped = p.reshape(len(self._features), len(self._matrices))
        return total(shaped[:, :, None, None] * self._matrices, 1)

    def _entries(self, matrices: Array) -> Array:
        """Return the components (m, b) of matrices (m, n, n) along the basis."""
        return total(total(matrices[:, None] * self._matrices, -1), -1)


class Attraction:
    """grad ln gamma_d at points, as a function of the metric's parameters.

    Parameters
    ----------
    model
        None for the Euclidean distance.
    points, goals : (N, n) [rad]
        The goals among those of the model.
    """

    def __init__(self, model: MetricModel | None, points: Array, goals: Array) -> None:
        self._model = model
        self._away = np.ascontiguousarray((points - goals).T)
        if model:
            self._which = _which(model.goals, goals)

    def __call__(self, p: Array) -> tuple[Array, Callable[[Array], Array]]:
        """Return the gradients (n, N), and what takes a cost's slope by them to one by ``p``."""
        away = self._away
        if self._model is None:
            return 2.0 * away / total(away * away), lambda _: p
        metrics, pulled_back = self._model.metrics(p)
        at_points = np.ascontiguousarray(metrics.T).take(self._which, axis=2)  # symmetric
        half = total(at_points * away[:, None])
        scale = 2.0 / total(half * away)
        pull = scale * half

        def by_parameters(slope: Array) -> Array:
            # d(2 M e / e'Me) = (2 / e'Me) (dM e - (M e) e'dM e / e'Me), dM symmetric
            along = total(slope * pull)
            left = scale * (slope - 0.5 * along * away)
            by_metric = np.empty_like(metrics)
            for i, j in product(range(len(left)), repeat=2):
                outer = left[i] * away[j]
                by_metric[:, i, j] = np.bincount(self._which, outer, minlength=len(metrics))
            return pulled_back(0.5 * (by_metric + np.swapaxes(by_metric, 1, 2)))

        return pull, by_parameters


def _which(different: Array, goals: Array) -> npt.NDArray[np.int64]:
    """Which of the ``different`` goals each goal is; many in a row are the same."""
    places = {tuple(goal): i for i, goal in enumerate(different.tolist())}
    is_new = np.append(True, (goals[1:] != goals[:-1]).any(axis=1))
    of_rows = np.array([places[tuple(goal)] for goal in goals[is_new].tolist()])
    return of_rows[np.cumsum(is_new) - 1]


def traceless_symmetric(n: int) -> Array:
    """Return an orthonormal basis (n (n + 1) / 2 - 1, n, n) of symmetric matrices of trace 0."""
    basis: list[Array] = []
    for i in range(n):
        for j in range(i):
            matrix = np.zeros((n, n))
            matrix[i, j] = matrix[j, i] = np.sqrt(0.5)
            basis.append(matrix)
    for i in range(1, n):  # diagonals: 1, ..., 1, -i
        diagonal = np.append(np.ones(i), [-i, *np.zeros(n - i - 1)])
        basis.append(np.diag(diagonal / np.sqrt(i + i * i)))
    return np.array(basis).reshape(-1, n, n)


def _chosen(goals: Array, reach: float) -> tuple[Array, Array]:
    """Centres (m, n), and the Cholesky factor (m, m) of their kernel, by greedy pivoting.

    Next is always the destination of which the kernel on those chosen explains least.
    """
    unexplained = np.ones(len(goals))
    rows = np.zeros((0, len(goals)))
    chosen: list[int] = []
    while len(chosen) < _MOST_CENTRES and unexplained.max() > _UNEXPLAINED:
        pivot = int(np.argmax(unexplained))
        row = gaussian_kernel(goals[[pivot]], goals, reach)[0] - total(rows[:, [pivot]] * rows)
        row /= np.sqrt(unexplained[pivot])
        rows = np.vstack([rows, row])
        unexplained = unexplained - row**2
        chosen.append(pivot)
    return goals[chosen], np.tril(rows[:, chosen].T)

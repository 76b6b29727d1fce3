"""Parameters of the metric of destinations, for learners: to the metrics and back the gradient.

ln M(z_goal) = sum_j f_j(z_goal) sum_b p_jb E_b, with E_b an orthonormal basis of the symmetric
matrices without trace (a factor of M drops out of the flow) and features f of the destination: 1,
and the kernel whitened on a few of the recorded destinations, f = L^-1 K(centres, z_goal) with
L L' = K(centres, centres). Then |p|^2 is the norm of the kernel's function space, the natural
penalty: it makes of each entry a Gaussian-process prior (Rasmussen and Williams 2006, ch. 6).
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import sparse

from handsim.learning.attraction import DestinationMetric, exponential, gaussian_kernel

Array = npt.NDArray[np.float64]

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
        whitened: Array = np.linalg.solve(self._lower, shares).astype(float)
        self._features = np.vstack([np.ones(len(self.goals)), whitened]).T
        self.n_parameters = len(self._matrices) * self._features.shape[1]

    def metrics(self, p: Array) -> tuple[Array, Callable[[Array], Array]]:
        """Return M at `goals`, (m, n, n), and what takes a gradient by M back to one by ``p``."""
        shaped = p.reshape(self._features.shape[1], len(self._matrices))
        logs = np.einsum("gf,fb,bij->gij", self._features, shaped, self._matrices, optimize=True)
        eigenvalues, vectors = np.linalg.eigh(logs)
        turned = np.swapaxes(vectors, 1, 2)

        def pulled_back(slope: Array) -> Array:
            quotients = _divided_differences(eigenvalues)
            by_log = vectors @ (quotients * (turned @ slope @ vectors)) @ turned
            by_entry = np.einsum("gij,bij->gb", by_log, self._matrices)
            return (self._features.T @ by_entry).ravel()

        return exponential(eigenvalues, vectors), pulled_back

    def metric(self, p: Array) -> DestinationMetric:
        """Return the metric of every destination."""
        shaped = p.reshape(self._features.shape[1], len(self._matrices))
        weights = np.vstack([shaped[:1], np.linalg.solve(self._lower.T, shaped[1:])])
        logs = np.einsum("fb,bij->fij", weights, self._matrices)
        return DestinationMetric(self._centres, logs, self.reach)


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
        self._away = points - goals
        if model:
            self._which, self._gather = _groups(model.goals, goals)

    def __call__(self, p: Array) -> tuple[Array, Callable[[Array], Array]]:
        """Return the gradients (N, n), and what takes a cost's slope by them to one by ``p``."""
        if self._model is None:
            squares = np.sum(self._away**2, axis=1, keepdims=True)
            return 2.0 * self._away / squares, lambda _: p
        metrics, pulled_back = self._model.metrics(p)
        half = np.einsum("ijk,ik->ij", metrics[self._which], self._away)
        scale = 2.0 / np.einsum("ij,ij->i", half, self._away)[:, None]
        pull = scale * half

        def by_parameters(slope: Array) -> Array:
            # d(2 M e / e'Me) = (2 / e'Me) (dM e - (M e) e'dM e / e'Me), dM symmetric
            along = np.einsum("ij,ij->i", slope, pull)[:, None]
            left = scale * (slope - 0.5 * along * self._away)
            outer = left[:, :, None] * self._away[:, None, :]
            n = outer.shape[1]
            total = (self._gather @ outer.reshape(len(outer), -1)).reshape(-1, n, n)
            return pulled_back(0.5 * (total + np.swapaxes(total, 1, 2)))

        return pull, by_parameters


def _groups(different: Array, goals: Array) -> tuple[npt.NDArray[np.int64], sparse.csr_array]:
    """Which of the ``different`` goals each goal is, and the matrix that sums over those alike."""
    both = np.vstack([different, goals])
    which = np.unique(both, axis=0, return_inverse=True)[1].ravel()[len(different) :]
    ones = np.ones(len(goals))
    gather = sparse.csr_array((ones, (which, np.arange(len(goals)))), (len(different), len(goals)))
    return which, gather


def traceless_symmetric(n: int) -> Array:
    """Return an orthonormal basis (n (n + 1) / 2 - 1, n, n) of symmetric matrices of trace 0."""
    basis = []
    for i in range(n):
        for j in range(i):
            matrix = np.zeros((n, n))
            matrix[i, j] = matrix[j, i] = np.sqrt(0.5)
            basis.append(matrix)
    for i in range(1, n):  # diagonals: 1, ..., 1, -i
        diagonal = np.append(np.ones(i), [-i, *np.zeros(n - i - 1)])
        basis.append(np.diag(diagonal / np.linalg.norm(diagonal)))
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
        row = gaussian_kernel(goals[[pivot]], goals, reach)[0] - rows[:, pivot] @ rows
        row /= np.sqrt(unexplained[pivot])
        rows = np.vstack([rows, row])
        unexplained = unexplained - row**2
        chosen.append(pivot)
    return goals[chosen], np.tril(rows[:, chosen].T)


def _divided_differences(eigenvalues: Array) -> Array:
    """Return (exp a - exp b) / (a - b) of all pairs (m, n, n): the derivative of the exponential.

    Daleckii and Krein 1965; Higham 2008, Functions of Matrices, Theorem 3.11.
    """
    mean = 0.5 * (eigenvalues[:, :, None] + eigenvalues[:, None, :])
    half = 0.5 * (eigenvalues[:, :, None] - eigenvalues[:, None, :])
    ratio = np.sinh(half) / np.where(half == 0.0, 1.0, half)
    return np.exp(mean) * np.where(half == 0.0, 1.0, ratio)

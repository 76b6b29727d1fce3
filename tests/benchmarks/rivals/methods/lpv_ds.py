"""Linear parameter-varying dynamical systems (LPV-DS): stable by a quadratic Lyapunov function.

With x the place relative to the destination, velocities are x' = sum_k h_k(x) A_k x, where the
h_k are the posteriors of a mixture of Gaussians over places (N. Figueroa, A. Billard, CoRL 2018;
S. M. Khansari-Zadeh, A. Billard 2011 for SEDS). If P A_k + A_k^T P is negative definite for all k
with one positive P, x^T P x falls along all paths, whatever the h_k are.

The condition is held by the form of the parameters instead of by a semi-definite program,
P = L L^T + e and P A_k = W_k - S_k S_k^T - e with W_k skew, which reaches all P and A_k that hold
it with some room. P and all A_k are fitted together, by least squares of the velocity.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.optimize import minimize

from handsim.types import Array

from ..fields import Field, FieldRival
from ..mixture import Mixture
from ..protocol import Movement, Query
from ..scoring import resampled

_N_SAMPLES = 50  # a movement, equally spaced in time
_MOST_GAUSSIANS = 7
_ROOM = 1e-2  # e: least decay, relative to the mean speed over the mean distance
_ITERATIONS = 300


@dataclass(frozen=True, eq=False)
class LinearSystems:
    """Posteriors and matrices of a system whose destination is the origin.

    Attributes
    ----------
    mixture
    matrices : (k, d, d) [1/s], metric : (d, d)
        A_k and P.
    """

    mixture: Mixture
    matrices: Array
    metric: Array

    def __call__(self, x: Array) -> Array:
        """Return velocities (N, d) at places (N, d)."""
        shares = self.mixture.shares(x)
        return np.einsum("nk,nki->ni", shares, np.einsum("kij,nj->nki", self.matrices, x))

    @property
    def is_stable(self) -> bool:
        """Whether P and all -(P A_k + A_k^T P) are positive definite."""
        half = self.metric @ self.matrices
        decay = -(half + half.transpose(0, 2, 1))
        least = min(np.linalg.eigvalsh(decay).min(), np.linalg.eigvalsh(self.metric).min())
        return bool(least > 0.0)


class LinearParameterVarying(FieldRival):
    """LPV-DS over all movements, their destinations moved to the origin.

    Parameters
    ----------
    by_object
        One system for each object; else one for all.
    """

    argument = "x'Px falls"

    def __init__(self, by_object: bool) -> None:
        self.by_object = by_object

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Fit the systems."""
        objects = dict.fromkeys(each.object for each in movements)
        self.systems = {"": fitted(movements)}
        if self.by_object and len(objects) > 1:
            for name in objects:
                self.systems[name] = fitted([each for each in movements if each.object == name])
        return self

    def field(self, name: str) -> Field:
        """Return the system of an object, or of all where it is not known."""
        system = self.systems.get(name, self.systems[""])
        return lambda z, goals: system(z - goals)

    def speeds(self, path: Array, query: Query) -> Array:
        """Return the speeds that were learned."""
        goals = np.broadcast_to(query.goal, path.shape)
        return np.linalg.norm(self.field(query.object)(path, goals), axis=1)

    def proves(self, query: Query) -> bool:
        """Whether the system is stable: for every destination, as it is moved to the origin."""
        return self.systems.get(query.object, self.systems[""]).is_stable


def fitted(movements: Sequence[Movement]) -> LinearSystems:
    """Fit a mixture to places, and stable matrices to velocities."""
    x, velocities = samples(movements)
    length = float(np.sqrt(np.mean(np.sum(x**2, axis=1))))
    speed = float(np.sqrt(np.mean(np.sum(velocities**2, axis=1))))
    mixture = Mixture.best(x, _MOST_GAUSSIANS)
    model = Model(x / length, velocities / speed, mixture.shares(x))
    found = minimize(
        model.cost, model.start(), jac=True, method="L-BFGS-B", options={"maxiter": _ITERATIONS}
    )
    matrices, metric = model.matrices(found.x)
    return LinearSystems(mixture, matrices * (speed / length), metric)


def samples(movements: Sequence[Movement]) -> tuple[Array, Array]:
    """Return places relative to the destination and velocities, both (N, d)."""
    even = np.linspace(0.0, 1.0, _N_SAMPLES)
    places: list[Array] = []
    velocities: list[Array] = []
    for each in movements:
        share = (each.time - each.time[0]) / each.duration
        path = resampled(share, each.path - each.path[-1], even)
        places.append(path)
        velocities.append(np.gradient(path, even * each.duration, axis=0))
    return np.vstack(places), np.vstack(velocities)


class Model:
    """Least squares of velocities by L, all S_k and all W_k, flat in this order."""

    def __init__(self, x: Array, velocities: Array, shares: Array) -> None:
        self.d, self.k = x.shape[1], shares.shape[1]
        # The error is quadratic in the stacked transposes of the matrices (k d, d).
        inputs = (shares[:, :, None] * x[:, None, :]).reshape(len(x), -1)
        self.quadratic = inputs.T @ inputs / len(x)
        self.linear = inputs.T @ velocities / len(x)
        self.constant = float(np.mean(np.sum(velocities**2, axis=1)))
        self.lower, self.upper = np.tril_indices(self.d), np.triu_indices(self.d, 1)

    def start(self) -> Array:
        """Return the parameters of P = 1 and A_k = -1, but for the room."""
        one = np.sqrt(1.0 - _ROOM) * np.eye(self.d)[self.lower]
        skew = np.zeros(self.k * len(self.upper[0]))
        return np.concatenate([np.tile(one, 1 + self.k), skew])

    def matrices(self, parameters: Array) -> tuple[Array, Array]:
        """Return A_k (k, d, d) and P (d, d)."""
        factor, roots, skew = self._unpacked(parameters)
        metric = factor @ factor.T + _ROOM * np.eye(self.d)
        half = skew - roots @ roots.transpose(0, 2, 1) - _ROOM * np.eye(self.d)
        return np.linalg.inv(metric) @ half, metric

    def cost(self, parameters: Array) -> tuple[float, Array]:
        """Return the mean squared error of velocities, and its gradient."""
        factor, roots, _ = self._unpacked(parameters)
        matrices, metric = self.matrices(parameters)
        stacked = matrices.transpose(0, 2, 1).reshape(-1, self.d)
        product = self.quadratic @ stacked
        error = self.constant + float(np.sum(stacked * (product - 2.0 * self.linear)))
        by_stacked = 2.0 * (product - self.linear)
        by_matrix = by_stacked.reshape(self.k, self.d, self.d).transpose(0, 2, 1)
        by_half = np.linalg.solve(metric, by_matrix)  # P A_k = half, P is symmetric
        by_metric = -np.sum(by_half @ matrices.transpose(0, 2, 1), axis=0)
        by_factor = (by_metric + by_metric.T) @ factor
        by_roots = -(by_half + by_half.transpose(0, 2, 1)) @ roots
        by_skew = by_half - by_half.transpose(0, 2, 1)
        gradient = [
            by_factor[self.lower],
            by_roots[:, *self.lower].ravel(),
            by_skew[:, *self.upper].ravel(),
        ]
        return error, np.concatenate(gradient)

    def _unpacked(self, parameters: Array) -> tuple[Array, Array, Array]:
        """Return L (d, d), S_k and W_k (k, d, d)."""
        n = len(self.lower[0])
        factor, roots = np.zeros((self.d, self.d)), np.zeros((self.k, self.d, self.d))
        skew = np.zeros_like(roots)
        factor[self.lower] = parameters[:n]
        roots[:, *self.lower] = parameters[n : n * (1 + self.k)].reshape(self.k, n)
        skew[:, *self.upper] = parameters[n * (1 + self.k) :].reshape(self.k, -1)
        return factor, roots, skew - skew.transpose(0, 2, 1)

"""Regression of the velocity of motion by place and destination, without a reason to arrive."""

import warnings
from collections.abc import Sequence
from typing import Self

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel

from handsim.navigation.paths import at_arc_length
from handsim.types import Array

from ..fields import Field, FieldRival, unit
from ..mixture import Mixture
from ..protocol import Movement

_N_SAMPLES = 50  # a movement, up to 97 % of its length
_N_GAUSSIANS = 20


class MixtureRegression(FieldRival):
    """Mean direction given place and destination under a mixture of Gaussians (Calinon 2007).

    Directions in place of velocities: those of people at rest point nowhere.
    """

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Fit the mixture to (place, destination, direction)."""
        inputs, outputs = samples(movements)
        joint = np.hstack([inputs, outputs])
        n = inputs.shape[1]
        whole = Mixture.of(joint, min(_N_GAUSSIANS, len(joint) // 10), 1e-4)
        self.inputs = whole.over(slice(n))
        cross = whole.covariances[:, n:, :n]
        self.gains = cross @ self.inputs.precisions
        self.output_means = whole.means[:, n:]
        return self

    def field(self, name: str) -> Field:
        """Return the conditional mean, whatever the object."""
        return self._velocities

    def _velocities(self, z: Array, goals: Array) -> Array:
        inputs = np.hstack([z, goals])
        away = inputs[:, None] - self.inputs.means
        means = self.output_means + np.einsum("koi,nki->nko", self.gains, away)
        return np.einsum("nk,nko->no", self.inputs.shares(inputs), means)


class ProcessRegression(FieldRival):
    """Mean direction of a Gaussian process over place and destination, every other sample."""

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Fit the reaches of the kernel, one for each input."""
        inputs, outputs = samples(movements)
        kernel = RBF([0.5] * inputs.shape[1], (0.05, 20)) + WhiteKernel(0.1)
        self.model = GaussianProcessRegressor(kernel)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # reaches of idle inputs
            self.model.fit(inputs[::2], outputs[::2])
        return self

    def field(self, name: str) -> Field:
        """Return the mean of the process, whatever the object."""
        return lambda z, goals: np.asarray(self.model.predict(np.hstack([z, goals])))


def samples(movements: Sequence[Movement]) -> tuple[Array, Array]:
    """Return places with destinations (N, 2 d) and directions of motion (N, d)."""
    fractions = np.linspace(0.0, 0.97, _N_SAMPLES)
    inputs: list[Array] = []
    outputs: list[Array] = []
    for each in movements:
        points = at_arc_length(each.path, fractions)
        inputs.append(np.hstack([points, np.tile(each.path[-1], (_N_SAMPLES, 1))]))
        outputs.append(unit(np.gradient(points, axis=0)))
    return np.vstack(inputs), np.vstack(outputs)

"""Regression of the velocity of motion by place and destination, without a reason to arrive."""

from collections.abc import Sequence
from typing import Self

import numpy as np

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

"""Obstacle functions beta over a box of the subspace, given as ln beta.

`ExponentialObstacle` is beta = beta_0 exp(k chi) with chi a spline: positive in the whole
workspace and zero on its boundary by construction (Eqs. 4 and 5 of the paper). In `SplineObstacle`
beta itself is a spline, as in the paper (Eq. 9). Both give ln beta, because phi spans many decades
in beta and gamma_d^k.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import Protocol

import numpy as np

from handsim.navigation._spline_evaluator import SplineEvaluator
from handsim.navigation.bspline import TensorBSpline
from handsim.types import Array

LogEvaluator = Callable[[list[float]], list[float]]


_TINY_DEPTH = 1e-12  # depth in the closing layer, as a fraction of its width, taken as its boundary


TINY_BETA = 1e-12
"""Least beta whose logarithm is taken; where beta is less, the obstacle is."""


class Obstacle(Protocol):
    """The properties and functions of beta that a navigation function uses."""

    @property
    def lower(self) -> Array:
        """Lower corner of the workspace, (n,) [rad]."""
        ...

    @property
    def upper(self) -> Array:
        """Upper corner of the workspace, (n,) [rad]."""
        ...

    @property
    def inner(self) -> tuple[Array, Array]:
        """Corners (n,) [rad] of the box of possible destinations, without any closing layer."""
        ...

    def evaluator(self, k: float) -> LogEvaluator:
        """Return a function of one point as n floats: ln beta, then its gradient."""
        ...

    def log_jets(self, z: Array, k: float, order: int) -> tuple[Array, Array, Array]:
        """Return ln beta (N,), its gradients (N, n) and Hessians (N, n, n) at points (N, n)."""
        ...


def closing(distance: float, width: float) -> tuple[float, float]:
    """Return ln b of the closing layer and its slope, for one point in the layer.

    Parameters
    ----------
    distance
        From the surface, less than ``width``.
    width
        Thickness of the layer.
    """
    t = max(distance / width, _TINY_DEPTH)
    b = t * (3 - 3 * t + t * t)  # 1 - (1 - t)^3 without cancellation at the boundary
    return log(b), 3 * (1 - t) ** 2 / (b * width)


@dataclass(frozen=True)
class ExponentialObstacle:
    """beta = beta_0 exp(k chi), positive inside the workspace and zero on its boundary.

    beta_0 is the outer boundary as obstacle number zero (Koditschek and Rimon 1990): the product
    over the faces of the box of b(t) = 1 - (1 - t)^3, with t the distance from the face as
    a fraction of ``width``, and 1 beyond. It is C^2 inside and has a slope on the boundary, so
    that the flow points inwards there.

    Parameters
    ----------
    chi
        Spline over the workspace, the box of its domain.
    width : (n,) [rad]
        Thickness of the closing layer along each dimension.
    """

    chi: TensorBSpline
    width: Array

    @property
    def lower(self) -> Array:
        """Lower corner of the workspace, (n,) [rad]."""
        return self.chi.basis.lower

    @property
    def upper(self) -> Array:
        """Upper corner of the workspace, (n,) [rad]."""
        return self.chi.basis.upper

    @property
    def inner(self) -> tuple[Array, Array]:
        """Corners (n,) [rad] of the box of possible destinations, without the closing layer."""
        return self.lower + self.width, self.upper - self.width

    @cached_property
    def _faces(self) -> list[tuple[float, float, float]]:
        faces = zip(self.lower, self.upper, self.width, strict=True)
        return [(float(low), float(high), float(width)) for low, high, width in faces]

    def evaluator(self, k: float) -> LogEvaluator:
        """Return a function of one point as n floats: ln beta, then its gradient."""
        chi, faces = SplineEvaluator(self.chi), self._faces

        def log_jet(z: list[float]) -> list[float]:
            parts = [k * part for part in chi(z).tolist()]
            for i, (low, high, width) in enumerate(faces):
                for distance, inward in ((z[i] - low, 1.0), (high - z[i], -1.0)):
                    if distance < width:
                        ln_b, slope = closing(distance, width)
                        parts[0] += ln_b
                        parts[i + 1] += inward * slope
            return parts

        return log_jet

    def log_jets(self, z: Array, k: float, order: int) -> tuple[Array, Array, Array]:
        """Return ln beta (N,), its gradients (N, n) and Hessians (N, n, n) at points (N, n)."""
        value, grad, hess = (k * part for part in self.chi.jets(z, order))
        closure, closure_grad, closure_hess = self.closure(z)
        value += closure
        if order >= 1:
            grad += closure_grad
        if order >= 2:
            diagonal = np.arange(len(self.width))
            hess[:, diagonal, diagonal] += closure_hess
        return value, grad, hess

    def closure(self, z: Array) -> tuple[Array, Array, Array]:
        """Return ln beta_0 (N,), its gradients (N, n) and the diagonals of its Hessians (N, n)."""
        value, grad, hess = np.zeros(len(z)), np.zeros_like(z), np.zeros_like(z)
        for distance, inward in ((z - self.lower, 1.0), (self.upper - z, -1.0)):
            near = np.nonzero(distance < self.width)  # few points, often none; elsewhere b is 1
            if not near[0].size:
                continue
            width = self.width[near[1]]
            t = np.maximum(distance[near] / width, _TINY_DEPTH)
            b = t * (3 - 3 * t + t * t)  # 1 - (1 - t)^3 without cancellation at the boundary
            slope = 3 * (1 - t) ** 2 / b
            value += np.bincount(near[0], np.log(b), minlength=len(z))
            grad[near] += inward * slope / width
            hess[near] += (-6 * (1 - t) / b - slope**2) / width**2
        return value, grad, hess


@dataclass(frozen=True)
class SplineObstacle:
    """beta as a spline itself, Eq. (9) of the paper; nothing keeps it positive.

    Where it is not, ln beta is taken at 1e-12, so that phi is 1 and the flow climbs beta.
    """

    beta: TensorBSpline

    @property
    def lower(self) -> Array:
        """Lower corner of the workspace, (n,) [rad]."""
        return self.beta.basis.lower

    @property
    def upper(self) -> Array:
        """Upper corner of the workspace, (n,) [rad]."""
        return self.beta.basis.upper

    @property
    def inner(self) -> tuple[Array, Array]:
        """Corners (n,) [rad] of the box of possible destinations: the whole workspace."""
        return self.lower, self.upper

    def evaluator(self, k: float) -> LogEvaluator:
        """Return a function of one point as n floats: ln beta, then its gradient."""
        spline = SplineEvaluator(self.beta)

        def log_jet(z: list[float]) -> list[float]:
            beta, *grad = spline(z).tolist()
            beta = max(beta, TINY_BETA)
            return [log(beta), *[part / beta for part in grad]]

        return log_jet

    def log_jets(self, z: Array, k: float, order: int) -> tuple[Array, Array, Array]:
        """Return ln beta (N,), its gradients (N, n) and Hessians (N, n, n) at points (N, n)."""
        beta, grad, hess = self.beta.jets(z, order)
        beta = np.maximum(beta, TINY_BETA)
        if order >= 1:
            grad = grad / beta[:, None]
        if order >= 2:
            hess = hess / beta[:, None, None] - grad[:, :, None] * grad[:, None, :]
        return np.log(beta), grad, hess

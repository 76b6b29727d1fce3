"""Fit all postures of a movement together: Levenberg and Marquardt's method in a band matrix.

Each posture has its own sum of squares; neighbours are bound by how far they are apart, and more so
where they are further apart than they may be. The matrix of the whole movement is banded: a
posture is bound to the next one joint by joint. So one step costs n times what a posture costs.
Coordinates at an end of their range that would leave it are held there for the step.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

from handsim.retargeting.solving.residuals import Quadratic
from handsim.types import Array, Index, Mask

_DAMPING = 1e-3
"""First damping, relative to the diagonal of the curvature."""
_LEVEL = 0.1
"""What is added to the diagonal for damping, relative to its largest entry."""
SETTLED = 1e-3
"""Change of coordinates at which a fit ends [rad or m]."""
_LONGEST = 0.5
"""Longest step of a coordinate [rad]: beyond, the quadratic is not believed."""


class Movement:
    """How postures of a movement are bound to one another.

    Parameters
    ----------
    previous
        Weight of the distance to the posture before; (n - 1, 1) if not all have the same.
    speed
        Weight of what is beyond the largest change.
    steps : (n - 1, m)
        Largest change of each coordinate from posture to posture.
    """

    def __init__(self, previous: float | Array, speed: float, steps: Array) -> None:
        self.previous, self.speed, self.steps = previous, speed, steps

    def unlimited(self) -> "Movement":
        """Return the same without a largest change."""
        return Movement(self.previous, self.speed, np.full_like(self.steps, np.inf))

    def allows(self, x: Array) -> bool:
        """Whether no coordinate of postures (n, m) changes by more than it may."""
        return bool((np.abs(np.diff(x, axis=0)) <= self.steps).all())

    def part(self, chosen: Index) -> "Movement":
        """Return what binds chosen postures, in order; those that are no neighbours are free."""
        bound = np.diff(chosen)[:, None] == 1
        steps = np.where(bound, self.steps[chosen[:-1]], np.inf)
        return Movement(self.previous * bound, self.speed, steps)

    def cost(self, x: Array) -> Array:
        """Return the cost of each step, (n - 1,)."""
        apart = np.diff(x, axis=0)
        over = np.maximum(np.abs(apart) - self.steps, 0.0)
        return 0.5 * np.sum((self.previous * apart) ** 2 + (self.speed * over) ** 2, axis=1)

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """Return gradient and curvature by the change of each coordinate, (n - 1, m) each."""
        apart = np.diff(x, axis=0)
        over = np.maximum(np.abs(apart) - self.steps, 0.0)
        gradient = self.previous**2 * apart + self.speed**2 * over * np.sign(apart)
        beyond = np.asarray(over > 0, dtype=float)
        return gradient, self.previous**2 + self.speed**2 * beyond


def fit(
    evaluate: Callable[[Array], Quadratic],
    start: Array,
    lower: Array,
    upper: Array,
    movement: Movement | None,
    most: int,
    settled: float = SETTLED,
) -> tuple[Array, Array]:
    """Return coordinates of least cost within bounds, (n, m), and the costs of postures, (n,).

    Parameters
    ----------
    evaluate
        Returns the postures' own costs and derivatives.
    start : (n, m)
    lower, upper : (m,) or (n, m)
    movement
        None: postures are independent of one another.
    most
        Largest number of steps.
    settled
        It ends when no coordinate moves by more [rad or m].
    """
    x: Array = np.clip(start, lower, upper)
    here = evaluate(x)
    damping = np.full(len(x), _DAMPING)
    for _ in range(most):
        step = _step(here, x, lower, upper, movement, damping)
        tried = np.clip(x - _shortened(step), lower, upper)
        moved = np.abs(tried - x).max(axis=1)
        there = evaluate(tried)
        before, after = _totals(here, x, movement), _totals(there, tried, movement)
        better = after <= before
        if movement is not None and after.sum() <= before.sum():
            x, here = tried, there
        else:  # each posture as it is better
            mixed, both = np.where(better[:, None], tried, x), _chosen(better, there, here)
            if movement is None or _totals(both, mixed, movement).sum() <= before.sum():
                x, here = mixed, both
        damping = np.where(better, np.maximum(damping * 0.2, 1e-9), damping * 10.0)
        still = moved < settled if movement is not None else (moved < settled) | (damping > 1e4)
        if still.all() or damping.min() > 1e6:
            break
    return x, here.cost


def _shortened(step: Array) -> Array:
    """Return steps in their own direction, none of which is too long in any coordinate."""
    longest = np.abs(step).max(axis=1, keepdims=True)
    return step * np.minimum(1.0, _LONGEST / np.maximum(longest, 1e-12))


def _totals(own: Quadratic, x: Array, movement: Movement | None) -> Array:
    """Return the cost of each posture with half of that of the steps to its neighbours, (n,)."""
    total = own.cost.copy()
    if movement is not None and len(x) > 1:
        half = movement.cost(x) / 2
        total[:-1] += half
        total[1:] += half
    return total


def _chosen(better: Mask, there: Quadratic, here: Quadratic) -> Quadratic:
    return Quadratic(
        np.where(better, there.cost, here.cost),
        np.where(better[:, None], there.gradient, here.gradient),
        np.where(better[:, None, None], there.hessian, here.hessian),
    )


def _step(
    own: Quadratic, x: Array, lower: Array, upper: Array, movement: Movement | None, damping: Array
) -> Array:
    """Return the step against the gradient, (n, m), with what is at its end held."""
    n, m = x.shape
    gradient, hessian = own.gradient.copy(), own.hessian.copy()
    bound = np.zeros((max(n - 1, 0), m))
    diagonal = np.arange(m)
    if movement is not None and n > 1:
        push, bound = movement.slopes(x)
        gradient[1:] += push
        gradient[:-1] -= push
        hessian[1:, diagonal, diagonal] += bound
        hessian[:-1, diagonal, diagonal] += bound
    size = hessian[:, diagonal, diagonal]
    level = _LEVEL * size.max(axis=1, keepdims=True)  # restrains coordinates that matter little
    hessian[:, diagonal, diagonal] = size + damping[:, None] * (size + level) + 1e-12
    held = ((x <= lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0))
    gradient[held] = 0.0
    free = ~held
    hessian *= free[:, :, None] & free[:, None, :]
    hessian[:, diagonal, diagonal] += held
    if movement is None or n == 1:
        alone = np.linalg.solve(hessian, gradient[..., None])[..., 0]
        return np.asarray(alone, dtype=float)
    off = -bound * (free[1:] & free[:-1])
    try:
        return solveh_banded(
            _banded(hessian, off), gradient.ravel(), lower=True, check_finite=False
        ).reshape(n, m)
    except LinAlgError:  # rounding in a matrix that is all but singular
        return np.asarray(gradient / size.max(axis=1, keepdims=True), dtype=float)


def _banded(blocks: Array, off: Array) -> Array:
    """Return the lower band of the matrix of blocks (n, m, m), bound joint by joint, (n - 1, m)."""
    n, m, _ = blocks.shape
    band = np.zeros((m + 1, n, m))
    for below in range(m):
        band[below, :, : m - below] = blocks[:, range(below, m), range(m - below)]
    band[m, :-1] = off
    return band.reshape(m + 1, n * m)

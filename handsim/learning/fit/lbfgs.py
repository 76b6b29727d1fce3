"""Minimisation by L-BFGS in reproducible arithmetic.

Nocedal and Wright 2006, Numerical Optimization, Algorithms 7.4 and 7.5 (two loops over the latest
steps) and 3.5 and 3.6 (a line search for the strong Wolfe conditions). Where the last bit does not
matter, scipy.optimize is the better choice: it works with BLAS.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np

from handsim.learning.fit.history import Iteration
from handsim.reproducible import dot
from handsim.types import Array

Cost = Callable[[Array], tuple[float, Array]]
"""Maps x (n,) to the cost and its gradient (n,)."""

_MEMORY = 20
_DECREASE, _CURVATURE = 1e-4, 0.9  # of the strong Wolfe conditions
_MAX_TRIALS = 20  # evaluations in one line search


@dataclass(frozen=True)
class Minimum:
    """Where the minimisation ended.

    Attributes
    ----------
    x : (n,)
    cost
    iterations
        One entry an iteration.
    """

    x: Array
    cost: float
    iterations: tuple[Iteration, ...]


class _Point(NamedTuple):
    """A point of a line search: step, x, cost, gradient, slope along the direction."""

    step: float
    x: Array
    cost: float
    gradient: Array
    slope: float


def minimise(
    cost: Cost,
    x: Array,
    n_iterations: int,
    cost_tolerance: float,
    gradient_tolerance: float,
    after_iteration: Callable[[Array], None] | None = None,
) -> Minimum:
    """Minimise a smooth function.

    Parameters
    ----------
    cost
    x : (n,)
        Where to begin.
    n_iterations
        At most.
    cost_tolerance
        End when an iteration lowers the cost by less than this fraction of it (or of 1).
    gradient_tolerance
        End when no entry of the gradient is greater.
    after_iteration
        Called with x after each iteration.
    """
    value, gradient = cost(x)
    steps: list[tuple[Array, Array, float]] = []
    log: list[Iteration] = []
    while len(log) < n_iterations and np.abs(gradient).max(initial=0.0) > gradient_tolerance:
        direction = -_times_inverse_hessian(gradient, steps)
        slope = dot(gradient, direction)
        if slope >= 0.0:  # rounding at a minimum: begin anew from the gradient
            steps, direction, slope = [], -gradient, -dot(gradient, gradient)
        first = 1.0 if steps else min(1.0, 1.0 / sqrt(dot(gradient, gradient)))
        found = _line_search(cost, _Point(0.0, x, value, gradient, slope), direction, first)
        if found is None or not found.cost < value:
            break
        s, y = found.x - x, found.gradient - gradient
        curvature = dot(s, y)
        if curvature > np.finfo(float).eps * dot(y, y):
            steps = [*steps[1 - _MEMORY :], (s, y, curvature)]
        fall = value - found.cost
        x, value, gradient = found.x, found.cost, found.gradient
        log.append(Iteration(value, sqrt(dot(gradient, gradient)), sqrt(dot(s, s))))
        if after_iteration:
            after_iteration(x)
        if fall <= cost_tolerance * max(abs(value), abs(value + fall), 1.0):
            break
    return Minimum(x, value, tuple(log))


def _times_inverse_hessian(gradient: Array, steps: list[tuple[Array, Array, float]]) -> Array:
    """Algorithm 7.4: the gradient times the inverse Hessian that the latest steps tell of."""
    q = gradient.copy()
    shares: list[float] = []
    for s, y, curvature in reversed(steps):
        shares.append(dot(s, q) / curvature)
        q -= shares[-1] * y
    if steps:
        _, y, curvature = steps[-1]
        q *= curvature / dot(y, y)
    for (s, y, curvature), share in zip(steps, reversed(shares), strict=True):
        q += (share - dot(y, q) / curvature) * s
    return q


def _line_search(cost: Cost, start: _Point, direction: Array, first: float) -> _Point | None:
    """Algorithms 3.5 and 3.6: a step for the strong Wolfe conditions, or the best one met.

    None where no step lowers the cost.
    """
    low, high = start, None  # the step lies between them; without the second, beyond the first
    step = first
    for _ in range(_MAX_TRIALS):
        x = start.x + step * direction
        value, gradient = cost(x)
        here = _Point(step, x, value, gradient, dot(gradient, direction))
        too_high = not value <= start.cost + _DECREASE * step * start.slope
        if too_high or (value >= low.cost and low.step > 0.0):
            high = here
        elif abs(here.slope) <= -_CURVATURE * start.slope:
            return here
        elif here.slope * (step - low.step) >= 0.0:
            low, high = here, low
        else:
            low = here
        step = min(4.0 * step, 1e10) if high is None else _between(low, high)
    return low if low.step > 0.0 else None


def _between(low: _Point, high: _Point) -> float:
    """Minimiser of the cubic through two points and their slopes (Eq. 3.59), kept inside."""
    width = high.step - low.step
    d1 = low.slope + high.slope - 3.0 * (high.cost - low.cost) / width
    root = d1 * d1 - low.slope * high.slope
    share = 0.5
    if 0.0 <= root < np.inf:
        d2 = sqrt(root) if width > 0.0 else -sqrt(root)
        slopes = high.slope - low.slope + 2.0 * d2
        if slopes != 0.0:
            share = 1.0 - (high.slope + d2 - d1) / slopes
    return low.step + min(max(share, 0.1), 0.9) * width

"""Products and derivatives of polynomials on boxes, in Bernstein form.

A tensor of coefficients over n trailing axes of d + 1 entries each is a polynomial of degree d in
each of n variables on a box. Leading axes count boxes and components.
"""

from functools import cache
from itertools import product
from math import comb

import numpy as np

from handsim.navigation._bernstein import Cells
from handsim.types import Array


def gradients(coefficients: Array, size: Array) -> Array:
    """Return the partial derivatives (N, n, d + 1, ...) of polynomials (N, d + 1, ...) on boxes.

    The derivative along a dimension has degree d - 1 there; it is raised to d.

    Parameters
    ----------
    coefficients
        With n trailing axes.
    size : (N, n)
        Of the boxes.
    """
    n, degree = size.shape[1], coefficients.shape[-1] - 1
    rising = np.arange(1, degree + 1) / degree
    parts: list[Array] = []
    for i in range(n):
        c = np.moveaxis(coefficients, i + 1, -1)
        slope = degree * np.diff(c, axis=-1) / size[:, i].reshape(-1, *(1,) * n)
        raised = np.zeros_like(c)
        raised[..., 1:] += slope * rising
        raised[..., :-1] += slope * rising[::-1]
        parts.append(np.moveaxis(raised, -1, i + 1))
    return np.stack(parts, axis=1)


def linear(cells: Cells, matrix: Array, goal: Array, degree: int) -> Array:
    """Return matrix (z - goal) on cells as polynomials (N, rows, degree + 1, ...)."""
    n = len(goal)
    result = np.zeros((len(cells.origin), len(matrix), *(degree + 1,) * n))
    for i in range(n):
        along = _along(cells, goal, i, np.arange(degree + 1) / degree)
        rows = matrix[:, i].reshape(1, -1, *(1,) * n)
        result += rows * along.reshape(-1, 1, *_only(i, n, degree + 1))
    return result


def quadratic(cells: Cells, matrix: Array, goal: Array) -> Array:
    """Return (z - goal)' matrix (z - goal) on cells as polynomials (N, 1, 3, ..., 3)."""
    n = len(goal)
    half = np.array([0.0, 0.5, 1.0])
    result = np.zeros((len(cells.origin), *(3,) * n))
    for i, j in product(range(n), repeat=2):
        a = _along(cells, goal, i, half)
        if i == j:
            square = np.stack([a[:, 0] * a[:, 0], a[:, 0] * a[:, 2], a[:, 2] * a[:, 2]], axis=1)
            result += matrix[i, i] * square.reshape(-1, *_only(i, n, 3))
        else:
            b = _along(cells, goal, j, half).reshape(-1, *_only(j, n, 3))
            result += matrix[i, j] * a.reshape(-1, *_only(i, n, 3)) * b
    return result[:, None]


def times(a: Array, b: Array, n: int) -> Array:
    """Return products of polynomials in n variables; leading axes are broadcast.

    Their degrees add up. The second should be the lower one: it is looped over.
    """
    p, q = a.shape[-1] - 1, b.shape[-1] - 1
    weights = _product_weights(p, q)
    leading = np.broadcast_shapes(a.shape[:-n], b.shape[:-n])
    result = np.zeros((*leading, *(p + q + 1,) * n))
    for place in product(range(q + 1), repeat=n):
        weight = np.ones((1,) * n)
        for axis, j in enumerate(place):
            weight = weight * weights[j].reshape(_only(axis, n, p + 1))
        part = (..., *(slice(j, j + p + 1) for j in place))
        factor = b[(..., *place)]
        result[part] += (a * weight) * factor.reshape(*factor.shape, *(1,) * n)
    return result


@cache
def _product_weights(p: int, q: int) -> Array:
    """B_i^p B_j^q = C(p, i) C(q, j) / C(p + q, i + j) B_(i + j)^(p + q), as (q + 1, p + 1)."""
    columns = range(p + 1)
    return np.array(
        [[comb(p, i) * comb(q, j) / comb(p + q, i + j) for i in columns] for j in range(q + 1)]
    )


def _along(cells: Cells, goal: Array, i: int, fractions: Array) -> Array:
    """Return z_i - goal_i at fractions of the cells, (N, fractions)."""
    return (cells.origin[:, i] - goal[i])[:, None] + cells.size[:, i, None] * fractions


def _only(axis: int, n: int, length: int) -> tuple[int, ...]:
    """Shape of an array that varies along one of n axes."""
    return tuple(length if i == axis else 1 for i in range(n))

"""Gaussian-process regression of many outputs at once, in reproducible arithmetic."""

import numpy as np

from handsim.reproducible import lower_solved, total, upper_solved
from handsim.types import Array


def cholesky(matrix: Array) -> Array:
    """Return the lower triangular L (n, n) with L L' = a positive definite matrix (n, n)."""
    rest = np.array(matrix, dtype=float)
    for i in range(len(rest)):
        rest[i:, i] /= np.sqrt(rest[i, i])
        column = rest[i + 1 :, i]
        rest[i + 1 :, i + 1 :] -= column[:, None] * column
    return np.tril(rest)


def regression_weights(kernel: Array, noise: float, values: Array) -> Array:
    """Return (K + noise I)^-1 y: with the kernel of a query (n,), the mean is its sum over them.

    Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, Algorithm 2.1.

    Parameters
    ----------
    kernel : (n, n)
    noise
        Variance added to the diagonal, relative to the kernel's.
    values : (n, m)
    """
    lower = cholesky(kernel + noise * np.eye(len(kernel)))
    return upper_solved(lower.T, lower_solved(lower, values))


def predicted(shares: Array, weights: Array) -> Array:
    """Return the mean (m,) at a query from its kernel (n,) and `regression_weights` (n, m)."""
    return total(shares[:, None] * weights)


def shifted_products(a: Array, b: Array, middle: Array, scale: float) -> Array:
    """Return the linear kernel (N, m) of points a (N, n) and b (m, n) about a middle (n,)."""
    left, right = (a - middle) / scale, (b - middle) / scale
    return total(left[:, None] * right[None], -1)


def left_out_means(kernel: Array, noise: float, values: Array) -> Array:
    """Return what is predicted of each of the values (n, m) from all others, as if it was left out.

    In closed form, with one factorisation for all (Rasmussen and Williams 2006, Eq. 5.12).
    Arguments as in `regression_weights`.
    """
    lower = cholesky(kernel + noise * np.eye(len(kernel)))
    inverse = lower_solved(lower, np.eye(len(kernel)))  # of the factor
    weights = upper_solved(lower.T, lower_solved(lower, values))
    return values - weights / total(inverse * inverse)[:, None]

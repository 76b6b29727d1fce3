"""Arithmetic that gives the same bits on every processor.

A fit of hundreds of iterations magnifies one unit in the last place to hundredths of
a coefficient. What BLAS and LAPACK return in that place depends on the kernel they choose for the
processor and on the number of threads; exp and log depend on the instructions that the mathematics
library finds. IEEE 754 fixes the result of a single addition, product, quotient or square root, so
the functions here, and learning with them, are made of those alone, array by array in an order
that is written down.
"""

from collections.abc import Callable, Sequence
from math import factorial
from operator import add
from typing import Any, TypeVar

import numpy as np

from handsim.types import Array

_PER_LN2 = 1.4426950408889634
_LN2_HIGH = 0.693147180369123816490  # its last 20 bits are 0: products with exponents are exact
_LN2_LOW = 1.90821492927058770002e-10
# |r| <= ln(2) / 2 and |s| <= 0.172: what comes next is below 1e-17.
_EXP_COEFFICIENTS = [1.0 / factorial(power) for power in range(14)]
_LOG_COEFFICIENTS = [1.0 / (2 * term + 1) for term in range(12)]
_EXP_RANGE = (-745.0, 709.0)
_FEW = 16
_Part = TypeVar("_Part", float, Array)
_add: Callable[[Any, Any], Any] = add


def total(x: Array, axis: int = 0) -> Array:
    """Return the sum along an axis, by adding halves; rounding errors grow with log2(n)."""
    parts = x
    if axis != 0:  # np.moveaxis, which takes longer than the sum of a few numbers
        axis %= x.ndim
        parts = x.transpose(axis, *range(axis), *range(axis + 1, x.ndim))
    if not len(parts):
        return np.zeros(parts.shape[1:])
    while len(parts) > 1:
        half = len(parts) // 2
        folded = parts[:half] + parts[half : 2 * half]
        if len(parts) % 2:
            folded[0] += parts[-1]
        parts = folded
    return parts[0]


def total_of(parts: Sequence[_Part]) -> _Part | float:
    """Return the same sum as `total` of a few numbers, or of arrays of one shape; for loops."""
    while len(parts) > 1:
        half = len(parts) // 2
        folded: list[Any] = list(map(_add, parts[:half], parts[half : 2 * half]))
        if len(parts) % 2:
            folded[0] += parts[-1]
        parts = folded
    return parts[0] if parts else 0.0


def totals_of(rows: Sequence[float], width: int) -> Sequence[float]:
    """Return the sums (width,) of rows (n * width,) that follow each other, as `total`; for loops.

    ``n`` is at least 1. Several sums at once take less time than one after the other.
    """
    n = len(rows) // width
    while n > 1:
        n, odd = divmod(n, 2)
        end = n * width
        folded: list[float] = list(map(_add, rows[:end], rows[end : 2 * end]))
        if odd:
            folded[:width] = map(_add, folded, rows[2 * end :])
        rows = folded
    return rows


def mean(x: Array, axis: int = 0) -> Array:
    """Return the mean along an axis."""
    return total(x, axis) / x.shape[axis]


def dot(a: Array, b: Array) -> float:
    """Return the scalar product of two vectors (n,), added as `total` adds."""
    parts = a * b
    n = len(parts)
    while n > _FEW:
        half = n // 2
        folded = parts[:half]
        folded += parts[half : 2 * half]
        if n % 2:
            folded[0] += parts[n - 1]
        parts, n = folded, half
    rest: list[float] = parts.tolist()  # of few numbers, floats are faster than arrays
    return total_of(rest)


def dots(a: Array, b: Array) -> Array:
    """Return the scalar products (...,) of vectors (..., n)."""
    return total(a * b, -1)


def norms(x: Array) -> Array:
    """Return the lengths (..., 1) of vectors (..., n)."""
    return np.sqrt(dots(x, x))[..., None]


def units(x: Array) -> Array:
    """Return vectors (..., n) at length 1; those of length 0 stay."""
    length = norms(x)
    return x / np.where(length > 0.0, length, 1.0)


def spread(points: Array) -> float:
    """Return the root of the mean squared distance of points (N, n) from their mean."""
    away = points - mean(points)
    return float(np.sqrt(mean(dots(away, away))))


def product(a: Array, b: Array) -> Array:
    """Return matrix products (..., i, k) of (..., i, j) and (..., j, k), both small."""
    result = a[..., :, :1] * b[..., :1, :]
    for j in range(1, b.shape[-2]):
        result = result + a[..., :, j : j + 1] * b[..., j : j + 1, :]
    return result


def exact_product(weights: Array, values: Array) -> Array:
    """Return the matrix product (i, k) of weights (i, j) and values (j, k), both rounded first.

    Weights are rounded to 2^-16 and values to 2^-22 of the greatest among each. With up to 30 000
    rows all products and sums are then integers below 2^53 times one power of two: exact, and so
    the same in whatever order BLAS adds them.
    """
    a, b = _quantised(weights, 16), _quantised(values, 22)
    return a @ b


def _quantised(x: Array, bits: int) -> Array:
    """Round numbers to multiples of 2^-bits of the power of two above the greatest."""
    exponent = int(np.frexp(np.abs(x).max(initial=0.0))[1]) - bits
    return np.ldexp(np.rint(np.ldexp(x, -exponent)), exponent)


def exp(x: Array) -> Array:
    """Return exp(x) within 2 units in the last place, from 0 below -745 to 8e307 above 709.

    x = n ln 2 + r with a Taylor polynomial in r.
    """
    x = np.minimum(np.maximum(x, _EXP_RANGE[0]), _EXP_RANGE[1])
    n = np.rint(x * _PER_LN2)
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    return np.ldexp(_polynomial(_EXP_COEFFICIENTS, r), n.astype(np.int32))


def log(x: Array) -> Array:
    """Return ln(x) of positive normal numbers within 2 units in the last place.

    x = 2^n m with m between the roots of 1/2 and 2; ln m = 2 artanh((m - 1) / (m + 1)).
    """
    m, n = np.frexp(x)
    small = m < np.sqrt(0.5)
    m = np.where(small, 2.0 * m, m)
    n = n - small
    s = (m - 1.0) / (m + 1.0)
    square = s * s
    value = _polynomial(_LOG_COEFFICIENTS, square)
    return n * _LN2_HIGH + (n * _LN2_LOW + 2.0 * s * value)


def _polynomial(coefficients: list[float], x: Array) -> Array:
    """Return sum_i coefficients[i] x^i by Horner's rule."""
    value = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value *= x
        value += coefficient
    return value


def powers(x: Array, exponent: float) -> Array:
    """Return x**exponent of numbers that are positive or 0, exponent > 0."""
    positive = np.maximum(x, np.finfo(float).tiny)
    return np.where(x > 0.0, exp(exponent * log(positive)), 0.0)


def lower_solved(lower: Array, b: Array) -> Array:
    """Return L^-1 b for a lower triangular matrix (m, m) and right sides (m, n)."""
    x = np.array(b, dtype=float)
    for i in range(len(x)):
        x[i] = (x[i] - total(lower[i, :i, None] * x[:i])) / lower[i, i]
    return x


def upper_solved(upper: Array, b: Array) -> Array:
    """Return U^-1 b for an upper triangular matrix (m, m) and right sides (m, n)."""
    return lower_solved(upper[::-1, ::-1], b[::-1])[::-1]

"""The box in which a navigation function is learned, and the knots laid on it.

Sec. V-A.2 of the paper: the boundary lies more than one knot beyond the recordings. Sec. V-A.3:
more knots where the recordings vary more.
"""

from math import prod
from typing import Literal

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.learning.bspline import TensorBasis

Array = npt.NDArray[np.float64]
KnotRule = Literal["variance", "deviation", "gentle", "equal"]

# Coefficients by number of dimensions: what a fit of seconds can carry.
_BUDGET = {1: 20, 2: 200, 3: 1700, 4: 4000, 5: 8000}
_EXTENSION = 1.5  # cells between the recordings and the boundary
_CLOSING = 0.75  # thickness of the closing layer, in cells: the recordings stay clear of it


def knot_counts(variance: Array, degree: int = 3, rule: KnotRule = "gentle") -> tuple[int, ...]:
    """Share coefficients among dimensions by what varies in them.

    Parameters
    ----------
    variance : (n,)
        Variance of the recordings along each dimension.
    degree
        Polynomial degree of the spline.
    rule
        ``variance`` allocates knots in proportion to the variance, as the paper; ``deviation`` in
        proportion to its square root; ``gentle`` to its fourth root; ``equal`` the same number to
        all. On four people's recordings the gentle rule reproduces best, the paper's worst
        (tests/benchmarks/README.md).

    Returns
    -------
    tuple of n int
        Coefficients per dimension, at least ``degree + 4`` and as many as the budget for their
        product allows.
    """
    exponent = {"variance": 1.0, "deviation": 0.5, "gentle": 0.25, "equal": 0.0}[rule]
    share = (variance / variance.max()) ** exponent
    least, budget = degree + 4, _BUDGET[len(variance)]
    best = (least,) * len(variance)
    for cells in range(4, 60):
        counts = tuple(max(least, round(degree + cells * float(s))) for s in share)
        if prod(counts) > budget:
            break
        best = counts
    return best


def lay_basis(
    paths: list[Array],
    shape: tuple[int, ...] | None = None,
    degree: int = 3,
    rule: KnotRule = "gentle",
) -> tuple[TensorBasis, Array]:
    """Lay uniform knots on a box that reaches 1.5 cells beyond the recordings.

    Parameters
    ----------
    paths
        Recorded paths (n_i, n) in the subspace [rad].
    shape
        Coefficients per dimension; by `knot_counts` where left out.

    Returns
    -------
    basis
    width : (n,) [rad]
        Thickness of the layer in which beta_0 falls to zero, 0.75 cells: clear of all recordings.

    Raises
    ------
    InputError
        If the recordings do not vary along a dimension, or the shape does not fit.
    """
    points = np.vstack(paths)
    low, high = points.min(axis=0), points.max(axis=0)
    flat = np.flatnonzero(high - low < 1e-6)
    if flat.size:
        raise InputError(
            f"the recordings do not move along component {int(flat[0]) + 1}; "
            "learn fewer components or record more movements"
        )
    counts = shape or knot_counts(points.var(axis=0), degree, rule)
    if len(counts) != points.shape[1] or min(counts) < degree + 4:
        raise InputError(
            f"{counts} coefficients for {points.shape[1]} dimensions; give one number each, "
            f"at least {degree + 4}"
        )
    cell = (high - low) / (np.array(counts) - degree - 2 * _EXTENSION)
    reach = _EXTENSION * cell
    return TensorBasis.uniform(low - reach, high + reach, counts, degree), _CLOSING * cell

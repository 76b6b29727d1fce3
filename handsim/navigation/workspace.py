"""The box in which a navigation function is learned, and the knots laid on it.

Sec. V-A.2 of the paper: the boundary lies more than one knot beyond the recordings, so that beta
there can be kept at 0, Eq. (5), whatever the recordings ask of it. Sec. V-A.3: more knots along
the dimensions in which the recordings vary more.
"""

from bisect import bisect_right
from math import prod
from typing import Literal

import numpy as np

from handsim.errors import InputError
from handsim.navigation.bspline import TensorBasis
from handsim.types import Array

KnotRule = Literal["variance", "deviation", "gentle", "equal"]

# Coefficients by number of dimensions, so many that a fit takes seconds.
_BUDGET = {1: 20, 2: 200, 3: 1700, 4: 4000, 5: 8000}
_FEWEST = 4  # cells along the dimension that varies most
_CLOSING = 0.3  # thickness of the closing layer, in cells: the recordings stay clear of it


def knot_counts(
    variance: Array,
    degree: int = 3,
    rule: KnotRule = "gentle",
    budget: int | None = None,
    least: int | None = None,
) -> tuple[int, ...]:
    """Share coefficients among dimensions by the variance along each (Sec. V-A.3 of the paper).

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
    budget
        Greatest product; by default so many that a fit takes seconds.
    least
        Coefficients that each dimension has at least; ``degree + 4`` where left out.

    Returns
    -------
    tuple of n int
        Coefficients per dimension, as many as the budget allows; ``least`` goes before it.
    """
    exponent = {"variance": 1.0, "deviation": 0.5, "gentle": 0.25, "equal": 0.0}[rule]
    share = (variance / variance.max()) ** exponent
    floor, most = least or degree + 4, budget or _BUDGET[len(variance)]

    def counts(cells: int) -> tuple[int, ...]:
        return tuple(max(floor, round(degree + cells * float(s))) for s in share)

    # The widest dimension alone has more coefficients than cells, so that they end the search.
    n_within = bisect_right(range(_FEWEST, most + 1), most, key=lambda cells: prod(counts(cells)))
    return counts(_FEWEST + n_within - 1) if n_within else (floor,) * len(variance)


def lay_basis(
    paths: list[Array],
    shape: tuple[int, ...] | None = None,
    degree: int = 3,
    rule: KnotRule = "gentle",
    budget: int | None = None,
    reach: float = 1.2,
) -> tuple[TensorBasis, Array]:
    """Lay uniform knots on a box that reaches beyond the recordings.

    Parameters
    ----------
    paths
        Recorded paths (n_i, n) in the subspace [rad].
    shape
        Coefficients per dimension; by `knot_counts` where left out.
    degree, rule, budget
        As in `knot_counts`.
    reach
        Cells between the recordings and the boundary, more than the paper's one.

    Returns
    -------
    basis
    width : (n,) [rad]
        Thickness of the layer in which beta_0 falls to zero, 0.3 cells: clear of all recordings.

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
    least = degree + int(2 * reach) + 1
    counts = shape or knot_counts(points.var(axis=0), degree, rule, budget, least)
    if len(counts) != points.shape[1] or min(counts) < least:
        raise InputError(
            f"{counts} coefficients for {points.shape[1]} dimensions; give one number each, "
            f"at least {least}"
        )
    cell = (high - low) / (np.array(counts) - degree - 2 * reach)
    beyond = reach * cell
    return TensorBasis.uniform(low - beyond, high + beyond, counts, degree), _CLOSING * cell

"""What an archive holds of a navigation function, of a hand or of a palm."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, SplineObstacle

MAX_VALUE = 1e6
"""Bound on every number: angles [rad], variances [rad^2], coefficients of ln(beta) / k or beta."""
MIN_WIDTH = 1e-6
"""Least distance of unequal knots and least thickness of the closing layer [rad]."""
MAX_LOG_METRIC = 100.0
"""Bound on the logarithm of a metric's entries: their exponentials stay far from overflow."""
ACCURACY = 1e-6

Arrays = Mapping[str, npt.NDArray[Any]]


def content_of_navigation(
    navigation: NavigationFunction,
) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Return the metadata and the arrays of a navigation function.

    Raises
    ------
    InputError
        If its obstacle is of a kind that cannot be written.
    """
    obstacle = navigation.obstacle
    arrays: dict[str, npt.NDArray[Any]] = {}
    if isinstance(obstacle, ExponentialObstacle):
        spline, arrays["closing_width"] = obstacle.chi, obstacle.width
    elif isinstance(obstacle, SplineObstacle):
        spline = obstacle.beta
    else:
        raise InputError(f"an obstacle of type {type(obstacle).__name__} cannot be saved")
    arrays |= {f"knots_{i}": knots for i, knots in enumerate(spline.basis.knots)}
    arrays["coefficients"] = spline.coefficients
    metadata: dict[str, Any] = {
        "obstacle": "exponential" if "closing_width" in arrays else "spline",
        "degree": spline.basis.degree,
        "k": navigation.k,
    }
    if navigation.metric:
        metadata["metric_reach"] = navigation.metric.reach
        arrays["metric_centres"] = navigation.metric.centres
        arrays["metric_logs"] = navigation.metric.logs
    return metadata, arrays


def navigation_of(n: int, metadata: Mapping[str, Any], arrays: Arrays) -> NavigationFunction:
    """Restore a navigation function of ``n`` coordinates from what `check_navigation` passed."""
    basis = TensorBasis(tuple(arrays[f"knots_{i}"] for i in range(n)), int(metadata["degree"]))
    spline = TensorBSpline(basis, arrays["coefficients"])
    if metadata["obstacle"] == "exponential":
        obstacle = ExponentialObstacle(spline, arrays["closing_width"])
    else:
        obstacle = SplineObstacle(spline)
    metric = None
    if "metric_reach" in metadata:
        reach = float(metadata["metric_reach"])
        metric = DestinationMetric(arrays["metric_centres"], arrays["metric_logs"], reach)
    return NavigationFunction(obstacle, float(metadata["k"]), metric)


def check_numbers(arrays: Arrays) -> None:
    """Raise ValueError unless all arrays hold numbers of possible size."""
    for name, array in arrays.items():
        if array.dtype != np.float64 or not (np.abs(array) <= MAX_VALUE).all():
            raise ValueError(f"{name} holds what is no number up to {MAX_VALUE:g}")


def check_navigation(n: int, metadata: Mapping[str, Any], arrays: Arrays) -> None:
    """Check what is said of a navigation function of ``n`` coordinates.

    Raises
    ------
    KeyError, TypeError, ValueError
        If something is missing, of another type or shape, or no possible number.
    """
    _check_spline(n, metadata, arrays)
    if "metric_reach" in metadata:
        _check_metric(n, metadata["metric_reach"], arrays)


def check_shape(name: str, arrays: Arrays, *shape: int) -> None:
    """Raise ValueError if an array has another shape."""
    if arrays[name].shape != shape:
        raise ValueError(f"{name} of shape {arrays[name].shape} instead of {shape}")


def _check_spline(n: int, metadata: Mapping[str, Any], arrays: Arrays) -> None:
    degree = metadata["degree"]
    if not isinstance(degree, int) or not 1 <= degree <= 9:
        raise ValueError(f"degree {degree!r} is not among 1 to 9")
    if metadata["obstacle"] not in ("exponential", "spline"):
        raise ValueError(f"obstacle {metadata['obstacle']!r} is not known")
    if metadata["obstacle"] == "exponential":
        check_shape("closing_width", arrays, n)
        if (arrays["closing_width"] < MIN_WIDTH).any():
            raise ValueError("closing_width is not positive")
    for i in range(n):
        steps = np.diff(arrays[f"knots_{i}"])
        if not ((steps == 0) | (steps >= MIN_WIDTH)).all():
            raise ValueError(f"knots_{i} do not increase by {MIN_WIDTH:g} rad")


def _check_metric(n: int, reach: Any, arrays: Arrays) -> None:
    if not isinstance(reach, float) or not MIN_WIDTH <= reach <= MAX_VALUE:
        raise ValueError(f"metric_reach {reach!r} is not a distance")
    logs = arrays["metric_logs"]
    check_shape("metric_logs", arrays, 1 + len(arrays["metric_centres"]), n, n)
    check_shape("metric_centres", arrays, len(logs) - 1, n)
    if np.abs(logs - np.swapaxes(logs, 1, 2)).max() > ACCURACY:
        raise ValueError("metric_logs are not symmetric")
    # Kernels are at most 1, so this bounds the logarithm of every metric.
    if np.abs(logs).sum(axis=0).max() > MAX_LOG_METRIC:
        raise ValueError(f"metric_logs add up to more than {MAX_LOG_METRIC:g}")

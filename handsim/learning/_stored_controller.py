"""What an archive must hold to be a controller, and what is restored of it.

An archive holds finite numbers that belong together; `check_content` refuses all others.
"""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from handsim.joints import N_JOINTS
from handsim.learning.base import plain
from handsim.learning.demonstration import Demonstration
from handsim.learning.options import check_options, is_foreign
from handsim.learning.timing import check_duration

MAX_VALUE = 1e6
"""Bound on every number: angles [rad], variances [rad^2], coefficients of ln(beta) / k or beta."""
MIN_WIDTH = 1e-6
"""Least distance of unequal knots and least thickness of the closing layer [rad]."""
MAX_LOG_METRIC = 100.0
"""Bound on the logarithm of a metric's entries: their exponentials stay far from overflow."""
_ACCURACY = 1e-6

Arrays = Mapping[str, npt.NDArray[Any]]


def check_content(metadata: Mapping[str, Any], arrays: Arrays) -> None:
    """Check what was stored before anything is built of it.

    Raises
    ------
    KeyError, TypeError, ValueError
        If something is missing, of another type or shape, or no possible number.
    """
    for name, array in arrays.items():
        if array.dtype != np.float64 or not (np.abs(array) <= MAX_VALUE).all():
            raise ValueError(f"{name} holds what is no number up to {MAX_VALUE:g}")
    n = len(arrays["subspace_components"])
    _check_subspace(n, arrays)
    _check_spline(n, metadata, arrays)
    if "metric_reach" in metadata:
        _check_metric(n, metadata["metric_reach"], arrays)
    _check_demonstrations(n, metadata["demonstrations"], arrays)


def stored_demonstrations(metadata: Mapping[str, Any], arrays: Arrays) -> tuple[Demonstration, ...]:
    """Restore demonstrations from the metadata and arrays of a controller's file."""
    vectors = ("q_start", "q_goal", "z_start", "z_goal")
    return tuple(
        Demonstration(**record, **{name: arrays[name][i] for name in vectors})
        for i, record in enumerate(metadata["demonstrations"])
    )


def stored_options(metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of the learner, as far as the schema of the file holds them.

    Those of a learner of another package are not checked: only that package knows them.

    Raises
    ------
    UnknownNameError, InputError
        As `check_options`.
    """
    method, options = metadata["method"], dict(metadata.get("options", {}))
    if is_foreign(method):
        return plain(options)
    kept: dict[str, Any] = {"k": float(metadata["k"])}
    if method == "direction":
        kept["certified"] = bool(metadata["certified"])
        if metadata["schema"] == 1:
            kept |= {"metric_ridge": None, "averaging": 0.0}
    return check_options(method, kept | options)


def _check_shape(name: str, arrays: Arrays, *shape: int) -> None:
    if arrays[name].shape != shape:
        raise ValueError(f"{name} of shape {arrays[name].shape} instead of {shape}")


def _check_subspace(n: int, arrays: Arrays) -> None:
    components = arrays["subspace_components"]
    _check_shape("subspace_components", arrays, n, N_JOINTS)
    _check_shape("subspace_mean", arrays, N_JOINTS)
    for name in ("subspace_explained_variance", "subspace_explained_variance_ratio"):
        _check_shape(name, arrays, n)
        if (arrays[name] < 0).any():
            raise ValueError(f"{name} is negative")
    if np.abs(components @ components.T - np.eye(n)).max(initial=0.0) > _ACCURACY:
        raise ValueError("subspace_components are not orthonormal")


def _check_spline(n: int, metadata: Mapping[str, Any], arrays: Arrays) -> None:
    degree = metadata["degree"]
    if not isinstance(degree, int) or not 1 <= degree <= 9:
        raise ValueError(f"degree {degree!r} is not among 1 to 9")
    if metadata["obstacle"] not in ("exponential", "spline"):
        raise ValueError(f"obstacle {metadata['obstacle']!r} is not known")
    if metadata["obstacle"] == "exponential":
        _check_shape("closing_width", arrays, n)
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
    _check_shape("metric_logs", arrays, 1 + len(arrays["metric_centres"]), n, n)
    _check_shape("metric_centres", arrays, len(logs) - 1, n)
    if np.abs(logs - np.swapaxes(logs, 1, 2)).max() > _ACCURACY:
        raise ValueError("metric_logs are not symmetric")
    # Kernels are at most 1, so this bounds the logarithm of every metric.
    if np.abs(logs).sum(axis=0).max() > MAX_LOG_METRIC:
        raise ValueError(f"metric_logs add up to more than {MAX_LOG_METRIC:g}")


def _check_demonstrations(n: int, records: Any, arrays: Arrays) -> None:
    if not isinstance(records, list) or not records:
        raise ValueError("no demonstrations")
    rows = cast(list[Any], records)
    for name, length in (
        ("q_start", N_JOINTS), ("q_goal", N_JOINTS), ("z_start", n), ("z_goal", n)
    ):  # fmt: skip
        _check_shape(name, arrays, len(rows), length)
    mean, components = arrays["subspace_mean"], arrays["subspace_components"]
    for end in ("start", "goal"):
        z = (arrays[f"q_{end}"] - mean) @ components.T
        if np.abs(z - arrays[f"z_{end}"]).max() > _ACCURACY:
            raise ValueError(f"z_{end} are not the projections of q_{end}")
    for record in rows:
        for name in ("name", "task", "object"):
            if not isinstance(record[name], str):
                raise TypeError(f"{name} {record[name]!r} is not text")
        for name in ("hand_length", "hand_breadth"):
            if not 0 < record[name] < 1:
                raise ValueError(f"{name} {record[name]!r} is not in metres")
        check_duration(record["duration"])

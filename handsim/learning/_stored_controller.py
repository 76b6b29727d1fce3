"""What an archive holds of a controller, and what is restored of it.

An archive holds finite numbers that belong together; `restored` refuses all others.
"""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.learning.base import plain
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.learning.guide.choice import LeftOut
from handsim.learning.guide.predictor import GuideSettings
from handsim.learning.movement.progress import N_PROGRESS, check_duration
from handsim.learning.options import check_options, is_foreign
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.metric import DestinationMetric
from handsim.navigation.obstacle import ExponentialObstacle, SplineObstacle
from handsim.navigation.paths import N_COMPARED

if TYPE_CHECKING:
    from handsim.learning.controller import GraspController

MAX_VALUE = 1e6
"""Bound on every number: angles [rad], variances [rad^2], coefficients of ln(beta) / k or beta."""
MIN_WIDTH = 1e-6
"""Least distance of unequal knots and least thickness of the closing layer [rad]."""
MAX_LOG_METRIC = 100.0
"""Bound on the logarithm of a metric's entries: their exponentials stay far from overflow."""
_ACCURACY = 1e-6
_VECTORS = ("q_start", "q_goal", "z_start", "z_goal")
_CURVES = ("path", "progress")  # of each recording; files of schema 3 and less hold none

Arrays = Mapping[str, npt.NDArray[Any]]


def content_of(controller: "GraspController") -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Return the metadata and the arrays of a controller's file.

    Raises
    ------
    InputError
        If its obstacle is of a kind that cannot be written.
    """
    obstacle = controller.navigation.obstacle
    exponential = isinstance(obstacle, ExponentialObstacle)
    if exponential:
        spline = obstacle.chi
    elif isinstance(obstacle, SplineObstacle):
        spline = obstacle.beta
    else:
        raise InputError(f"an obstacle of type {type(obstacle).__name__} cannot be saved")
    records = [_record(d) for d in controller.demonstrations]
    arrays = controller.subspace.to_arrays()
    kept = _VECTORS if any(r["path"] is None for r in records) else _VECTORS + _CURVES
    arrays.update({name: np.array([record[name] for record in records]) for name in kept})
    for record in records:
        for name in _VECTORS + _CURVES:
            del record[name]
    signals = [(i, *each) for i, r in enumerate(records) for each in r.pop("signals").items()]
    arrays.update({f"knots_{i}": knots for i, knots in enumerate(spline.basis.knots)})
    arrays["coefficients"] = spline.coefficients
    arrays["ranges"] = controller.ranges
    if exponential:
        arrays["closing_width"] = obstacle.width
    metadata: dict[str, Any] = {
        "obstacle": "exponential" if exponential else "spline",
        "degree": spline.basis.degree,
        "k": controller.navigation.k,
        "method": controller.method,
        "certified": controller.certified,
        "options": dict(controller.options),
        "demonstrations": records,
    }
    if signals:
        metadata["signals"] = [[i, name] for i, name, _ in signals]
        arrays["signals"] = np.array([values for _, _, values in signals])
    if controller.accepted:
        metadata["accepted"] = list(controller.accepted)
    if controller.guide:
        metadata["guide"] = asdict(controller.guide)
        if controller.guide.progress:  # what files without a word of it mean
            del metadata["guide"]["progress"]
    if controller.left_out:
        metadata["left_out"] = asdict(controller.left_out)
    metric = controller.navigation.metric
    if metric:
        metadata["metric_reach"] = metric.reach
        arrays |= {"metric_centres": metric.centres, "metric_logs": metric.logs}
    return metadata, arrays


def _record(demonstration: Demonstration) -> dict[str, Any]:
    record = {**vars(demonstration)}
    record["numbers"] = dict(demonstration.numbers)
    return record


def restored(metadata: Mapping[str, Any], arrays: Arrays) -> dict[str, Any]:
    """Return the fields of a controller from the content of its file.

    Raises
    ------
    KeyError, TypeError, ValueError, IndexError, InputError, UnknownNameError
        If something is missing, of another type or shape, or no possible number.
    """
    check_content(metadata, arrays)
    return {
        "subspace": PostureSubspace.from_arrays(arrays),
        "navigation": _navigation_of(metadata, arrays),
        "demonstrations": stored_demonstrations(metadata, arrays),
        "method": metadata["method"],
        "certified": bool(metadata["certified"]),
        "options": stored_options(metadata),
        "accepted": tuple(map(str, metadata.get("accepted", ()))),
        "guide": _guide_of(metadata),
        "left_out": _left_out_of(metadata),
        "ranges": arrays.get("ranges", np.array([LOWER, UPPER])),
    }


def _guide_of(metadata: Mapping[str, Any]) -> GuideSettings | None:
    if "guide" not in metadata:
        return None
    settings = GuideSettings(**metadata["guide"])
    for name, value in vars(settings).items():
        if name == "progress":
            if not isinstance(value, bool):
                raise TypeError(f"guide {name} = {value!r} is not true or false")
        elif not isinstance(value, float) or not 0.0 < value <= MAX_VALUE:
            raise ValueError(f"guide {name} = {value!r} is not a positive number")
    return settings


def _left_out_of(metadata: Mapping[str, Any]) -> LeftOut | None:
    if "left_out" not in metadata:
        return None
    left_out = LeftOut(**metadata["left_out"])
    for name, value in vars(left_out).items():
        if not isinstance(value, float) or not 0.0 <= value <= MAX_VALUE:
            raise ValueError(f"left_out {name} = {value!r} is not a ratio")
    return left_out


def _navigation_of(metadata: Mapping[str, Any], arrays: Arrays) -> NavigationFunction:
    n = len(arrays["subspace_components"])
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
    if not isinstance(metadata["method"], str):
        raise TypeError(f"method {metadata['method']!r} is not text")
    n = len(arrays["subspace_components"])
    _check_subspace(n, arrays)
    _check_spline(n, metadata, arrays)
    if "metric_reach" in metadata:
        _check_metric(n, metadata["metric_reach"], arrays)
    _check_demonstrations(n, metadata["demonstrations"], arrays)
    _check_curves(n, metadata, arrays)
    _check_signals(metadata, arrays)
    if "ranges" in arrays:
        _check_shape("ranges", arrays, 2, N_JOINTS)
        if not (arrays["ranges"][0] < arrays["ranges"][1]).all():
            raise ValueError("ranges are empty")


def stored_demonstrations(metadata: Mapping[str, Any], arrays: Arrays) -> tuple[Demonstration, ...]:
    """Restore demonstrations from the metadata and arrays of a controller's file."""
    held = [name for name in _VECTORS + _CURVES if name in arrays]
    signals: list[dict[str, Any]] = [{} for _ in metadata["demonstrations"]]
    for row, (i, name) in enumerate(metadata.get("signals", [])):
        signals[i][name] = arrays["signals"][row]
    return tuple(
        Demonstration(**record, **{name: arrays[name][i] for name in held}, signals=signals[i])
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
        numbers = record.get("numbers", {})
        if not all(
            isinstance(value, float) and abs(value) <= MAX_VALUE for value in numbers.values()
        ):
            raise ValueError(f"numbers {numbers!r} of an object are no numbers")


def _check_curves(n: int, metadata: Mapping[str, Any], arrays: Arrays) -> None:
    """Paths and progress come together, and a guide needs them."""
    if not any(name in arrays for name in _CURVES):
        if "guide" in metadata:
            raise ValueError("a guide without paths")
        return
    count = len(metadata["demonstrations"])
    _check_shape("path", arrays, count, N_COMPARED, n)
    _check_shape("progress", arrays, count, N_PROGRESS)
    ends = arrays["path"][:, [0, -1]]
    if np.abs(ends - np.stack([arrays["z_start"], arrays["z_goal"]], axis=1)).max() > _ACCURACY:
        raise ValueError("paths do not run from z_start to z_goal")
    progress = arrays["progress"]
    ends = np.abs(progress[:, [0, -1]] - [0.0, 1.0]).max(initial=0.0)
    if (np.diff(progress) < 0).any() or ends > _ACCURACY:
        raise ValueError("progress does not rise from 0 to 1")


def _check_signals(metadata: Mapping[str, Any], arrays: Arrays) -> None:
    names, count = metadata.get("signals", []), len(metadata["demonstrations"])
    for place, name in names:
        if not isinstance(name, str) or type(place) is not int or not 0 <= place < count:
            raise ValueError(f"signal {name!r} of demonstration {place!r} is none of this file's")
    if names:
        _check_shape("signals", arrays, len(names), len(SIGNAL_PROGRESS))

"""What an archive holds of a controller, and what is restored of it.

An archive holds finite numbers that belong together; `restored` refuses all others.
"""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.learning._stored_navigation import (
    ACCURACY,
    MAX_VALUE,
    Arrays,
    check_navigation,
    check_numbers,
    check_shape,
    content_of_navigation,
    navigation_of,
)
from handsim.learning.base import plain
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.learning.guide.choice import LeftOut
from handsim.learning.guide.predictor import GuideSettings
from handsim.learning.movement.progress import N_PROGRESS, check_duration
from handsim.learning.options import check_options, is_foreign
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.paths import N_COMPARED

if TYPE_CHECKING:
    from handsim.learning.controller import GraspController

_VECTORS = ("q_start", "q_goal", "z_start", "z_goal")
_CURVES = ("path", "progress")  # of each recording; files of schema 3 and less hold none


def content_of(controller: "GraspController") -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Return the metadata and the arrays of a controller's file.

    Raises
    ------
    InputError
        If its obstacle is of a kind that cannot be written.
    """
    metadata, of_navigation = content_of_navigation(controller.navigation)
    records = [_record(d) for d in controller.demonstrations]
    arrays = controller.subspace.to_arrays()
    kept = _VECTORS if any(r["path"] is None for r in records) else _VECTORS + _CURVES
    arrays.update({name: np.array([record[name] for record in records]) for name in kept})
    for record in records:
        for name in _VECTORS + _CURVES:
            del record[name]
    signals = [(i, *each) for i, r in enumerate(records) for each in r.pop("signals").items()]
    arrays |= of_navigation
    arrays["ranges"] = controller.ranges
    metadata |= {
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
        "navigation": navigation_of(len(arrays["subspace_components"]), metadata, arrays),
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


def check_content(metadata: Mapping[str, Any], arrays: Arrays) -> None:
    """Check what was stored before anything is built of it.

    Raises
    ------
    KeyError, TypeError, ValueError
        If something is missing, of another type or shape, or no possible number.
    """
    check_numbers(arrays)
    if not isinstance(metadata["method"], str):
        raise TypeError(f"method {metadata['method']!r} is not text")
    n = len(arrays["subspace_components"])
    _check_subspace(n, arrays)
    check_navigation(n, metadata, arrays)
    _check_demonstrations(n, metadata["demonstrations"], arrays)
    _check_curves(n, metadata, arrays)
    _check_signals(metadata, arrays)
    if "ranges" in arrays:
        check_shape("ranges", arrays, 2, N_JOINTS)
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


def _check_subspace(n: int, arrays: Arrays) -> None:
    components = arrays["subspace_components"]
    check_shape("subspace_components", arrays, n, N_JOINTS)
    check_shape("subspace_mean", arrays, N_JOINTS)
    for name in ("subspace_explained_variance", "subspace_explained_variance_ratio"):
        check_shape(name, arrays, n)
        if (arrays[name] < 0).any():
            raise ValueError(f"{name} is negative")
    if np.abs(components @ components.T - np.eye(n)).max(initial=0.0) > ACCURACY:
        raise ValueError("subspace_components are not orthonormal")


def _check_demonstrations(n: int, records: Any, arrays: Arrays) -> None:
    if not isinstance(records, list) or not records:
        raise ValueError("no demonstrations")
    rows = cast(list[Any], records)
    for name, length in (
        ("q_start", N_JOINTS), ("q_goal", N_JOINTS), ("z_start", n), ("z_goal", n)
    ):  # fmt: skip
        check_shape(name, arrays, len(rows), length)
    mean, components = arrays["subspace_mean"], arrays["subspace_components"]
    for end in ("start", "goal"):
        z = (arrays[f"q_{end}"] - mean) @ components.T
        if np.abs(z - arrays[f"z_{end}"]).max() > ACCURACY:
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
    check_shape("path", arrays, count, N_COMPARED, n)
    check_shape("progress", arrays, count, N_PROGRESS)
    ends = arrays["path"][:, [0, -1]]
    if np.abs(ends - np.stack([arrays["z_start"], arrays["z_goal"]], axis=1)).max() > ACCURACY:
        raise ValueError("paths do not run from z_start to z_goal")
    progress = arrays["progress"]
    ends = np.abs(progress[:, [0, -1]] - [0.0, 1.0]).max(initial=0.0)
    if (np.diff(progress) < 0).any() or ends > ACCURACY:
        raise ValueError("progress does not rise from 0 to 1")


def _check_signals(metadata: Mapping[str, Any], arrays: Arrays) -> None:
    names, count = metadata.get("signals", []), len(metadata["demonstrations"])
    for place, name in names:
        if not isinstance(name, str) or type(place) is not int or not 0 <= place < count:
            raise ValueError(f"signal {name!r} of demonstration {place!r} is none of this file's")
    if names:
        check_shape("signals", arrays, len(names), len(SIGNAL_PROGRESS))

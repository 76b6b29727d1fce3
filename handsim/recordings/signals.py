"""Scalar signals of a recording: its channels, and two that are derived from them.

``distance_m`` is the distance from the middle of the palm (``palm_x_m`` and y, z) to the object:
``object_x_m`` and y, z or, without those, the only other place that is recorded and no part of the
person, such as ``handle_x_m``.

``emg_envelope`` is the mean of all channels ``emg_...``, each rectified, low-passed at 1.6 Hz. The
filter is causal, so that a live signal gives what a recorded one does.
"""

from collections.abc import Mapping

import numpy as np

from handsim.reproducible import mean, norms
from handsim.types import Array

DISTANCE = "distance_m"
ENVELOPE = "emg_envelope"
ENVELOPE_S = 0.1
"""Time constant of the low-pass of rectified EMG [s]: 1 / (2 pi 0.1 s) = 1.6 Hz."""
_OF_PERSON = frozenset({"palm", "hand", "wrist", "arm", "forearm", "elbow", "shoulder", "torso"})
_AXES = ("x", "y", "z")


def signals_of(time: Array, channels: Mapping[str, Array]) -> dict[str, Array]:
    """Return the channels of a recording and the signals derived from them.

    Parameters
    ----------
    time : (n,) [s]
    channels : name to (n,)
        NaN where a value is missing. A channel that already has a derived name stays as it is.

    Returns
    -------
    dict
        Name to (n,); NaN where a value is missing.
    """
    derived: dict[str, Array] = {}
    places = _places(channels)
    of_things = [name for name in places if name not in _OF_PERSON]
    thing = "object" if "object" in places else of_things[0] if len(of_things) == 1 else None
    if thing is not None and "palm" in places:
        derived[DISTANCE] = norms(places["palm"] - places[thing])[:, 0]
    muscles = [values for name, values in channels.items() if name.startswith("emg_")]
    if muscles and ENVELOPE not in channels:
        derived[ENVELOPE] = envelope(time, np.column_stack(muscles))
    return derived | dict(channels)


def envelope(time: Array, activity: Array) -> Array:
    """Return the envelope (n,) of muscle activity (n, m) as it was recorded.

    Frames in which any muscle is missing are NaN; the filter goes on where it was.
    """
    rectified = mean(np.abs(activity), axis=1)
    result = np.full(len(time), np.nan)
    level, last = None, 0.0
    for i, value in enumerate(rectified):
        if not np.isfinite(value):
            continue
        now = float(time[i])
        level = float(value) if level is None else low_passed(level, value, now - last, ENVELOPE_S)
        result[i], last = level, now
    return result


def low_passed(before: float, value: float, dt: float, seconds: float) -> float:
    """Return the output of a low-pass of first order after ``dt`` [s] at ``value``.

    Parameters
    ----------
    before
        Its output before.
    seconds
        Its time constant; 0 passes everything.
    """
    return before + dt / (seconds + dt) * (float(value) - before) if dt > 0 else before


def _places(channels: Mapping[str, Array]) -> dict[str, Array]:
    """Return the places (n, 3) [m] that are recorded as a whole, by what is there."""
    names = [name.removesuffix("_x_m") for name in channels if name.endswith("_x_m")]
    columns = {name: [f"{name}_{axis}_m" for axis in _AXES] for name in names}
    return {
        name: np.column_stack([channels[column] for column in wanted])
        for name, wanted in columns.items()
        if all(column in channels for column in wanted)
    }

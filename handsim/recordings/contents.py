"""What a set of recordings holds, in numbers."""

from typing import Any

import numpy as np

from handsim.joints import JOINT_NAMES, LOWER, UPPER
from handsim.recordings.plausibility import Anomaly, anomalies
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.statistics import median_statistics, reach_statistics
from handsim.types import Array, Mask

ROUNDING = np.deg2rad(0.1)
"""By so much an angle at the end of its range may pass it: filters overshoot, files are rounded."""


def out_of_range(q: Array) -> Mask:
    """Return which angles (..., 22) [rad] are outside their ranges by more than `ROUNDING`."""
    return (q < LOWER - ROUNDING) | (q > UPPER + ROUNDING)


def summarise(recordings: RecordingSet) -> dict[str, Any]:
    """Summarise a set for ``recordings info``.

    Returns
    -------
    dict
        ``n_recordings``, ``n_frames``, ``subjects``, ``objects`` and ``tasks`` (name to count),
        ``duration_s`` and ``rate_hz`` (least, median, greatest), ``hand_sizes_m`` (the different
        pairs of length and breadth), ``n_frames_out_of_range`` and ``out_of_range`` (joint to
        frames outside its range and to the extreme angles [deg]), ``median_reach``
        (medians of `statistics.ReachStatistics`; NaN where not known), ``recordings`` (for each
        ``name``, ``frames``, ``duration_s``, ``rate_hz``, ``side``, ``light``, ``notes`` and
        ``warnings``: ``kind``, ``severity``, ``joint``, ``value``, ``limit``, ``message``).
    """
    q = np.vstack([recording.q for recording in recordings])
    outside = out_of_range(q)
    joints = {
        name: {
            "n_frames": int(outside[:, j].sum()),
            "least_deg": round(float(np.rad2deg(q[:, j].min())), 2),
            "greatest_deg": round(float(np.rad2deg(q[:, j].max())), 2),
        }
        for j, name in enumerate(JOINT_NAMES)
        if outside[:, j].any()
    }
    return {
        "n_recordings": len(recordings),
        "n_frames": len(q),
        "subjects": _counts([r.subject for r in recordings]),
        "objects": _counts([r.object for r in recordings]),
        "tasks": _counts([r.task for r in recordings]),
        "duration_s": _spread([r.duration for r in recordings]),
        "rate_hz": _spread([(len(r.time) - 1) / r.duration for r in recordings]),
        "hand_sizes_m": [list(size) for size in _hand_sizes(recordings)],
        "n_frames_out_of_range": int(outside.any(axis=1).sum()),
        "out_of_range": joints,
        "median_reach": median_statistics([reach_statistics(r) for r in recordings]),
        "recordings": _each(recordings),
    }


def _each(recordings: RecordingSet) -> list[dict[str, Any]]:
    found: dict[str, list[Anomaly]] = {}
    for anomaly in anomalies(recordings):
        found.setdefault(anomaly.recording, []).append(anomaly)
    return [_row(recording, found.get(recording.name, [])) for recording in recordings]


def _row(recording: Recording, found: list[Anomaly]) -> dict[str, Any]:
    severities = {anomaly.severity for anomaly in found}
    return {
        "name": recording.name,
        "frames": len(recording.time),
        "duration_s": round(recording.duration, 4),
        "rate_hz": round((len(recording.time) - 1) / recording.duration, 3),
        "side": recording.hand.side,
        "light": "red" if "error" in severities else "amber" if found else "green",
        "notes": list(recording.notes),
        "warnings": [
            {
                "kind": anomaly.kind,
                "severity": anomaly.severity,
                "joint": anomaly.joint,
                "value": anomaly.value,
                "limit": anomaly.limit,
                "message": anomaly.message,
            }
            for anomaly in found
        ],
    }


def _hand_sizes(recordings: RecordingSet) -> list[tuple[float, float]]:
    return sorted({(r.hand.length, r.hand.breadth) for r in recordings})


def _counts(names: list[str]) -> dict[str, int]:
    return {name: names.count(name) for name in dict.fromkeys(names)}


def _spread(values: list[float]) -> dict[str, float]:
    return {
        "least": round(min(values), 3),
        "median": round(float(np.median(values)), 3),
        "greatest": round(max(values), 3),
    }

"""How single reaches went: how long, how fast and when, how wide the hand opened and when."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.errors import InputError
from handsim.recordings.cutting.motion import motion_of, on_grid
from handsim.recordings.recording import Recording
from handsim.types import Array

APERTURE = "aperture_m"
MIN_SEEN = 0.5
"""Smallest share of a reach in which the aperture must be known for its largest to mean much."""


@dataclass(frozen=True)
class ReachStatistics:
    """Figures of one reach; NaN where they are not known.

    Attributes
    ----------
    name
    duration_s
        From the first to the last frame [s].
    peak_speed_m_s
        Largest speed of the palm, where its position was recorded and it moves [m/s].
    peak_speed_deg_s
        Largest joint speed, the Euclidean norm over the joints [deg/s].
    peak_speed_at
        When the palm, or without it the joints, move fastest, as a share of the duration.
    aperture_m
        Largest distance from thumb tip to index tip [m].
    aperture_at
        When that is, as a share of the duration.
    closing_s
        From then to the end [s].
    """

    name: str
    duration_s: float
    peak_speed_m_s: float
    peak_speed_deg_s: float
    peak_speed_at: float
    aperture_m: float
    aperture_at: float
    closing_s: float


FIGURES = (
    "duration_s", "peak_speed_m_s", "peak_speed_deg_s", "peak_speed_at",
    "aperture_m", "aperture_at", "closing_s",
)  # fmt: skip


def reach_statistics(recording: Recording) -> ReachStatistics:
    """Measure one reach, at 100 Hz and low-passed at 3 Hz."""
    palm_peak, joint_peak, peak_at = _speeds(recording)
    aperture, aperture_at = _aperture(recording)
    return ReachStatistics(
        name=recording.name,
        duration_s=recording.duration,
        peak_speed_m_s=palm_peak,
        peak_speed_deg_s=math.degrees(joint_peak),
        peak_speed_at=peak_at,
        aperture_m=aperture,
        aperture_at=aperture_at,
        closing_s=(1 - aperture_at) * recording.duration,
    )


def median_statistics(each: Sequence[ReachStatistics]) -> dict[str, float]:
    """Return the median of every figure over the reaches in which it is known; NaN without any."""
    medians: dict[str, float] = {}
    for name in FIGURES:
        values = np.array([getattr(one, name) for one in each], dtype=float)
        known = values[np.isfinite(values)]
        medians[name] = float(np.median(known)) if known.size else math.nan
    return medians


def _speeds(recording: Recording) -> tuple[float, float, float]:
    """Return peak speed of the palm [m/s] and of the joints [rad/s], and when it was."""
    try:
        motion = motion_of(recording.time, recording.q, recording.channels)
    except InputError:  # too short or too long to be a reach; its duration says so
        return math.nan, math.nan, math.nan
    joints = motion_of(recording.time, recording.q, {}).speed if motion.palm else motion.speed
    speed = np.where(motion.seen, motion.speed, 0.0)
    palm_peak = float(speed.max()) if motion.palm else math.nan
    return palm_peak, float(joints.max()), float(np.argmax(speed)) / max(len(speed) - 1, 1)


def _aperture(recording: Recording) -> tuple[float, float]:
    """Return the largest aperture [m] and when it was, as a share of the duration."""
    values = recording.channels.get(APERTURE)
    if values is None:
        return math.nan, math.nan
    smooth, seen = on_grid(recording.time, values, recording.time)
    if seen.mean() < MIN_SEEN:
        return math.nan, math.nan
    known: Array = np.where(seen, smooth, -np.inf)
    widest = int(np.argmax(known))
    return float(known[widest]), float(recording.time[widest] - recording.time[0]) / float(
        recording.duration
    )

"""From a raw glove stream to the reach-to-grasp phase, and what a set of recordings holds.

The rule, measured on published reach-to-grasp data: resample at 100 Hz, low-pass at 3 Hz
without phase lag, take the speed of the whole hand (the Euclidean norm over the joints); the
movement starts where that speed first exceeds 8 % of its peak and ends, once half the peak has
been passed, where it falls under 15 % while the posture is farther from the start than half the
largest distance reached.
"""

from typing import Any

import numpy as np
from scipy import signal

from handsim.errors import InputError
from handsim.joints import JOINT_NAMES, LOWER, UPPER
from handsim.recordings.recording import MIN_FRAMES, RecordingSet
from handsim.types import Array

RATE = 100.0
"""Sampling rate of the glove of the paper [Hz], to which everything is resampled."""
CUTOFF = 3.0
"""Cut-off of the low-pass filter [Hz]: reaching movements hold next to nothing above it."""
ONSET_FRACTION = 0.08
PASSED_FRACTION = 0.5
GRASP_FRACTION = 0.15


def resample(time: Array, q: Array, rate: float = RATE) -> tuple[Array, Array]:
    """Resample linearly at a constant rate.

    Parameters
    ----------
    time : (n,) [s], increasing
    q : (n, d)
    rate : [Hz]

    Returns
    -------
    time : (m,) [s], from the first time on in steps of 1/rate
    q : (m, d)
    """
    uniform: Array = time[0] + np.arange(int(np.floor((time[-1] - time[0]) * rate)) + 1) / rate
    columns: list[Array] = list(q.T)
    return uniform, np.column_stack([np.interp(uniform, time, column) for column in columns])


def low_pass(q: Array, rate: float = RATE, cutoff: float = CUTOFF) -> Array:
    """Filter with a second-order Butterworth low-pass, forwards and backwards (no phase lag).

    Parameters
    ----------
    q : (n, d), n at least 10
    rate, cutoff : [Hz]
    """
    sections = signal.butter(2, cutoff, fs=rate, output="sos")
    padding = min(len(q) - 1, int(rate / cutoff))
    return np.asarray(signal.sosfiltfilt(sections, q, axis=0, padlen=padding))


def hand_speed(q: Array, rate: float = RATE) -> Array:
    """Return the Euclidean norm over the joints of the angular velocity, (n,) [rad/s]."""
    return np.linalg.norm(np.gradient(q, 1 / rate, axis=0), axis=1)


def reach_to_grasp(q: Array, rate: float = RATE) -> slice:
    """Return the frames of the first reach-to-grasp movement in a filtered recording.

    Parameters
    ----------
    q : (n, d) [rad], uniformly sampled and filtered
    rate : [Hz]

    Raises
    ------
    InputError
        If the hand never moves, or the movement is shorter than 10 frames.
    """
    speed = hand_speed(q, rate)
    peak = float(speed.max())
    if peak == 0.0:
        raise InputError("the hand never moves; a reach-to-grasp recording must hold a movement")
    onset = int(np.argmax(speed > ONSET_FRACTION * peak))
    passed = onset + int(np.argmax(speed[onset:] > PASSED_FRACTION * peak))
    distance = np.linalg.norm(q - q[onset], axis=1)
    far = distance > PASSED_FRACTION * distance[onset:].max()
    slow = speed < GRASP_FRACTION * peak
    ended = np.flatnonzero(far[passed:] & slow[passed:])
    end = passed + int(ended[0]) if ended.size else len(q) - 1
    if end + 1 - onset < MIN_FRAMES:
        raise InputError(
            f"the movement lasts {end + 1 - onset} frames; at least {MIN_FRAMES} are needed"
        )
    return slice(onset, end + 1)


def cut_reach_to_grasp(time: Array, q: Array) -> tuple[Array, Array]:
    """Resample, filter and cut one raw trial to its reach-to-grasp phase.

    Returns
    -------
    time : (m,) [s], from 0, at 100 Hz
    q : (m, 22) [rad]
    """
    _, uniform = resample(time, q)
    filtered = low_pass(uniform)
    phase = filtered[reach_to_grasp(filtered)]
    return np.arange(len(phase)) / RATE, phase


def summarise(recordings: RecordingSet) -> dict[str, Any]:
    """Summarise a set for ``recordings info``.

    Returns
    -------
    dict
        ``n_recordings``, ``n_frames``, ``subjects``, ``objects`` and ``tasks`` (name to count),
        ``duration_s`` and ``rate_hz`` (least, median, greatest), ``hand_sizes_m`` (the different
        pairs of length and breadth), ``n_frames_out_of_range`` and ``out_of_range`` (joint to
        frames outside its range and to the extreme angles [deg]).
    """
    q = np.vstack([recording.q for recording in recordings])
    outside = (q < LOWER) | (q > UPPER)
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

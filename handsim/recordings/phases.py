"""From a raw glove stream to the reach-to-grasp phase.

The rule, measured on published reach-to-grasp data: resample at 100 Hz, low-pass at 3 Hz
without phase lag, take the speed of the whole hand (the Euclidean norm over the joints); the
movement starts where that speed first exceeds 8 % of its peak and ends, once half the peak has
been passed, where it falls under 15 % while the posture is farther from the start than half the
largest distance reached.
"""

import math

import numpy as np

from handsim.errors import InputError
from handsim.recordings.recording import MIN_FRAMES
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
    # As scipy.signal.sosfiltfilt, whose import takes as long as to filter a quarter of an hour.
    padding = min(len(q) - 1, int(rate / cutoff))
    before = 2.0 * q[0] - q[padding:0:-1]
    after = 2.0 * q[-1] - q[-2 : -padding - 2 : -1]
    forwards = _filtered(np.concatenate([before, q, after]), rate, cutoff)
    return _filtered(forwards[::-1], rate, cutoff)[::-1][padding : padding + len(q)]


def _filtered(q: Array, rate: float, cutoff: float) -> Array:
    """Filter (n, d) forwards, as if the first frame had lasted for ever before it.

    The bilinear transform of the Butterworth low-pass 1 / (s^2 + sqrt(2) s + 1), with s scaled so
    that the cut-off stays where it is, as a difference equation with two states.
    """
    w = math.tan(math.pi * cutoff / rate)
    scale = 1.0 + math.sqrt(2.0) * w + w * w
    gain = w * w / scale
    a1, a2 = 2.0 * (w * w - 1.0) / scale, (1.0 - math.sqrt(2.0) * w + w * w) / scale
    given = gain * q
    once, twice = q[0] - given[0], given[0] - a2 * q[0]
    filtered = np.empty_like(given)
    for now, out in zip(given, filtered, strict=True):
        np.add(now, once, out=out)
        once = 2.0 * now - a1 * out + twice
        twice = now - a2 * out
    return filtered


def hand_speed(q: Array, rate: float = RATE) -> Array:
    """Return the Euclidean norm of the velocity, (n,): of joints [rad/s], or of a place [m/s]."""
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

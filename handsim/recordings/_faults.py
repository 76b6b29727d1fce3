"""The single tests of plausibility: each looks at one recording and says what cannot be right."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from handsim.joints import JOINT_INDEX, JOINT_NAMES, JOINTS, LOWER, N_JOINTS, UPPER
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import Array, Mask
from handsim.wording import number_of

Severity = Literal["error", "warning"]
_LOWER_DEG, _UPPER_DEG = np.rad2deg(LOWER), np.rad2deg(UPPER)
_FLEXIONS: Mask = np.array(
    [joint.motion == "flexion" and joint.finger is not None for joint in JOINTS]
)
_RATED: Mask = np.array([joint.name != "palm_arch" for joint in JOINTS])
"""All but the palm arch, which no glove measures well: it is far outside in most recordings."""

SMALL_DEG = 5.0
"""A reach moves at least one joint by more; by 60 deg and more in the recordings of people."""
RADIANS = 3.5
"""Largest angle that is likely to be in rad: 200 deg."""
LONGEST_S = 60.0
"""A reach takes 0.3 to 5 s; what lasts longer than this holds more than one, or other units."""
SHORTEST_S = 0.1
SLOWEST_HZ = 5.0
"""A movement of a second needs more than 5 frames."""
OUTSIDE_DEG = 5.0
"""By so much a joint may leave its range: gloves are seldom calibrated better."""
MOST = 0.5
MANY_JOINTS = 4
"""Joints outside their ranges in most frames from which units or order are wrong; people have 1."""
IN_ALL_DEG = 40.0
"""The same by the sum over joints of what they are outside, on the average; people have 4 to 14."""
COUNT = 60.0
"""Median of all angles from which they are likely to be raw counts [deg]."""
TURNED = 3.0
"""How much farther flexions leave their ranges as given than with their signs turned around."""
AWAY = 0.25
"""A reach ends farther from its start than this part of the farthest it gets."""
WRAP_DEG = 180.0
FASTEST_DEG_S = 5000.0
"""Angular velocity that no finger reaches; fast tapping has 1500 deg/s."""
STUCK_DEG = 0.01
MOVES_DEG = 5.0
STUCK = 0.6
GAP = 5.0
GAP_S = 0.1
RATE = 0.05


@dataclass(frozen=True)
class Fault:
    """What a test found: see `handsim.recordings.plausibility.Anomaly`."""

    kind: Any
    severity: Severity
    value: float
    limit: float
    message: str
    joint: str | None = None


def of_time(recording: Recording) -> Iterator[Fault]:
    """Durations and rates that no recording of a reach has."""
    steps, duration = np.diff(recording.time), recording.duration
    rate = len(steps) / duration
    if rate < SLOWEST_HZ:
        yield Fault(
            *("milliseconds", "error", duration, LONGEST_S),
            f"lasts {duration:.4g} s at {rate:.3g} frames a second, less than {SLOWEST_HZ:g}; are "
            "the times milliseconds or frame numbers? give them in seconds, or import the file "
            "with a map that says their unit",
        )
    elif duration > LONGEST_S:
        yield Fault(
            *("duration", "error", duration, LONGEST_S),
            f"lasts {duration:.4g} s, more than {LONGEST_S:g} s, and a reach a few; cut the "
            "reaches out with `handsim recordings cut`",
        )
    elif duration < SHORTEST_S:
        yield Fault(
            *("duration", "error", duration, SHORTEST_S),
            f"lasts {duration:.3g} s, less than {SHORTEST_S:g} s; are the times in minutes, or is "
            "the rate wrong? give them in seconds",
        )
    longest, usual = float(steps.max()), float(np.median(steps))
    if rate >= SLOWEST_HZ and longest > max(GAP * usual, GAP_S):
        yield Fault(
            *("gap", "warning", longest, max(GAP * usual, GAP_S)),
            f"{longest:.3g} s pass between two frames, {usual:.3g} s as a rule; the movement in "
            "between is not known",
        )
    stated = _stated_rate(recording)
    if stated is not None and abs(1 / usual - stated) > RATE * stated:
        yield Fault(
            *("rate", "warning", 1 / usual, stated),
            f"has {1 / usual:.4g} frames a second by its times, {stated:g} by what it states; "
            "correct either",
        )


def _stated_rate(recording: Recording) -> float | None:
    for name in ("rate_hz", "rate", "sampling_rate_hz", "frequency_hz"):
        try:
            stated = float(recording.extra.get(name, ""))
        except ValueError:
            continue
        if np.isfinite(stated) and stated > 0:
            return stated
    return None


def of_movement(recording: Recording) -> Iterator[Fault]:
    """Movements that are too small to be in degrees, or lead back to where they began."""
    angles = np.rad2deg(recording.q)
    moved, largest = np.ptp(angles, axis=0), float(np.abs(angles).max())
    joint, most = JOINT_NAMES[int(moved.argmax())], float(moved.max())
    if most < SMALL_DEG and largest <= RADIANS:
        yield Fault(
            *("radians", "error", most, SMALL_DEG),
            f"the largest movement of a joint is {most:.2g} deg, less than {SMALL_DEG:g}, and no "
            f"angle exceeds {largest:.2g}; are these radians? import with --units rad",
            joint,
        )
        return
    if most < SMALL_DEG:
        yield Fault(
            *("small", "error", most, SMALL_DEG),
            f"the largest movement of a joint is {most:.2g} deg, less than {SMALL_DEG:g}; the hand "
            "does not reach for anything, leave the recording out",
            joint,
        )
        return
    away = np.linalg.norm(angles - angles[0], axis=1)
    farthest, at_end = float(away.max()), float(away[-1])
    if at_end < AWAY * farthest:
        yield Fault(
            *("rest-to-rest", "error", at_end, AWAY * farthest),
            f"ends {at_end:.2g} deg from where it starts, having been {farthest:.0f} deg away: "
            "start and end are the same posture; cut the reach out with `handsim recordings cut`",
        )


def of_whole_hand(q: Array, tolerance: float = 1.0) -> Fault | None:
    """Units, signs or order of all angles wrong, judged on frames of one hand, (n, 22) [rad].

    A single recording is given twice the tolerance of all recordings of a hand together.
    """
    angles = np.rad2deg(q)
    outside = _outside(angles)
    wrong = (outside > OUTSIDE_DEG).mean(axis=0) > MOST
    in_all = float(outside[:, _RATED].mean(axis=0).sum())
    if wrong.sum() < tolerance * MANY_JOINTS and in_all < tolerance * IN_ALL_DEG:
        return None
    middle, j = float(np.median(angles)), int(outside.mean(axis=0).argmax())
    if angles.min() >= 0 and middle > COUNT:
        return Fault(
            *("counts", "error", middle, COUNT),
            f"{number_of(wrong.sum(), 'joint is', 'joints are')} out of range in most frames, and "
            f"half of all angles exceed {middle:.0f} deg; are these raw counts of a glove? "
            "calibrate them with `handsim recordings calibrate` and import them with --calibration",
        )
    as_given = float(outside[:, _FLEXIONS].mean(axis=0).sum())
    turned = float(_outside(-angles)[:, _FLEXIONS].mean(axis=0).sum())
    if as_given > IN_ALL_DEG / 2 and as_given > TURNED * turned:
        return Fault(
            *("sign", "error", as_given, IN_ALL_DEG / 2),
            f"the flexions are outside their ranges by {as_given:.0f} deg in all, and by "
            f"{turned:.0f} with their signs turned around; flexion and spreading are positive, "
            "turn the signs in a map and import with it",
        )
    return Fault(
        *("range", "error", in_all, tolerance * IN_ALL_DEG),
        f"joints are outside their ranges by {in_all:.0f} deg in all on the average, and "
        f"{wrong.sum()} of them most of the time, this one by {outside[:, j].mean():.0f} deg; "
        "check the order of the columns, their units and the calibration",
        JOINT_NAMES[j],
    )


def _outside(angles: Array) -> Array:
    return np.maximum(_LOWER_DEG - angles, 0) + np.maximum(angles - _UPPER_DEG, 0)


def of_angles(recording: Recording) -> Iterator[Fault]:
    """Joints that are outside their ranges most of the time, and jumps."""
    angles = np.rad2deg(recording.q)
    share = (_outside(angles) > OUTSIDE_DEG).mean(axis=0)
    for j in np.flatnonzero(share > MOST):
        median = float(np.median(angles[:, j]))
        limit = _LOWER_DEG[j] if median < _LOWER_DEG[j] else _UPPER_DEG[j]
        yield Fault(
            *("range", "warning", median, float(limit)),
            f"{100 * share[j]:.0f} % of frames are outside its range of {_LOWER_DEG[j]:g} to "
            f"{_UPPER_DEG[j]:g} deg, half of them beyond {median:.0f} deg; check sign, offset and "
            "calibration of this sensor",
            JOINT_NAMES[j],
        )
    yield from _jumps(recording, angles)


def _jumps(recording: Recording, angles: Array) -> Iterator[Fault]:
    steps = np.abs(np.diff(angles, axis=0))
    for j in np.flatnonzero(steps.max(axis=0) > WRAP_DEG):
        frame = int(steps[:, j].argmax()) + 1
        yield Fault(
            *("wrap", "error", steps[frame - 1, j], WRAP_DEG),
            f"jumps by {steps[frame - 1, j]:.0f} deg at {recording.time[frame]:.3f} s, near a "
            "whole turn; import with --unwrap",
            JOINT_NAMES[j],
        )
    speed = steps / np.diff(recording.time)[:, None]
    # A step of a coarse sensor is no jump: it has to be larger than what sensors are off by.
    fast = (speed > FASTEST_DEG_S) & (steps > 4 * OUTSIDE_DEG) & (steps <= WRAP_DEG)
    if not fast.any():
        return
    frame, j = (int(i) for i in np.unravel_index(np.argmax(np.where(fast, steps, 0)), fast.shape))
    others = int(fast.any(axis=0).sum()) - 1
    also = f", as {number_of(others, 'other does', 'others do')}" if others else ""
    yield Fault(
        *("jump", "warning", speed[frame, j], FASTEST_DEG_S),
        f"jumps by {steps[frame, j]:.0f} deg within a frame at {recording.time[frame + 1]:.3f} s, "
        f"faster than {FASTEST_DEG_S:g} deg/s{also}; look for "
        "a loose sensor, or frames that are missing",
        JOINT_NAMES[j],
    )


def constant_joints(recordings: RecordingSet) -> Mask:
    """Return which joints, (22,), do not move in any of the recordings."""
    return np.all([np.ptp(r.q, axis=0) < np.deg2rad(STUCK_DEG) for r in recordings], axis=0)


def of_sensors(recording: Recording, constant_everywhere: Mask) -> Iterator[Fault]:
    """Sensors that say nothing, or stop saying anything while the hand moves."""
    angles = np.rad2deg(recording.q)
    still = np.ptp(angles, axis=0) < STUCK_DEG
    if still.sum() > N_JOINTS / 2:
        yield Fault(
            *("constant", "error", still.sum(), N_JOINTS / 2),
            f"{still.sum()} of {N_JOINTS} joints do not move at all; check the sensors, or leave "
            "the recording out",
        )
        return
    known = np.isin(JOINT_NAMES, list(recording.not_seen))
    for j in np.flatnonzero(still & ~known):
        where = "in no recording" if constant_everywhere[j] else "in this recording"
        yield Fault(
            *("constant", "warning", float(np.ptp(angles[:, j])), STUCK_DEG),
            f"stays at {angles[0, j]:.1f} deg and moves {where}; if it has a sensor, check it",
            JOINT_NAMES[j],
        )
    moving = _moving(recording.time, angles)
    longest = _longest_still(angles, moving)
    for j in np.flatnonzero(~still & (np.ptp(angles, axis=0) > MOVES_DEG)):
        share = float(longest[j])
        if share > STUCK:
            yield Fault(
                *("stuck", "warning", share, STUCK),
                f"does not change for {100 * share:.0f} % of the time in which the hand moves, and "
                "then jumps; look for a loose sensor",
                JOINT_NAMES[j],
            )


def _moving(time: Array, angles: Array) -> Mask:
    """Steps between frames in which the hand moves: faster than a fifth of nine tenths of them."""
    speed = np.linalg.norm(np.diff(angles, axis=0), axis=1) / np.diff(time)
    return speed > 0.2 * np.percentile(speed, 90)  # not of the peak, which may be a jump


def _longest_still(angles: Array, moving: Mask) -> Array:
    """Longest stretches without change of joints (N, m), as parts of the steps of movement."""
    counted = np.cumsum(moving)[:, None]
    same = np.abs(np.diff(angles, axis=0)) < STUCK_DEG / 10
    at_last_change = np.maximum.accumulate(np.where(same, 0, counted), axis=0)
    return (counted - at_last_change).max(axis=0) / max(moving.sum(), 1)


def mirrored(recording: Recording, joints: Sequence[str]) -> Fault:
    """Abductions that have the signs of the other hand's glove."""
    j = JOINT_INDEX[joints[0]]
    mean = float(np.rad2deg(recording.q[:, j].mean()))
    remedy = (
        "is it a left hand? state its side with --side left or in experiments.csv"
        if recording.hand.side == "right"
        else "turn their signs around in a map and import with it"
    )
    return Fault(
        *("side", "warning", mean, float(_LOWER_DEG[j])),
        f"{mean:.1f} deg on the average, and the other abductions are negative too: spreading is "
        f"positive; {remedy}",
        joints[0],
    )

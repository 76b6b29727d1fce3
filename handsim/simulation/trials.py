"""When a grasp counts as held.

The rules' limits belong to the tasks and were fixed before any grasp was tuned. A run is judged by
its traces alone: by peak slip, not by the end state, and by tilt from the object's first pose, not
from after the squeeze.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.hand.grasp_task import PassRule, Task

Array = npt.NDArray[np.float64]
JUDGED = ("carry", "turn")
"""Kinds of rules that can be judged."""

Reason = Literal["missed", "slipped", "tilted", "penetrated", "not arrived", "unstable"]


MAX_PENETRATION = 0.01
"""Deepest overlap of hand and object that is still a grasp [m], as in DexGraspBench."""
SAMPLE = 0.011
"""Tolerance on the time held: one sample of a 100 Hz record [s]."""


@dataclass(frozen=True)
class Outcome:
    """How a run was judged.

    Attributes
    ----------
    success, reason
        The reason is None when it succeeded.
    lift_m, peak_slip_m, peak_tilt_deg, hold_s
        What the rule looks at; ``hold_s`` is the longest stretch within all limits.
    contacts
        Parts of the hand (fingers and palm) that touch the object at the end.
    penetration_m
        Deepest overlap of hand and object.
    detail
        A sentence for people where the reason needs one, such as the step of an instability.
    """

    success: bool
    reason: Reason | None
    lift_m: float
    peak_slip_m: float
    peak_tilt_deg: float
    hold_s: float
    contacts: int
    penetration_m: float
    detail: str = ""


@dataclass(frozen=True)
class GraspTraces:
    """What a rule judges: samples of one run at a constant rate.

    Attributes
    ----------
    time : (n,) [s]
    object_pos, object_quat : (n, 3) [m], (n, 4)
        Pose of the object's centre of mass in the world, quaternions w, x, y, z.
    palm_pos, palm_quat : (n, 3) [m], (n, 4)
    touching : (n,)
        Number of hand parts that touch the object.
    penetration : (n,) [m]
    action_start
        Time at which the task's first movement is commanded [s].
    symmetry
        Axis of the object about which rotation does not count, or None.
    arrived
        Whether the driver brought the hand to its destination.
    unstable_at
        Time of the first sample that is not a number or absurd, or None [s].
    """

    time: Array
    object_pos: Array
    object_quat: Array
    palm_pos: Array
    palm_quat: Array
    touching: npt.NDArray[np.int64]
    penetration: Array
    action_start: float
    symmetry: Literal["x", "z"] | None
    arrived: bool = True
    unstable_at: float | None = None


def judge(traces: GraspTraces, task: Task) -> Outcome:
    """Judge a run by the rule of its task.

    Raises
    ------
    InputError
        If the rule is of a kind that cannot be judged yet.
    """
    rule = task.rule
    if rule.kind not in JUDGED:
        raise InputError(
            f"task '{task.name}': rules of kind '{rule.kind}' are not judged yet; "
            f"choose a task of kind {' or '.join(JUDGED)}"
        )
    if traces.unstable_at is not None:
        detail = f"the simulation diverged at {traces.unstable_at:.3f} s"
        return Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0, detail)
    acting = traces.time >= traces.action_start - 1e-9
    slip, tilt = _slip(traces), np.rad2deg(_tilt(traces))
    height = traces.object_pos[:, 2] - traces.object_pos[0, 2]
    within = (height >= rule.lift) & (slip < rule.slip) & (tilt < rule.tilt_deg)
    within &= (traces.touching > 0) & acting
    measured = {
        "lift_m": float(height.max()),
        "peak_slip_m": float(slip[acting].max()),
        "peak_tilt_deg": float(tilt.max()),
        "hold_s": _longest_stretch(within, traces.time),
        "contacts": int(traces.touching[-1]),
        "penetration_m": float(traces.penetration.max()),
    }
    reason, detail = _carry_reason(traces, rule, measured)
    if reason is None and rule.kind == "turn":
        reason, detail = _turn_reason(traces, task)
    return Outcome(success=reason is None, reason=reason, detail=detail, **measured)


def _carry_reason(
    traces: GraspTraces, rule: PassRule, measured: dict[str, float]
) -> tuple[Reason | None, str]:
    if measured["penetration_m"] > MAX_PENETRATION:
        return "penetrated", f"hand and object overlap by {1000 * measured['penetration_m']:.1f} mm"
    steady = measured["peak_slip_m"] < rule.slip and measured["peak_tilt_deg"] < rule.tilt_deg
    if steady and measured["hold_s"] >= rule.hold - SAMPLE:
        return None, ""
    if not traces.arrived:
        return "not arrived", "the fingers were not at their destination when the reach ended"
    if measured["lift_m"] < 0.2 * rule.lift:
        return "missed", f"the object rose {1000 * measured['lift_m']:.0f} mm"
    if measured["peak_tilt_deg"] >= rule.tilt_deg and measured["peak_slip_m"] < rule.slip:
        return "tilted", f"it tilted by {measured['peak_tilt_deg']:.0f} deg"
    return "slipped", (
        f"it moved {1000 * measured['peak_slip_m']:.0f} mm in the hand "
        f"and was held {measured['hold_s']:.1f} s"
    )


def _turn_reason(traces: GraspTraces, task: Task) -> tuple[Reason | None, str]:
    """Check that the carried object was turned about the axis of the task's turning steps."""
    turned = Rotation.from_quat(traces.object_quat, scalar_first=True)
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    rotation = (turned * turned[start].inv()).as_rotvec()
    axes = [np.array(step.axis) for step in task.steps if step.angle_deg and not step.flex]
    angle = max((float(np.rad2deg((rotation @ axis).max())) for axis in axes), default=0.0)
    if angle >= task.rule.angle_deg:
        return None, ""
    return "slipped", f"it was turned by {angle:.0f} deg of {task.rule.angle_deg:g} deg"


def _slip(traces: GraspTraces) -> Array:
    """Displacement of the object in the palm's frame since the lift began, (n,) [m]."""
    palm = Rotation.from_quat(traces.palm_quat, scalar_first=True)
    local = palm.inv().apply(traces.object_pos - traces.palm_pos)
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    return np.linalg.norm(local - local[start], axis=1)


def _tilt(traces: GraspTraces) -> Array:
    """Rotation of the object since its first pose, less that of the palm in the lift, (n,) [rad].

    Before the lift the palm turns on its way to the object, which tilts nothing; from the lift on
    an object that turns with the palm (as in drinking) does not tilt in the hand.
    """
    turned = Rotation.from_quat(traces.object_quat, scalar_first=True)
    palm = Rotation.from_quat(traces.palm_quat, scalar_first=True)
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    carried = palm * palm[start].inv()
    own = Rotation.concatenate([turned[:start], carried[start:].inv() * turned[start:]])
    if traces.symmetry is None:
        return (own * own[0].inv()).magnitude()
    axes = own.apply(np.eye(3)["xyz".index(traces.symmetry)])
    return np.arccos(np.clip(axes @ axes[0], -1.0, 1.0))


def _longest_stretch(within: npt.NDArray[np.bool_], time: Array) -> float:
    """Longest time for which ``within`` stays true [s]."""
    longest, start = 0.0, None
    for now, held in zip(time, within, strict=True):
        if not held:
            start = None
            continue
        start = now if start is None else start
        longest = max(longest, float(now - start))
    return longest


def wilson_interval(successes: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson's score interval of a success rate (95 % by default).

    References
    ----------
    E. B. Wilson (1927), J. Am. Stat. Assoc. 22(158):209-212.
    """
    if trials == 0:
        return 0.0, 1.0
    rate = successes / trials
    centre = rate + z**2 / (2 * trials)
    spread = z * np.sqrt(rate * (1 - rate) / trials + z**2 / (4 * trials**2))
    scale = 1 + z**2 / trials
    return float((centre - spread) / scale), float((centre + spread) / scale)

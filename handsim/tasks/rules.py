"""When a grasp counts as held.

The rules' limits belong to the tasks and were fixed before any grasp was tuned. A run is judged by
its traces alone: by peak slip, not by the end state, and by tilt from the object's first pose, not
from after the squeeze.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.result import Result
from handsim.tasks.task import PassRule, Task
from handsim.types import Array

Reason = Literal["missed", "slipped", "tilted", "penetrated", "not arrived", "unstable"]

MAX_PENETRATION = 0.01
"""Deepest overlap of hand and object that is still a grasp [m], as in DexGraspBench."""
TRACE_HEIGHT = 0.003
"""How near to the table a front end draws on it [m]."""
SAMPLE = 0.011
"""Tolerance on the time held: one sample of a 100 Hz record [s]."""


@dataclass(frozen=True)
class Outcome(Result):
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
    done
        Share of what the rule asks of the action, beside lift and hold; 1 where it asks nothing.
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
    done: float = 0.0
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
    front_pos : (n, 3) [m]
        The object's front end in the world, for rules of kind ``trace``.
    hinge : (n,) [rad]
        Angle of the rule's hinge, for rules of kind ``joint``.
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
    front_pos: Array | None = None
    hinge: Array | None = None
    arrived: bool = True
    unstable_at: float | None = None


def judge(traces: GraspTraces, task: Task) -> Outcome:
    """Judge a run by the rule of its task.

    An object that is worked where it stands (rules of kind ``joint``) is not carried, so that its
    displacement and tilt are those on the table; all others' are those in the hand.
    """
    rule = task.rule
    if traces.unstable_at is not None:
        step = len(traces.time) - 1
        detail = f"the simulation diverged at {traces.unstable_at:.3f} s (step {step})"
        return Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0, detail=detail)
    acting = traces.time >= traces.action_start - 1e-9
    carried = rule.kind != "joint"
    slip, tilt = _slip(traces, carried), np.rad2deg(_tilt(traces, carried))
    height = traces.object_pos[:, 2] - traces.object_pos[0, 2]
    high = height <= rule.lift if rule.kind == "slide" else height >= rule.lift
    within = high & (slip < rule.slip) & (tilt < rule.tilt_deg)
    within &= (traces.touching > 0) & acting
    measured: dict[str, Any] = {
        "lift_m": float(height.max()),
        "peak_slip_m": float(slip[acting].max()),
        "peak_tilt_deg": float(tilt.max()),
        "hold_s": _longest_stretch(within, traces.time),
        "contacts": int(traces.touching[-1]),
        "penetration_m": float(traces.penetration.max()),
    }
    reason, detail = _grip_reason(traces, rule, measured)
    done, action_reason, action_detail = _action(traces, task)
    if reason is None:
        reason, detail = action_reason, action_detail
    return Outcome(success=reason is None, reason=reason, detail=detail, done=done, **measured)


def _grip_reason(
    traces: GraspTraces, rule: PassRule, measured: dict[str, float]
) -> tuple[Reason | None, str]:
    """Check what every rule asks for: penetration, slip, tilt, height and the time of it."""
    if measured["penetration_m"] > MAX_PENETRATION:
        return "penetrated", f"hand and object overlap by {1000 * measured['penetration_m']:.1f} mm"
    lift = measured["lift_m"]
    steady = measured["peak_slip_m"] < rule.slip and measured["peak_tilt_deg"] < rule.tilt_deg
    level = lift <= rule.lift if rule.kind == "slide" else lift >= rule.lift
    if steady and (level or rule.kind == "joint") and measured["hold_s"] >= rule.hold - SAMPLE:
        return None, ""
    if not traces.arrived:
        return "not arrived", "the fingers were not at their destination when the reach ended"
    if rule.kind != "slide" and lift < 0.2 * rule.lift:
        return "missed", f"the object rose {1000 * lift:.0f} mm"
    if measured["peak_tilt_deg"] >= rule.tilt_deg and measured["peak_slip_m"] < rule.slip:
        return "tilted", f"it tilted by {measured['peak_tilt_deg']:.0f} deg"
    return "slipped", (
        f"it moved {1000 * measured['peak_slip_m']:.0f} mm in the hand, rose {1000 * lift:.0f} mm "
        f"and was held {measured['hold_s']:.1f} s"
    )


def _action(traces: GraspTraces, task: Task) -> tuple[float, Reason | None, str]:
    """Return the share done of what the rule's kind asks of the action, and what is wrong."""
    rule = task.rule
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    if rule.kind == "joint":
        return _hinge(traces, rule, start)
    if rule.kind == "turn":
        done = _turned(traces, task, start) / rule.angle_deg
        detail = f"it was turned by {done * rule.angle_deg:.0f} deg of {rule.angle_deg:g} deg"
    elif rule.kind == "slide":
        way = traces.object_pos[-1, :2] - traces.object_pos[start, :2]
        done = float(np.linalg.norm(way)) / rule.distance
        detail = f"displaced by {1e3 * done * rule.distance:.0f} of {1e3 * rule.distance:.0f} mm"
    elif rule.kind == "trace":
        done = _drawn(traces, start) / rule.distance
        drawn = 1e3 * done * rule.distance
        detail = f"its front end drew {drawn:.0f} of {1e3 * rule.distance:.0f} mm"
    else:
        return 1.0, None, ""
    return (1.0, None, "") if done >= 1 else (max(done, 0.0), "slipped", detail)


def _turned(traces: GraspTraces, task: Task, start: int) -> float:
    """Largest turn of the carried object about the axis of a turning step, since the action [deg].

    What the reach knocked round before does not count, neither way.
    """
    turned = Rotation.from_quat(traces.object_quat[start:], scalar_first=True)
    rotation = (turned * turned[0].inv()).as_rotvec()
    axes = [np.array(step.axis) for step in task.steps if step.angle_deg and not step.flex]
    return max((float(np.rad2deg((rotation @ axis).max())) for axis in axes), default=0.0)


def _drawn(traces: GraspTraces, start: int) -> float:
    """Greatest displacement of the front end in one stretch near the table [m]."""
    assert traces.front_pos is not None
    front = traces.front_pos[start:]
    near = front[:, 2] <= TRACE_HEIGHT
    drawn, first = 0.0, None
    for i, on_table in enumerate(near.tolist()):
        if not on_table:
            first = None
            continue
        first = i if first is None else first
        drawn = max(drawn, float(np.linalg.norm(front[i, :2] - front[first, :2])))
    return drawn


def _hinge(traces: GraspTraces, rule: PassRule, start: int) -> tuple[float, Reason | None, str]:
    """Check that the hinge passed its angle in the action, and not before."""
    assert traces.hinge is not None
    angle = np.rad2deg(traces.hinge)
    way = rule.angle_deg - angle[0]
    done = (angle - angle[0]) / way
    if done[start] >= 1:
        return 0.0, "missed", f"{rule.joint} was at {angle[start]:.1f} deg before the action"
    most = start + int(done[start:].argmax())
    if done[most] >= 1:
        return 1.0, None, ""
    detail = f"{rule.joint} came to {angle[most]:.1f} of {rule.angle_deg:g} deg"
    return max(float(done[most]), 0.0), "missed", detail


def _slip(traces: GraspTraces, carried: bool) -> Array:
    """Displacement in the palm since the action began, or on the table throughout, (n,) [m]."""
    if not carried:
        return np.linalg.norm(traces.object_pos - traces.object_pos[0], axis=1)
    palm = Rotation.from_quat(traces.palm_quat, scalar_first=True)
    local = palm.inv().apply(traces.object_pos - traces.palm_pos)
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    return np.linalg.norm(local - local[start], axis=1)


def _tilt(traces: GraspTraces, in_hand: bool) -> Array:
    """Rotation of the object since its first pose, less that of the palm in the lift, (n,) [rad].

    Before the lift the palm turns on its way to the object, which tilts nothing; from the lift on
    an object that turns with the palm (as in drinking) does not tilt in the hand. Of an object
    that is not ``in_hand`` all its rotation counts.
    """
    turned = Rotation.from_quat(traces.object_quat, scalar_first=True)
    palm = Rotation.from_quat(traces.palm_quat, scalar_first=True)
    start = int(np.searchsorted(traces.time, traces.action_start - 1e-9))
    carried = palm * palm[start].inv()
    own = Rotation.concatenate([turned[:start], carried[start:].inv() * turned[start:]])
    own = own if in_hand else turned
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

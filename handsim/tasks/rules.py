"""When a grasp counts as held.

The rules' limits belong to the tasks and were fixed before any grasp was tuned. A run is judged by
its traces alone: by peak slip, not by the end state, and by tilt from the object's first pose, not
from after the squeeze. What every grasp has to show beside its task is in `tasks.grip_rules`.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.joints import CONTACT_PARTS
from handsim.result import Result
from handsim.tasks.grip_rules import (
    LEAST_PRESS,
    MAX_FORCE,
    MAX_MARGIN,
    MAX_PENETRATION,
    MAX_PUSH,
    MAX_PUSH_TURN_DEG,
    OPPOSED_COSINE,
    OPPOSED_SHARE,
    Reason,
    Shown,
    broken,
)
from handsim.tasks.task import PassRule, Task
from handsim.tasks.traces import AVERAGED, GraspTraces
from handsim.tasks.turns import composed
from handsim.types import Array

ASTRAY_DEG = 20.0
"""Largest angle between the way that an object is slid or drawn with and the way asked for."""
ASTRAY = 0.015
"""Farthest that it may leave that way to either side [m]."""
TRACE_HEIGHT = 0.003
"""How near to the table a front end draws on it [m]."""
SAMPLE = 0.011
"""Tolerance on the time held: one sample of a 100 Hz record [s]."""


LIMITS = (
    *(MAX_PUSH, MAX_PUSH_TURN_DEG, MAX_PENETRATION, MAX_FORCE, MAX_MARGIN, LEAST_PRESS),
    *(OPPOSED_COSINE, OPPOSED_SHARE, AVERAGED, TRACE_HEIGHT, ASTRAY_DEG, ASTRAY),
)
"""All limits that tasks share. A plan made under other limits is made again."""


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
    pushed_m, pushed_deg
        How far the object was moved and turned before the action.
    forces_n
        Mean force of each part of the hand in the hold, by name [N].
    need_n, margin
        Least force on a side that holds the object [N], and the greatest of the forces beside it.
    table_force_n
        Most that hand and arm pressed on the table.
    opposed
        Share of action and hold in which thumb and fingers press against each other.
    strain
        How far from natural the arm is at worst: up to 1 a person does it; no rule asks for it.
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
    pushed_m: float = 0.0
    pushed_deg: float = 0.0
    forces_n: dict[str, float] = field(default_factory=dict[str, float], hash=False)
    need_n: float = 0.0
    margin: float = 0.0
    table_force_n: float = 0.0
    opposed: float = 0.0
    strain: float = 0.0
    done: float = 0.0
    detail: str = ""


def judge(traces: GraspTraces, task: Task) -> Outcome:
    """Judge a run by the rule of its task, and by what every grasp has to show.

    An object that is worked where it stands (rules of kind ``joint``) is not carried: until the
    hold its displacement and tilt are those on the table.
    """
    rule = task.rule
    if traces.unstable_at is not None:
        step = len(traces.time) - 1
        detail = f"the simulation diverged at {traces.unstable_at:.3f} s (step {step})"
        return Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0, detail=detail)
    shown = Shown.by(traces, task)
    measured = _measured(traces, task, shown)
    reason, detail = _grip_reason(traces, rule, measured)
    done, action_reason, action_detail = _action(traces, task)
    if reason is None:
        reason, detail = action_reason, action_detail
    if reason is None:
        reason, detail = broken(traces, task, shown) or (None, "")
    return Outcome(success=reason is None, reason=reason, detail=detail, done=done, **measured)


def _measured(traces: GraspTraces, task: Task, shown: Shown) -> dict[str, Any]:
    """Measure all that an outcome says beside the verdict."""
    rule = task.rule
    slip, tilt = _slip(traces, rule), np.rad2deg(_tilt(traces, rule))
    acting = np.arange(len(traces.time)) >= traces.first_acting
    height = traces.object_pos[:, 2] - traces.object_pos[0, 2]
    high = height <= rule.lift if rule.kind == "slide" else height >= rule.lift
    high |= rule.kind == "joint"  # worked where it stands
    within = high & (slip < rule.slip) & (tilt < rule.tilt_deg) & traces.touching & acting
    return {
        "lift_m": float(height.max()),
        "peak_slip_m": float(slip[acting].max()),
        "peak_tilt_deg": float(tilt.max()),
        "hold_s": _longest_stretch(within, traces.time),
        "contacts": int((traces.force[-1] > 0).sum()),
        "penetration_m": shown.overlap,
        "pushed_m": shown.way,
        "pushed_deg": shown.turned,
        "forces_n": dict(zip(CONTACT_PARTS, shown.forces.tolist(), strict=True)),
        "need_n": traces.need,
        "margin": shown.margin,
        "table_force_n": shown.table,
        "opposed": shown.share,
        "strain": traces.strain,
    }


def _grip_reason(
    traces: GraspTraces, rule: PassRule, measured: dict[str, float]
) -> tuple[Reason | None, str]:
    """Check slip, tilt, height and the time of it."""
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
    rule, start = task.rule, traces.first_acting
    if rule.kind == "joint":
        return _hinge(traces, rule, start)
    if rule.kind == "turn":
        done = _turned(traces, task, start) / rule.angle_deg
        detail = f"it was turned by {done * rule.angle_deg:.0f} deg of {rule.angle_deg:g} deg"
    elif rule.kind == "slide":
        acting = slice(start, traces.first_holding + 1)
        path = traces.object_pos[acting, :2] - traces.object_pos[start, :2]
        done, strayed = _along(path, _asked_way(task), rule.distance)
        detail = f"displaced by {1e3 * done * rule.distance:.0f} of {1e3 * rule.distance:.0f} mm"
        if done >= 1 and strayed:
            return 1.0, "astray", strayed
    elif rule.kind == "trace":
        done, strayed = _drawn(traces, task, start)
        drawn = 1e3 * done * rule.distance
        detail = f"its front end drew {drawn:.0f} of {1e3 * rule.distance:.0f} mm"
        if done >= 1 and strayed:
            return 1.0, "astray", strayed
    else:
        return 1.0, None, ""
    return (1.0, None, "") if done >= 1 else (max(done, 0.0), "slipped", detail)


def _asked_way(task: Task) -> Array:
    """Return the unit vector (2,) of the longest horizontal shift of a task's steps."""
    shifts = [np.array(step.shift[:2]) for step in task.steps]
    longest = max(shifts, key=lambda shift: float(np.linalg.norm(shift)))
    return longest / np.linalg.norm(longest)


def _along(path: Array, way: Array, distance: float) -> tuple[float, str]:
    """Return the share of a distance done by a path (n, 2) [m], and how it strayed from its way."""
    end = path[-1]
    done = float(np.linalg.norm(end)) / distance
    off = float(np.rad2deg(np.arccos(np.clip(end @ way / max(np.linalg.norm(end), 1e-9), -1, 1))))
    aside = float(np.abs(path @ [-way[1], way[0]]).max())
    if off <= ASTRAY_DEG and aside <= ASTRAY:
        return done, ""
    return done, f"it went {off:.0f} deg and {1e3 * aside:.0f} mm beside the way asked for"


def _turned(traces: GraspTraces, task: Task, start: int) -> float:
    """Largest turn of the carried object about the axis of a turning step, since the action [deg].

    What the reach knocked round before does not count, neither way.
    """
    from scipy.spatial.transform import Rotation  # see `GraspTraces.slip`

    turned = Rotation.from_quat(traces.object_quat[start:], scalar_first=True)
    rotation = composed(turned, turned[0].inv()).as_rotvec()
    axes = [np.array(step.axis) for step in task.steps if step.angle_deg and not step.flex]
    return max((float(np.rad2deg((rotation @ axis).max())) for axis in axes), default=0.0)


def _drawn(traces: GraspTraces, task: Task, start: int) -> tuple[float, str]:
    """Return the share drawn with the front end in one stretch near the table, and how it strayed.

    Of all stretches the longest counts.
    """
    assert traces.front_pos is not None
    front = traces.front_pos[start:]
    near = np.concatenate([[False], front[:, 2] <= TRACE_HEIGHT, [False]])
    first, last = (np.flatnonzero(np.diff(near.astype(int)) == sign) for sign in (1, -1))
    best = (0.0, "")
    for i, j in zip(first.tolist(), last.tolist(), strict=True):
        path = front[i:j, :2] - front[i, :2]
        farthest = int(np.linalg.norm(path, axis=1).argmax())
        drawn = _along(path[: farthest + 1], _asked_way(task), task.rule.distance)
        best = max(best, drawn, key=lambda each: each[0])
    return best


def _hinge(traces: GraspTraces, rule: PassRule, start: int) -> tuple[float, Reason | None, str]:
    """Check that the hinge passed its angle in the action, not before, pressed as asked for."""
    assert traces.hinge is not None
    angle = np.rad2deg(traces.hinge)
    way = rule.angle_deg - angle[0]
    done = (angle - angle[0]) / way
    if done[start] >= 1:
        return 0.0, "missed", f"{rule.joint} was at {angle[start]:.1f} deg before the action"
    most = start + int(done[start:].argmax())
    if done[most] < 1:
        detail = f"{rule.joint} came to {angle[most]:.1f} of {rule.angle_deg:g} deg"
        return max(float(done[most]), 0.0), "missed", detail
    passed = start + int((done[start:] >= 1).argmax())
    for pressed, force in zip(rule.pressed, traces.pressed[passed].tolist(), strict=True):
        if force < LEAST_PRESS:
            fingers = " or ".join(pressed.fingers)
            return (
                force / LEAST_PRESS,
                "astray",
                f"{rule.joint} moved, but no {fingers} pressed {pressed.body}",
            )
    return 1.0, None, ""


def _slip(traces: GraspTraces, rule: PassRule) -> Array:
    """Displacement in the palm since the action began; on the table until the hold, (n,) [m]."""
    if rule.kind != "joint":
        return traces.slip(traces.first_acting)
    hold = min(traces.first_holding, len(traces.time) - 1)
    return np.concatenate([traces.way()[:hold], traces.slip(hold)[hold:]])


def _tilt(traces: GraspTraces, rule: PassRule) -> Array:
    """Rotation of the object since its first pose, less that of the palm in the lift, (n,) [rad].

    Before the lift the palm turns on its way to the object, which tilts nothing. An object that is
    worked where it stands is not tilted by the palm until the hold.
    """
    first = traces.first_holding if rule.kind == "joint" else traces.first_acting
    return traces.turn(0, min(first, len(traces.time) - 1))


def _longest_stretch(within: npt.NDArray[np.bool_], time: Array) -> float:
    """Longest time for which ``within`` stays true [s]."""
    longest, start = 0.0, None
    for now, held in zip(time.tolist(), within.tolist(), strict=True):
        if not held:
            start = None
            continue
        start = now if start is None else start
        longest = max(longest, now - start)
    return longest

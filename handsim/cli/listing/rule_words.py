"""What a task's rule asks for, as a sentence made from its fields."""

from collections.abc import Sequence
from math import atan2, degrees, hypot

from handsim.joints import Finger
from handsim.objects.object import Vec3
from handsim.tasks.rules import ASTRAY, ASTRAY_DEG, TRACE_HEIGHT
from handsim.tasks.task import PassRule, Task

_WAYS = (
    "away from the person", "to the left and away", "to the left", "to the left and back",
    "towards the person", "to the right and back", "to the right", "to the right and away",
)  # fmt: skip
"""Ways on the table, each 45 deg on from the last, counter-clockwise from +x."""


def rule_in_words(task: Task) -> str:
    """Return in one sentence what a run of a task must show.

    What every grasp has to show beside it is the same for all (`handsim.tasks.grip_rules`).
    """
    rule = task.rule
    limits = f"less than {_mm(rule.slip)} and tilting less than {rule.tilt_deg:g} deg"
    steady, held = f"slipping {limits} in the hand", f"held for {rule.hold:g} s"
    if rule.kind == "joint":
        return f"{_hinge(task)}{_pressed(rule)}, moving {limits} on the table; then it is {held}."
    if rule.kind == "slide":
        low = f"never more than {_mm(rule.lift)} above it"
        slides = f"It slides at least {_mm(rule.distance)} on the table {_way(task)}, {low}"
        return f"{slides}; it is {held}, {steady}."
    lifted = f"It is lifted by at least {_mm(rule.lift)}"
    if rule.kind == "trace":
        near = f"at least {_mm(rule.distance)} within {_mm(TRACE_HEIGHT)} of the table"
        return f"{lifted} and {held}, and its front end draws {near}, {_way(task)}, {steady}."
    if rule.kind == "turn":
        lifted += f", turned by at least {rule.angle_deg:g} deg{_turn(task)},"
    return f"{lifted} and {held}, {steady}."


def listed(words: Sequence[str], last: str = "and") -> str:
    """Return words with commas, the last two with a word between them."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def _mm(length: float) -> str:
    return f"{1000 * length:g} mm"


def _hinge(task: Task) -> str:
    rule, start = task.rule, dict(task.start_deg).get(task.rule.joint or "", 0.0)
    way = f"from {start:g} down to" if start > rule.angle_deg else "past"
    return f"Its {(rule.joint or '').replace('_', ' ')} goes {way} {rule.angle_deg:g} deg"


def _pressed(rule: PassRule) -> str:
    """Return which finger has to press what meanwhile."""
    said = [
        f"{_finger(each.fingers)} presses {'it' if each.body == rule.joint else 'the main body'}"
        for each in rule.pressed
    ]
    return f" while {listed(said)}" if said else ""


def _finger(fingers: Sequence[Finger]) -> str:
    """Return which finger, or which of several."""
    return f"the {listed(fingers, 'or')}{'' if fingers[-1] == 'thumb' else ' finger'}"


def _way(task: Task) -> str:
    """Return in words the way of the longest shift on the table, as the rule takes it."""
    x, y, _ = max((step.shift for step in task.steps), key=lambda each: hypot(*each[:2]))
    return f"{_compass(x, y)} (within {ASTRAY_DEG:g} deg and {_mm(ASTRAY)} of that way)"


def _turn(task: Task) -> str:
    """Return in words which way an object is turned: that of any turning step counts."""
    axes = dict.fromkeys(s.axis for s in task.steps if s.angle_deg and not s.flex)
    said = dict.fromkeys(_sense(axis) for axis in axes)
    return f" {listed(tuple(said), 'or')}" if said else ""


def _sense(axis: Vec3) -> str:
    """Return in words a turn about an axis in the world."""
    x, y, z = axis
    if abs(z) > hypot(x, y):
        return f"{'counter-clockwise' if z > 0 else 'clockwise'} seen from above"
    return f"with its top {_compass(y, -x)}"  # what is on top goes along axis x (0, 0, 1)


def _compass(x: float, y: float) -> str:
    return _WAYS[round(degrees(atan2(y, x)) / 45.0) % len(_WAYS)]

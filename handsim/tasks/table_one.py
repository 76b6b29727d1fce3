"""The 24 grasping tasks of the paper's Table I as data."""

from dataclasses import replace
from typing import Literal

import numpy as np

from handsim.errors import UnknownNameError
from handsim.joints import Finger
from handsim.objects.grasp import Grasp
from handsim.objects.object import Vec3
from handsim.tasks.task import PassRule, Pressed, Step, Task
from handsim.types import Side

__all__ = [
    "PHONE_TODAY_VIEW", "TASKS", "TASK_NAMES", "Grasp", "PassRule", "Side", "Step", "Task",
    "task_by_name",
]  # fmt: skip

DOWN: Vec3 = (0.0, 0.0, -1.0)
_COS30, _SIN30 = 0.75**0.5, 0.5
_FOREARM: Vec3 = (_COS30, _SIN30, 0.0)
"""A right forearm on a table points 30 deg to the left of straight ahead."""
_LEFTWARD: Vec3 = (-_SIN30, _COS30, 0.0)
"""Where the palm of that forearm faces when the thumb is up."""
_ACROSS: Vec3 = (0.0, -1.0, 0.0)
"""Away from the person, in the frame of an object that lies with its front to the left."""

_ALL: tuple[Finger, ...] = ("index", "middle", "ring", "little")
_TWO: tuple[Finger, ...] = ("index", "middle")
_THREE: tuple[Finger, ...] = ("index", "middle", "ring")

_LIFT = Step(0.8, shift=(0.0, 0.0, 0.12))
_MOVE = Step(0.8, shift=(-0.03, 0.10, 0.0))
_TO_MOUTH = Step(1.2, shift=(-0.10, 0.0, 0.12), axis=(0.0, -1.0, 0.0), angle_deg=45.0)
_SPIN = Step(1.0, axis=(0.0, 0.0, 1.0), angle_deg=60.0)
_CARRY = PassRule("carry")
_TILTED = PassRule("turn", angle_deg=30.0)
_SPUN = PassRule("turn", angle_deg=45.0)


_BRIEF = 1.0
"""What is worked where it stands, or slid or drawn with, is held for this time afterwards [s]."""
_RESTS = 30.0
"""What a hand that rests on the table, at a mouse or in writing, may press it with [N]."""


def _side(height: float, width: float) -> Grasp:
    return Grasp("side", (0.0, 0.0, height), _FOREARM, _LEFTWARD, width, _ALL)


def _top(height: float, width: float, fingers: tuple[Finger, ...] = _ALL) -> Grasp:
    return Grasp("top", (0.0, 0.0, height), _FOREARM, DOWN, width, fingers)


def _across(
    along: float, height: float, width: float, kind: Literal["top", "tripod"] = "top",
    fingers: tuple[Finger, ...] = _THREE,
) -> Grasp:  # fmt: skip
    """Grasp from above across a thing that lies with its front to the left."""
    return Grasp(kind, (along, 0.0, height), _ACROSS, DOWN, width, fingers)


def _click(button: str, finger: Finger) -> tuple[tuple[Step, ...], PassRule]:
    press = Step(0.3, flex=(finger,), angle_deg=12.0)
    release = Step(0.3, flex=(finger,), angle_deg=-12.0)
    rule = PassRule(
        "joint", lift=0.0, hold=_BRIEF, slip=0.01, tilt_deg=10.0, joint=button, angle_deg=1.0,
        pressed=(Pressed((finger,), button),), table_force=_RESTS,
    )  # fmt: skip
    return (press, release), rule


# The back of the hand slopes 15 deg down to the fingers, as the mouse does.
_MOUSE = Grasp(
    "rest", (0.0, 0.0, 0.016), (0.0, -1.0, 0.0), (-0.2588, 0.0, -0.9659), 0.060,
    ("ring", "little"), pointing=(1.0, 0.0, 0.0),
)  # fmt: skip
# From above and beside, so that the little finger's side stays clear of the table.
_HANDLE = Grasp(
    "handle", (0.064, 0.0, 0.058), (0.0, -1.0, 0.0), (-0.7071, 0.0, -0.7071), 0.010, _TWO
)
# The palm comes from opposite the handle.
_CUP_SIDE = Grasp("side", (0.0, 0.0, 0.042), _ACROSS, (1.0, 0.0, 0.0), 0.080, _ALL)
_CUP_TOP = Grasp("top", (0.0, 0.0, 0.066), _ACROSS, DOWN, 0.080, _ALL)

_WRITING = Grasp("tripod", (0.030, 0.0, 0.0045), (0.0, 1.0, 0.0), DOWN, 0.0104, _TWO)
_WRITE = (
    Step(0.6, shift=(0.0, 0.0, 0.06)),
    Step(0.8, axis=(1.0, 0.0, 0.0), angle_deg=45.0),
    Step(0.5, shift=(0.0, 0.0, -0.0362)),
    Step(1.0, shift=(0.0, -0.06, 0.0)),
)
"""Lift, point the tip down, set it on the paper 28 mm below the grip, draw a line.

The tip points to the right, where supination lowers it: a palm that faces down can hardly pronate
further."""


def _placed(task: Task, turn_deg: float) -> Task:
    """Return a task with its object, and what is done with it, turned about the vertical.

    The hand comes from the right shoulder, so that people lay what is before them a little turned.
    The turns are such that shoulder, elbow and wrist stay within what is comfortable.
    """
    cosine, sine = np.cos(np.deg2rad(turn_deg)), np.sin(np.deg2rad(turn_deg))

    def turned(vector: Vec3) -> Vec3:
        x, y, z = vector
        turned_x, turned_y = cosine * x - sine * y, sine * x + cosine * y
        return (round(float(turned_x), 6), round(float(turned_y), 6), round(z, 6))

    steps = tuple(
        replace(step, shift=turned(step.shift), axis=turned(step.axis)) for step in task.steps
    )
    return replace(task, steps=steps, yaw_deg=task.yaw_deg + turn_deg)


TASKS: tuple[Task, ...] = (
    Task(1, "tall-glass-drink", "tall-glass", _side(0.070, 0.064), "drink",
         (_LIFT, _TO_MOUTH), _TILTED),
    Task(2, "tall-glass-side-move", "tall-glass", _side(0.070, 0.064), "move",
         (_LIFT, _MOVE), _CARRY),
    Task(3, "tall-glass-top-move", "tall-glass", _top(0.125, 0.064), "move",
         (_LIFT, _MOVE), _CARRY),
    Task(4, "tall-glass-side-rotate", "tall-glass", _side(0.070, 0.064), "rotate",
         (_LIFT, _SPIN), _SPUN),
    _placed(Task(5, "mouse-slide", "mouse", _MOUSE, "slide",
                 (Step(1.0, shift=(0.06, 0.06, 0.0)),),
                 PassRule("slide", lift=0.01, hold=_BRIEF, distance=0.06, table_force=_RESTS)),
            45.0),
    _placed(Task(6, "mouse-left-click", "mouse", _MOUSE, "click",
                 *_click("left_button", "index")), 45.0),
    _placed(Task(7, "mouse-right-click", "mouse", _MOUSE, "click",
                 *_click("right_button", "middle")), 45.0),
    Task(8, "cup-drink", "cup", _HANDLE, "drink", (_LIFT, _TO_MOUTH), _TILTED, yaw_deg=-90.0),
    Task(9, "cup-side-move", "cup", _CUP_SIDE, "move", (_LIFT, _MOVE), _CARRY,
         yaw_deg=120.0),
    Task(10, "cup-top-move", "cup", _CUP_TOP, "move", (_LIFT, _MOVE), _CARRY,
         yaw_deg=120.0),
    Task(11, "cup-side-rotate", "cup", _CUP_SIDE, "rotate", (_LIFT, _SPIN), _SPUN,
         yaw_deg=120.0),
    _placed(Task(12, "hammer-use", "hammer", _across(0.095, 0.0115, 0.0203, "tripod", _TWO), "use",
                 (_LIFT, Step(0.8, axis=(1.0, 0.0, 0.0), angle_deg=40.0),
                  Step(0.5, axis=(1.0, 0.0, 0.0), angle_deg=-40.0)),
                 PassRule("turn", angle_deg=25.0), yaw_deg=90.0),
            50.0),
    Task(13, "ashtray-move", "ashtray", _top(0.018, 0.100), "move", (_LIFT, _MOVE), _CARRY),
    Task(14, "cube-raise", "cube", Grasp("top", (0.0, 0.0, 0.030), (1.0, 0.0, 0.0), DOWN, 0.055,
         _THREE), "raise", (_LIFT,), _CARRY, yaw_deg=30.0),
    _placed(Task(15, "pen-write", "pen", _WRITING, "write", _WRITE,
                 PassRule("trace", lift=0.05, hold=_BRIEF, distance=0.05, table_force=_RESTS),
                 yaw_deg=-90.0),
            57.0),
    _placed(Task(16, "pen-move", "pen", _across(0.0, 0.0045, 0.0104), "move",
                 (_LIFT, _MOVE), _CARRY,
                 yaw_deg=90.0),
            55.0),
    Task(17, "jar-move", "jar", _side(0.045, 0.072), "move", (_LIFT, _MOVE), _CARRY),
    _placed(Task(18, "jar-unscrew", "jar", _top(0.096, 0.069), "unscrew", (_SPIN,),
                 PassRule("joint", lift=0.0, hold=_BRIEF, joint="lid", angle_deg=40.0)),
            -46.0),
    _placed(Task(19, "screwdriver-operate", "screwdriver",
                 _across(-0.055, 0.016, 0.0283, fingers=_ALL),
                 "operate", (_LIFT, Step(1.0, axis=(0.0, 1.0, 0.0), angle_deg=60.0)),
                 PassRule("turn", angle_deg=45.0), yaw_deg=90.0),
            10.0),
    _placed(Task(20, "book-read", "book",
                 Grasp("edge", (0.048, 0.0, 0.100), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), 0.022, _ALL),
                 "read", (_LIFT, Step(1.0, axis=(0.0, 1.0, 0.0), angle_deg=25.0)),
                 PassRule("turn", angle_deg=20.0), yaw_deg=-90.0),
            -45.0),
    _placed(Task(21, "phone-view", "phone", _across(0.0, 0.012, 0.048), "view",
                 (_LIFT, Step(1.0, axis=(0.0, -1.0, 0.0), angle_deg=45.0)),
                 PassRule("turn", angle_deg=30.0), yaw_deg=90.0),
            28.0),
    _placed(Task(22, "scissors-move", "scissors",
                 Grasp("tripod", (-0.004, 0.0014, 0.006), _ACROSS, DOWN, 0.0158, _TWO),
                 "move", (_LIFT, _MOVE), _CARRY, yaw_deg=90.0),
            40.0),
    _placed(Task(23, "scissors-use", "scissors",
                 Grasp("loops", (-0.059, 0.019, 0.005), (-0.258, -0.966, 0.0), DOWN, 0.060, _TWO),
                 "use",
                 (Step(0.8, flex=("thumb", "index", "middle"), angle_deg=20.0),),
                 PassRule("joint", lift=0.0, hold=_BRIEF, joint="blade", angle_deg=10.0,
                          pressed=(Pressed(("thumb",), "blade"), Pressed(_TWO, "object"))),
                 yaw_deg=90.0, start_deg=(("blade", 30.0),)),
            35.0),
    _placed(Task(24, "stapler-use", "stapler", _across(0.030, 0.049, 0.027, fingers=_ALL), "staple",
                 (Step(0.6, shift=(0.0, 0.0, -0.02)),),
                 PassRule("joint", lift=0.0, hold=_BRIEF, slip=0.01, tilt_deg=10.0, joint="arm",
                          angle_deg=4.0), yaw_deg=90.0),
            10.0),
)  # fmt: skip
"""All 24 tasks in the order of Table I."""

PHONE_TODAY_VIEW = replace(
    TASKS[20],
    name="phone-today-view",
    object_name="phone-today",
    grasp=_across(0.0, 0.0039, 0.0716),
)
"""Task 21 with a phone half as thick; it is not in the table and is reported apart."""

TASK_NAMES: tuple[str, ...] = tuple(task.name for task in TASKS)


def task_by_name(name: str) -> Task:
    """Return a task of Table I, or the variant with today's phone.

    Raises
    ------
    UnknownNameError
        If there is none of that name; the nearest are offered.
    """
    for task in (*TASKS, PHONE_TODAY_VIEW):
        if task.name == name:
            return task
    raise UnknownNameError("task", name, TASK_NAMES, "handsim tasks")

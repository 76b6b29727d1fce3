"""Traces of runs that nothing was simulated for: a palm, an object, and how they press."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.joints import CONTACT_PARTS
from handsim.tasks.rules import GraspTraces
from handsim.tasks.task import Task

RATE = 100.0
LIFT_TIME, LIFT_DURATION, HEIGHT = 1.0, 1.0, 0.12
ACTION, HOLD = 100, 200
"""Rows at which action and hold begin."""
THUMB, INDEX, PALM = (CONTACT_PARTS.index(part) for part in ("thumb", "index", "palm"))


def pinching(n: int, thumb: float = 3.0) -> np.ndarray:
    """Forces (n, 6, 3) of a thumb and of three fingers that share what it presses."""
    press = np.zeros((n, len(CONTACT_PARTS), 3))
    press[:, THUMB, 1] = thumb
    press[:, INDEX : INDEX + 3, 1] = -thumb / 3.0
    return press


def pressing(traces: GraspTraces, press: np.ndarray) -> GraspTraces:
    """The traces with other forces, all of them of one contact a part."""
    return replace(traces, press=press, force=np.linalg.norm(press, axis=2))


def carried(hold: float = 3.2, height: float = HEIGHT, n_pressed: int = 0) -> GraspTraces:
    """A palm that rests, lifts an object by ``height``, and holds it, without any slip."""
    time = np.arange(0.0, LIFT_TIME + LIFT_DURATION + hold, 1 / RATE)
    up = height * np.clip((time - LIFT_TIME) / LIFT_DURATION, 0, 1)
    lift = np.outer(up, [0, 0, 1.0])
    still = np.tile([1.0, 0, 0, 0], (len(time), 1))
    press = pinching(len(time))
    return GraspTraces(
        time=time,
        object_pos=lift + [0.1, 0, 0.07],
        object_quat=still,
        palm_pos=lift + [0.0, 0.05, 0.08],
        palm_quat=still,
        press=press,
        force=np.linalg.norm(press, axis=2),
        penetration=np.full(len(time), 5e-4),
        table_force=np.zeros(len(time)),
        pressed=np.full((len(time), n_pressed), 1.0),
        need=1.0,
        action_start=LIFT_TIME,
        hold_start=LIFT_TIME + LIFT_DURATION,
        symmetry="z",
    )


def acting(traces: GraspTraces) -> np.ndarray:
    """How far the action has come, 0 to 1, (n,)."""
    return np.clip((traces.time - LIFT_TIME) / LIFT_DURATION, 0, 1)


def turned(traces: GraspTraces, axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """Quaternions of a turn that grows with the lift and stays."""
    angles = np.deg2rad(degrees) * acting(traces)
    return Rotation.from_rotvec(np.outer(angles, axis)).as_quat(scalar_first=True)


def asked(task: Task, off_deg: float = 0.0) -> np.ndarray:
    """Unit vector (3,) of the longest movement along the table that a task asks for, turned."""
    shift = max((np.array(step.shift) * [1, 1, 0] for step in task.steps), key=np.linalg.norm)
    return Rotation.from_euler("z", off_deg, degrees=True).apply(shift / np.linalg.norm(shift))


def moved(task: Task, distance: float, up: float = 0.0, off_deg: float = 0.0) -> GraspTraces:
    """Palm and object displaced together along the table in the action, where they are asked to."""
    traces = carried(height=0.0)
    shift = np.outer(acting(traces), distance * asked(task, off_deg) + [0, 0, up])
    return replace(traces, object_pos=traces.object_pos + shift, palm_pos=traces.palm_pos + shift)


def hinged(
    start_deg: float, end_deg: float, from_time: float = LIFT_TIME, n_pressed: int = 1
) -> GraspTraces:
    """An object that stands where it is while its hinge turns."""
    traces = carried(height=0.0, n_pressed=n_pressed)
    part = np.clip((traces.time - from_time) / 0.3, 0, 1)
    return replace(traces, hinge=np.deg2rad(start_deg + part * (end_deg - start_deg)))


def drawn(
    task: Task, distance: float, height: float = 0.001, lift: float = HEIGHT, off_deg: float = 0.0
) -> GraspTraces:
    """A carried object whose front end moves along the table in the hold."""
    traces = carried(height=lift)
    part = np.clip((traces.time - 2.0) / 1.0, 0, 1)
    front = np.outer(part, distance * asked(task, off_deg)) + [0, 0, height]
    front[traces.time < 2.0, 2] = 0.05
    return replace(traces, front_pos=front)


def at(rows: slice | int, value: float, n: int = 520) -> np.ndarray:
    """Zeros (n,) but for some rows."""
    values = np.zeros(n)
    values[rows] = value
    return values

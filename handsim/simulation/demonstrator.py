"""The demonstrator: scripted grasps with all 22 joints, as a person might make them.

A grasp is made of two postures, open and shut, that belong to its kind; the hand closes between
them to the object's width, and alignment puts the palm. The recordings that come out of it are
synthetic and are called so wherever they appear.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.hand.grasp_task import Task
from handsim.hand.model import HandModel, build_hand
from handsim.joints import JOINT_INDEX, N_JOINTS, clip_to_range
from handsim.simulation.alignment import align_palm, close_to_width, opposition
from handsim.simulation.closed_loop import Stage, simulate
from handsim.simulation.conditions import Conditions
from handsim.simulation.drivers import ScriptedDriver
from handsim.simulation.plan import GraspPlan, Pose, schedule_for
from handsim.simulation.rollout import Rollout

Array = npt.NDArray[np.float64]

_LONG_FINGERS = ("index", "middle", "ring", "little")


def posture(fingers: tuple[float, float, float] = (0, 0, 0), **others: float) -> Array:
    """Return a posture (22,) [rad] from angles in degrees.

    Parameters
    ----------
    fingers
        Flexion of MCP, PIP and DIP of the four long fingers [deg].
    **others
        Single joints by name [deg]; they override ``fingers``.
    """
    degrees = {
        f"{finger}_{part}": angle
        for finger in _LONG_FINGERS
        for part, angle in zip(("mcp", "pip", "dip"), fingers, strict=True)
    }
    q = np.zeros(N_JOINTS)
    for name, angle in (degrees | others).items():
        q[JOINT_INDEX[name]] = np.deg2rad(angle)
    return q


REST = posture(
    (15, 25, 12),
    thumb_rotation=25,
    thumb_abduction=20,
    thumb_mcp=12,
    thumb_ip=10,
    palm_arch=3,
    wrist_flexion=5,
)
"""A relaxed hand, from which every reach begins."""


@dataclass(frozen=True)
class Closing:
    """Open and shut postures between which a kind of grasp closes.

    Attributes
    ----------
    open, shut : (22,) [rad]
    beyond
        How much farther than to the object's width the fingers are sent, as a part of the way
        from open to shut: the object stops them, wherever it is exactly.
    sink
        How far the palm is brought beyond alignment along the approach [m], so that the fingers
        close behind the middle of what they wrap.
    squeeze
        Factor on the squeeze layer.
    """

    open: Array
    shut: Array
    beyond: float = 0.0
    sink: float = 0.0
    squeeze: float = 1.0


_EXTENDED = {"wrist_flexion": -20.0}
_FLEXED = {"wrist_flexion": 15.0}

CLOSINGS: dict[str, Closing] = {
    "side": Closing(
        open=posture((20, 20, 10), thumb_rotation=90, thumb_abduction=50, **_EXTENDED),
        shut=posture(
            (62, 68, 38),
            thumb_rotation=102,  # brings the thumb's pad to the height of the fingers' mean
            thumb_abduction=40,
            thumb_mcp=32,
            thumb_ip=32,
            palm_arch=8,
            **_EXTENDED,
        ),
        beyond=0.12,
        sink=0.02,
        squeeze=0.8,
    ),
    "top": Closing(
        open=posture((40, 15, 8), thumb_rotation=80, thumb_abduction=45, thumb_ip=5, **_FLEXED),
        shut=posture(
            (72, 28, 14),
            thumb_rotation=95,
            thumb_abduction=35,
            thumb_mcp=20,
            thumb_ip=22,
            palm_arch=6,
            **_FLEXED,
        ),
        beyond=0.08,
        sink=0.006,
    ),
}
"""By kind of grasp. The angles are choices, tried on the objects; the signs and sizes follow what
people show: an opposed thumb, MCP joints that lead in a grasp from above and PIP joints that lead
in a wrap."""

RETREAT = 0.16
"""Distance from which the palm comes [m]."""


def plan_for(task: Task, hand: HandModel) -> tuple[GraspPlan, Array]:
    """Return the scripted plan of a task and the posture of largest aperture, (22,) [rad].

    Parameters
    ----------
    task
        For the hand's own side.
    hand
        A hand by itself, of the size that is to grasp.

    Raises
    ------
    InputError
        If no postures are known for the task's kind of grasp.
    """
    closing = CLOSINGS.get(task.grasp.kind)
    if closing is None:
        raise InputError(
            f"task '{task.name}': grasps of kind '{task.grasp.kind}' are not demonstrated yet; "
            f"choose one of kind {' or '.join(CLOSINGS)}"
        )
    q_touch = close_to_width(hand, closing.open, closing.shut, task.grasp)
    palm = align_palm(opposition(hand, q_touch, task.grasp), task.grasp)
    approach = np.array(task.grasp.approach)
    palm = palm.moved(closing.sink * approach)
    q_goal = clip_to_range(q_touch + closing.beyond * (closing.shut - closing.open))
    plan = GraspPlan(palm, _retreat(task, palm), REST, q_goal, closing.squeeze)
    return plan, closing.open


def _retreat(task: Task, palm: Pose) -> Array:
    """Return where the palm comes from, (3,) [m] in the object frame.

    Straight against the approach, except for grasps from the side: there the hand comes from
    behind as well, so that the thumb does not knock the object over.
    """
    back = -np.array(task.grasp.approach)
    if task.grasp.kind == "side":
        back = back - palm.rotation.apply([1.0, 0.0, 0.0])
    return RETREAT * back / np.linalg.norm(back)


def demonstrate(task: Task, conditions: Conditions) -> Rollout:
    """Grasp by script."""
    stage = Stage.build(task, conditions)
    spec = build_hand(conditions.hand_length, conditions.hand_breadth, conditions.side)
    plan, q_open = plan_for(stage.task, HandModel.from_spec(spec))
    schedule = schedule_for(stage.task)
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, schedule.reach)
    return simulate(stage, plan, driver, schedule=schedule)

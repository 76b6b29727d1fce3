"""The demonstrator: scripted grasps with all 22 joints, as a person might make them.

A grasp is made of two postures, open and shut, that belong to its kind; the hand closes between
them to the object's width, and alignment puts the palm. Where that alone does not hold, a few
numbers found by search adjust it. The recordings that come out of it are synthetic and are called
so wherever they appear.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from handsim.hand.grasp_task import Side, Task
from handsim.hand.model import HandModel, build_hand
from handsim.joints import clip_to_range
from handsim.simulation.adjustment import Adjustment, adjustments
from handsim.simulation.alignment import align_palm, close_to_width, opposition
from handsim.simulation.closed_loop import Stage, simulate
from handsim.simulation.closings import REST, closing_for
from handsim.simulation.conditions import Conditions
from handsim.simulation.drivers import ScriptedDriver
from handsim.simulation.manner import USUAL, Manner, manner_of
from handsim.simulation.plan import GraspPlan, Pose, schedule_for
from handsim.simulation.rollout import Rollout

Array = npt.NDArray[np.float64]

RETREAT = 0.16
"""Distance from which the palm comes [m]."""


def plan_for(
    task: Task, hand: HandModel, adjustment: Adjustment | None = None, side: Side = "right"
) -> tuple[GraspPlan, Array]:
    """Return the scripted plan of a task and the posture of largest aperture, (22,) [rad].

    Parameters
    ----------
    task
        For the hand's own side.
    hand
        A hand by itself, of the size that is to grasp.
    adjustment
        What is changed of what the kind of grasp gives; by default what was found for the task.
    side
        The hand's side.
    """
    if adjustment is None:
        adjustment = adjustments().get(task.name, Adjustment())
    closing = adjustment.closing(closing_for(task.grasp))
    q_touch = close_to_width(hand, closing.open, closing.shut, task.grasp)
    palm = align_palm(opposition(hand, q_touch, task.grasp), task.grasp)
    palm = palm.moved(closing.sink * np.array(task.grasp.approach))
    palm = adjustment.palm(palm, side)
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


def demonstrate(task: Task, conditions: Conditions, manner: Manner | None = None) -> Rollout:
    """Grasp by script.

    Parameters
    ----------
    task
        That of a right hand; it is mirrored as the conditions say.
    conditions
        Of the run.
    manner
        Rest posture and timing; by default the usual ones in a nominal run, and in a perturbed
        one those of its seed.
    """
    if manner is None:
        manner = USUAL if conditions.nominal else manner_of(conditions.seed)
    size = (conditions.hand_length, conditions.hand_breadth, conditions.side)
    hand = HandModel.from_spec(build_hand(*size))
    return demonstrate_on(Stage.build(task, conditions), hand, manner=manner)


def demonstrate_on(
    stage: Stage,
    hand: HandModel,
    adjustment: Adjustment | None = None,
    *,
    manner: Manner = USUAL,
    brief: bool = False,
) -> Rollout:
    """Grasp by script on a stage that is built already.

    Parameters
    ----------
    stage
        Of the task.
    hand
        A hand by itself, of the stage's size and side.
    adjustment
        As in `plan_for`.
    manner
        Rest posture and timing.
    brief
        End the run once the object is lost.
    """
    plan, q_open = plan_for(stage.task, hand, adjustment, stage.conditions.side)
    plan = replace(plan, q_start=manner.rest)
    schedule = replace(schedule_for(stage.task), reach=manner.reach)
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, manner.reach, manner.opened)
    return simulate(stage, plan, driver, schedule=schedule, brief=brief)

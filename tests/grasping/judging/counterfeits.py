"""Hands that do not grasp: what no rule may take for a grasp.

Each goes where a scripted grasp goes, by the same arm. Only what the fingers do, or where the palm
is, is not what holds an object.
"""

from dataclasses import replace

import numpy as np

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.demonstrator import demonstrate_on, scripted_plan
from handsim.grasping.planning.preshapes import REST, posture
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import ScriptedDriver
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.model import HandModel
from handsim.tasks.task import Task
from handsim.types import Array

STIFF: dict[str, Array] = {
    "fist": posture((88, 105, 75), thumb_rotation=60, thumb_mcp=55, thumb_ip=60),
    "flat": posture((0, 0, 0), thumb_rotation=0, thumb_abduction=0),
    "open": posture((5, 5, 5), thumb_rotation=60, thumb_abduction=60),
    "relaxed": REST,
    "pointing": posture(
        (85, 100, 70), index_mcp=15, index_pip=5, index_dip=5,
        thumb_rotation=60, thumb_mcp=50, thumb_ip=50,
    ),
}  # fmt: skip
"""Postures that stay as they are, whatever they touch, by name."""
DEPTHS = (-0.03, 0.0, 0.03)
"""How far a stiff hand is lowered beyond the grasp [m]; negative is above it."""
ASIDE = 0.03
"""How far a hand that closes is beside the object [m]."""
AWAY = 0.15
"""How far above the object an arm passes that touches nothing [m]."""


def stiff(task: Task, hand: HandModel, name: str, depth: float) -> Rollout:
    """Run a hand of one posture along the path of the grasp, ``depth`` [m] beyond it."""
    plan, _ = scripted_plan(task, hand)
    q = STIFF[name].copy()
    moved = plan.palm.moved(depth * np.array(task.grasp.approach))
    plan = replace(plan, palm=moved, q_start=q, q_goal=q, squeeze=0.0, grip=1e-3)
    return _run(task, plan, q)


def aside(task: Task, hand: HandModel, angle: float) -> Rollout:
    """Run the scripted grasp with the palm `ASIDE` of its place, horizontally at an angle [rad].

    The hand closes as it would there, and feels nothing: one that feels closes on what it meets,
    and takes hold of many things from beside, which is a grasp.
    """
    shift = ASIDE * np.array([np.cos(angle), np.sin(angle), 0.0])
    scene = Scene.build(task, Conditions())
    plan, q_open = scripted_plan(task, hand)
    plan = replace(plan, palm=plan.palm.moved(shift), squeeze=0.0, grip=1e-3)
    schedule = schedule_for(task)
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, schedule.reach)
    return simulate(scene, plan, driver, schedule=schedule)


def arm_alone(task: Task, hand: HandModel) -> Rollout:
    """Run the scripted grasp high above the object."""
    plan, _ = scripted_plan(task, hand)
    return _run(task, replace(plan, palm=plan.palm.moved(np.array([0, 0, AWAY]))), plan.q_goal)


def genuine(task: Task, hand: HandModel) -> Rollout:
    """Run the scripted grasp itself."""
    return demonstrate_on(Scene.build(task, Conditions()), hand)


def _run(task: Task, plan: GraspPlan, q: Array) -> Rollout:
    schedule = schedule_for(task)
    driver = ScriptedDriver(plan.q_start, q, q, schedule.reach)
    return simulate(Scene.build(task, Conditions()), plan, driver, schedule=schedule)

"""Proposed grasps run with a learned controller: fitted to its subspace, then perturbed."""

from dataclasses import replace
from functools import partial

import numpy as np

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.demonstrator_offsets import DemonstratorOffsets
from handsim.grasping.planning.fingertip_fit import FingertipFit, fit_fingertips, pad_targets
from handsim.grasping.planning.planner import ARRIVALS, LEVERS, brief_cost, destination_box
from handsim.grasping.planning.search import robust_cost, shortened, tried_conditions
from handsim.grasping.planning.trials.scripted_trials import N_PERTURBED
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.objects.proposal_families import NARROW
from handsim.tasks.task import Task
from handsim.types import Array

N_STARTS = 6
"""Recorded destinations that each fit starts from, the nearest to the scripted posture."""
N_RUN = 2
"""Fits of each grasp that are run."""


def fit_and_run(
    controller: GraspController, task: Task, conditions: Conditions
) -> tuple[float, GraspPlan]:
    """Fit a scripted grasp to the subspace, run the best fits briefly, and return the best.

    Returns
    -------
    float, GraspPlan
        The cost of its nominal run, and the plan.
    """
    quick = shortened(task)
    scene = Scene.build(quick, conditions)
    hand = HandModel.from_spec(build_hand(conditions.hand))
    scripted, _ = scripted_plan(scene.task, hand, DemonstratorOffsets(), side=conditions.hand.side)
    targets = pad_targets(hand, scripted, scene.task.grasp)
    near = controller.subspace.transform(scripted.q_goal)
    records = sorted(
        controller.demonstrations, key=lambda each: float(np.linalg.norm(each.z_goal - near))
    )[:N_STARTS]
    box = destination_box(controller)
    lever = LEVERS[0] if task.grasp.width > NARROW else LEVERS[1]
    fits: list[tuple[FingertipFit, Array]] = [
        (fit_fingertips(hand, controller.subspace, targets, each.z_goal, box, lever), each.q_start)
        for each in records
    ]
    fits.sort(key=lambda each: each[0].error)
    plans = [
        replace(
            scripted,
            palm=fit.palm,
            q_start=clip_to_range(q_start),
            z_goal=fit.z,
            q_goal=clip_to_range(controller.subspace.inverse_transform(fit.z)),
            squeeze=fit.squeeze,
            arrive=arrive,
            transport=shipped_transport(conditions.hand.side),
        )
        for fit, q_start in fits[:N_RUN]
        for arrive in ARRIVALS
    ]
    costs = [brief_cost(controller, scene, plan) for plan in plans]
    best = int(np.argmin(costs))
    return costs[best], plans[best]


def plan_cost(
    controller: GraspController, task: Task, plan: GraspPlan, conditions: Conditions
) -> float:
    """Return the mean cost of brief runs of a plan, nominal and perturbed."""
    quick = shortened(task)
    tried = tried_conditions(conditions, N_PERTURBED)
    scenes = [Scene.build(quick, each) for each in tried]
    return robust_cost([partial(brief_cost, controller, scene, plan) for scene in scenes])

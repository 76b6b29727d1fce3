"""The demonstrator: scripted grasps with all 22 joints, as a person might make them.

Each kind of grasp has an open and a shut posture (`preshapes`). The hand closes between them to the
object's width, and its opposition is aligned with the object's (`opposition`). Where that alone
does not hold, offsets found by a search are added (`demonstrator_offsets`). Recordings of the
demonstrator are synthetic, and are called so wherever they appear.
"""

from dataclasses import replace

import numpy as np

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Pose, schedule_for
from handsim.grasping.planning.demonstrator_offsets import DemonstratorOffsets, demonstrator_offsets
from handsim.grasping.planning.expected_need import expected_need
from handsim.grasping.planning.opposition import align_palm, close_to_width, opposition
from handsim.grasping.planning.preshapes import REST, preshape_for
from handsim.grasping.planning.trial_variation import USUAL, TrialVariation, trial_variation
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import ScriptedDriver
from handsim.grasping.rollout.glove import recorded_reach
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.recordings.recording import Recording
from handsim.tasks.task import Task
from handsim.types import Array, Side

GRIP_MARGIN = 2.2
"""What a script presses on each side, relative to the need: people take 1.2 to 2 times of it
(Westling and Johansson 1984, Exp. Brain Res. 53:277-284), on skin they know."""
RETREAT = 0.16
"""Distance between the palm's first pose and its pose at the grasp [m]."""


def scripted_plan(
    task: Task, hand: HandModel, offsets: DemonstratorOffsets | None = None, side: Side = "right"
) -> tuple[GraspPlan, Array]:
    """Return the scripted plan of a task and the posture of largest aperture, (22,) [rad].

    Parameters
    ----------
    task
        For the hand's own side.
    hand
        A hand by itself, of the size that is to grasp.
    offsets
        Changes of the preshape and the palm; by default those stored for the task.
    side
        The hand's side.
    """
    if offsets is None:
        offsets = demonstrator_offsets().get(task.name, DemonstratorOffsets())
    preshape = offsets.preshape(preshape_for(task.grasp))
    q_touch = close_to_width(hand, preshape.open, preshape.shut, task.grasp)
    palm = align_palm(opposition(hand, q_touch, task.grasp), task.grasp)
    palm = palm.moved(preshape.sink * np.array(task.grasp.approach))
    palm = offsets.palm(palm, side)
    q_goal = clip_to_range(q_touch + preshape.beyond * (preshape.shut - preshape.open))
    grip = offsets.grip * (preshape.grip or GRIP_MARGIN * expected_need(task))
    plan = GraspPlan(palm, _retreat(task, palm), REST, q_goal, preshape.squeeze, grip)
    return plan, preshape.open


def _retreat(task: Task, palm: Pose) -> Array:
    """Return from where the palm approaches, (3,) [m], relative to its pose at the grasp.

    The direction is against the approach. In grasps from the side the hand comes from behind as
    well, so that the thumb does not knock the object over.
    """
    back = -np.array(task.grasp.approach)
    if task.grasp.kind == "side":
        back = back - palm.rotation.apply([1.0, 0.0, 0.0])
    return RETREAT * back / np.linalg.norm(back)


def demonstrate(
    task: Task,
    conditions: Conditions,
    variation: TrialVariation | None = None,
    offsets: DemonstratorOffsets | None = None,
) -> Rollout:
    """Grasp by script.

    Parameters
    ----------
    task
        That of a right hand; it is mirrored as the conditions say.
    conditions
        Of the run.
    variation
        Rest posture and timing; by default the usual ones in a nominal run, and in a perturbed
        one those of its seed.
    offsets
        As in `scripted_plan`.
    """
    if variation is None:
        variation = USUAL if conditions.nominal else trial_variation(conditions.seed)
    hand = HandModel.from_spec(build_hand(conditions.hand))
    return demonstrate_on(Scene.build(task, conditions), hand, offsets, variation=variation)


def demonstrate_on(
    scene: Scene,
    hand: HandModel,
    offsets: DemonstratorOffsets | None = None,
    *,
    variation: TrialVariation = USUAL,
    brief: bool = False,
) -> Rollout:
    """Grasp by script on a scene that is built already.

    Parameters
    ----------
    scene
        Of the task.
    hand
        A hand by itself, of the scene's size and side.
    offsets
        As in `scripted_plan`.
    variation
        Rest posture and timing.
    brief
        End the run once the object is lost.
    """
    plan, q_open = scripted_plan(scene.task, hand, offsets, scene.conditions.hand.side)
    plan = replace(plan, q_start=variation.rest)
    schedule = replace(schedule_for(scene.task), reach=variation.reach)
    driver = ScriptedDriver(
        plan.q_start, q_open, plan.q_goal, variation.reach, variation.peak_aperture_at
    )
    return simulate(scene, plan, driver, schedule=schedule, brief=brief)


def demonstrated_reach(task: Task, offsets: DemonstratorOffsets | None = None) -> Recording | None:
    """Return a demonstration as a glove records it for the built-in experiments.

    Rest posture, timing and noise come from the task's number in Table I. A demonstration that
    does not hold is none: None.
    """
    conditions, variation = Conditions(seed=task.number), trial_variation(task.number)
    run = demonstrate(task, conditions, variation, offsets)
    return recorded_reach(run, task) if run.outcome.success else None

"""One grasp in contact physics, in one call."""

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_folder, shipped_plans, usual_store
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import Task


def grasp(
    controller: GraspController,
    task: Task | str,
    conditions: Conditions | None = None,
    plan: GraspPlan | None = None,
) -> Rollout:
    """Grasp with a learned controller in contact physics, and judge the outcome.

    Parameters
    ----------
    controller
    task
        A task, or the name of one of Table I. It is written for a right hand, and mirrored here for
        a left one.
    conditions
        Hand, friction, mass and disturbances; by default nominal ones.
    plan
        Where palm and fingers go. By default the plan that is shipped for this controller, or
        one that is searched in physics, which takes about a minute.

    Returns
    -------
    Rollout
        ``outcome`` says whether the grasp holds, and if not, why.

    Raises
    ------
    UnknownNameError
        If there is no task of that name.
    InputError
        If the controller cannot lead to the destination of ``plan``.
    """
    chosen = task_by_name(task) if isinstance(task, str) else task
    asked = conditions or Conditions()
    if plan is not None:
        return run_plan(controller, Scene.build(chosen, asked), plan)
    shipped = shipped_plans(controller.digest, asked)
    usual = usual_store(shipped_folder(), controller.digest, asked)
    return ControllerGrasper(controller, hints=usual, shared=(shipped,))(chosen, asked)

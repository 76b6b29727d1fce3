"""How an own object is laid before a person: turned so that the arm comes to a grasp with ease.

Half of the grasps of a mug are out of reach as it happens to stand: the hand would have to come
from behind it, or backwards. People turn what is before them first. Grasps that no arm reaches
however the object is turned are not worth a run.
"""

from dataclasses import dataclass, replace

from handsim.arm.reaching_arm import ReachingArm
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.demonstrator_offsets import DemonstratorOffsets
from handsim.grasping.planning.search import NO_ARM, strain_of
from handsim.grasping.pool import in_order, processes
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.objects.object import GraspObject
from handsim.objects.proposals import MOST_TRIED, Proposal, propose_grasps, short_list
from handsim.tasks.lift import lift_task
from handsim.tasks.task import Task
from handsim.types import Progress

TURNS_DEG = tuple(45.0 * i for i in range(8))
"""Turns about the vertical that are tried, from where `lift_task` lays an object [deg]."""


@dataclass(frozen=True)
class LaidGrasp:
    """A proposal, and the task of raising the object by it as it is laid for it.

    The proposal is in the frame of the object as it is. The task is written for the right hand;
    that of a left hand is of the mirror image of both (`lift_task`).
    """

    proposal: Proposal
    task: Task


def lay_out(
    grasp_object: GraspObject,
    conditions: Conditions,
    most: int = MOST_TRIED,
    *,
    n_jobs: int = 1,
    progress: Progress | None = None,
) -> tuple[LaidGrasp, ...]:
    """Propose grasps of an object, lay it for each of them, and return a short list.

    Parameters
    ----------
    grasp_object
    conditions
        Of the runs; grasps are those of their hand, and their arm has to come to them.
    most
        Longest that the list may be.
    n_jobs
        Processes at once.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        If no grasp can be proposed, or the arm comes to none of them.
    """
    side = conditions.hand.side
    proposals = propose_grasps(grasp_object, side)
    tasks = [lift_task(grasp_object, each.grasp, side=side) for each in proposals]
    found = dict[Proposal, Task]()
    least = float("inf")
    laid = in_order(processes(n_jobs), laid_for, [(task, conditions) for task in tasks])
    for i, (proposal, (task, strain)) in enumerate(zip(proposals, laid, strict=True), start=1):
        least = min(least, strain)
        if strain <= NO_ARM:
            found[proposal] = task
        if progress is not None:
            progress(i / len(tasks))
    if not found:
        raise InputError(
            f"object '{grasp_object.name}': no arm comes to any of its {len(proposals)} grasps,"
            f" however it is turned (strain {least:.1f} at least, more than {NO_ARM:g}); set it"
            " down another way (--up), or let the hand fly (--base free)"
        )
    return tuple(LaidGrasp(each, found[each]) for each in short_list(tuple(found), most))


def laid_for(task: Task, conditions: Conditions) -> tuple[Task, float]:
    """Turn the object of a task about the vertical so that the arm is strained the least.

    Parameters
    ----------
    task
        For the right hand, as `lift_task` gives it: what is done with the object is the same
        however it is turned.
    conditions
        Of the run.

    Returns
    -------
    Task, float
        With another ``yaw_deg``; and the strain of the arm in its scripted grasp
        (`search.strain_of`). Hands on a free base find the object as it is, without strain.
    """
    if conditions.base == "free":
        return task, 0.0
    size, arm = conditions.hand, ReachingArm(conditions.hand)
    hand = HandModel.from_spec(build_hand(size))
    plan, _ = scripted_plan(task.for_side(size.side), hand, DemonstratorOffsets(), size.side)
    turned = [replace(task, yaw_deg=task.yaw_deg + turn) for turn in TURNS_DEG]
    strains = [strain_of(plan, each.for_side(size.side), arm) for each in turned]
    least = strains.index(min(strains))
    return turned[least], strains[least]

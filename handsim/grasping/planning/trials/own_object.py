"""A grasp of an object that is in no table: proposals are tried in physics, the best is planned.

For each grasp the object is laid so that the arm comes to it with ease; what no arm comes to is
passed over. The grasps of a short list are first run by script, once and briefly. What holds is
confirmed in perturbed runs. For a learned controller the most promising of them are then fitted to
its subspace and run briefly too, and the best few are planned in full until one holds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator_offsets import DemonstratorOffsets
from handsim.grasping.planning.grasper import ATTEMPTS, ControllerGrasper, Grasper
from handsim.grasping.planning.plan_key import key_for, planned_for
from handsim.grasping.planning.plan_store import StoredPlan
from handsim.grasping.planning.planner import plan_grasp, run_plan
from handsim.grasping.planning.trials.controller_trials import fit_and_run, plan_cost
from handsim.grasping.planning.trials.laying import lay_out
from handsim.grasping.planning.trials.scripted_trials import (
    GENERATIONS,
    N_PERTURBED,
    ScriptedGrasper,
    TriedGrasp,
    script_cost,
    search_offsets,
    try_by_script,
)
from handsim.grasping.pool import in_order, processes
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.learning.controller import GraspController
from handsim.objects.object import GraspObject
from handsim.objects.proposals import MOST_TRIED, Proposal
from handsim.tasks.task import Task
from handsim.types import Progress

N_COMPARED = 4
"""Grasps that are compared in perturbed runs."""
STEADY = -0.2
"""Mean cost of a grasp that needs no search: slip and tilt are well below their limits."""
N_SEARCHED = 2
"""Scripted grasps that are searched around where none is steady."""
N_FITTED = 10
"""Grasps that are fitted to the subspace of a controller."""
N_PLANNED = 2
"""Grasps that are planned in full where no fit is steady, one after the other."""


@dataclass(frozen=True)
class OwnGrasp:
    """What was chosen for an own object.

    Attributes
    ----------
    task
        Raising it by the grasp that was chosen, laid for it; as all tasks for the right hand
        (`lift_task`).
    grasper
        Grasps it so, under any conditions.
    proposal
        The grasp, for the hand that grasps, in the frame of the object as it is.
    n_tried, n_held
        Grasps tried by script, and how many of these held.
    held
        Whether the grasp chosen holds, the task's own rule applied.
    """

    task: Task
    grasper: Grasper
    proposal: Proposal
    n_tried: int
    n_held: int
    held: bool


def grasp_by_script(
    grasp_object: GraspObject,
    conditions: Conditions,
    *,
    n_jobs: int = 1,
    progress: Progress | None = None,
) -> OwnGrasp:
    """Choose a scripted grasp of an own object.

    Parameters
    ----------
    grasp_object
    conditions
        Only the hand and what carries it count of them.
    n_jobs
        Processes at once.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        If no grasp can be proposed, or the arm comes to none.
    """
    usual = planned_for(conditions)
    laid = lay_out(
        grasp_object, usual, MOST_TRIED, n_jobs=n_jobs, progress=_part(progress, 0.0, 0.1)
    )
    tried = try_by_script(laid, usual, n_jobs=n_jobs, progress=_part(progress, 0.1, 0.4))
    ranked = sorted(tried, key=lambda each: each.cost)
    pool = processes(n_jobs)
    compared = [each for each in ranked[:N_COMPARED] if each.held]
    costs = in_order(pool, script_cost, [(each.task, usual, N_PERTURBED) for each in compared])
    scored = [
        (cost, each, DemonstratorOffsets()) for cost, each in zip(costs, compared, strict=True)
    ]
    _tell(progress, 0.6)
    if not any(cost < STEADY for cost, _, _ in scored):
        most = _unlike(ranked, N_SEARCHED)
        found = in_order(
            pool, search_offsets, [(each.task, usual, i) for i, each in enumerate(most)]
        )
        for each, (cost, offsets) in zip(most, found, strict=True):
            scored.append((cost, each, offsets))
            _tell(progress, 0.6 + 0.4 * len(scored) / (N_COMPARED + N_SEARCHED))
    scored.sort(key=lambda each: each[0])
    chosen: OwnGrasp | None = None
    for _, each, offsets in scored:
        grasper = ScriptedGrasper(offsets)
        held = grasper(each.task, usual).outcome.success
        if chosen is None or held:
            chosen = OwnGrasp(each.task, grasper, each.proposal, len(tried), _n_held(tried), held)
        if held:
            break
    _tell(progress, 1.0)
    assert chosen is not None
    return chosen


def grasp_by_controller(
    grasper: ControllerGrasper,
    grasp_object: GraspObject,
    conditions: Conditions,
    *,
    n_jobs: int = 1,
    progress: Progress | None = None,
) -> OwnGrasp:
    """Choose and plan a grasp of an own object with a learned controller.

    Parameters
    ----------
    grasper
        Keeps the plan, and is returned ready to grasp.
    grasp_object, conditions, n_jobs, progress
        As in `grasp_by_script`.

    Raises
    ------
    InputError
        If no grasp can be proposed, the arm comes to none, or the grasper replays recorded
        destinations.
    """
    if grasper.mode == "replay":
        raise InputError("an own object has no recorded destination; plan one (--plan)")
    usual = planned_for(conditions)
    laid = lay_out(
        grasp_object, usual, MOST_TRIED, n_jobs=n_jobs, progress=_part(progress, 0.0, 0.05)
    )
    for each in laid:
        if isinstance(grasper.look_up(each.task, usual), GraspPlan):  # planned by an earlier call
            return OwnGrasp(each.task, grasper, each.proposal, 0, 0, held=True)
    tried = try_by_script(laid, usual, n_jobs=n_jobs, progress=_part(progress, 0.05, 0.25))
    fitted = _fitted(grasper.controller, tried, usual, n_jobs, _part(progress, 0.25, 0.6))
    best: tuple[TriedGrasp, GraspPlan, bool] | None = None
    for cost, each, plan in fitted[:N_COMPARED]:
        if cost < STEADY and _holds(grasper.controller, each.task, plan, usual):
            best = each, plan, True
            break
    for i, (_, each, known) in enumerate([] if best else fitted[:N_PLANNED], start=1):
        plan, run = plan_grasp(grasper.controller, each.task, usual, known, generations=GENERATIONS)
        if best is None or run.outcome.success:
            best = each, plan, run.outcome.success
        _tell(progress, 0.6 + 0.4 * i / N_PLANNED)
        if run.outcome.success:
            break
    assert best is not None
    each, plan, held = best
    grasper.keep(each.task, StoredPlan(plan, held, key_for(each.task, usual), ATTEMPTS))
    return OwnGrasp(each.task, grasper, each.proposal, len(tried), _n_held(tried), held)


def _fitted(
    controller: GraspController,
    tried: Sequence[TriedGrasp],
    conditions: Conditions,
    n_jobs: int,
    progress: Progress | None,
) -> list[tuple[float, TriedGrasp, GraspPlan]]:
    """Return fits of the best grasps of every kind with their costs, the best first.

    The cost of the first few is that of perturbed runs as well.
    """
    ranked = sorted(tried, key=lambda each: each.cost)
    unlike = [each for each in _unlike(ranked, N_FITTED) if each.held]
    chosen = [*unlike, *(each for each in ranked if each not in unlike)][:N_FITTED]
    pool, fitted = processes(n_jobs), list[tuple[float, TriedGrasp, GraspPlan]]()
    found = in_order(pool, fit_and_run, [(controller, each.task, conditions) for each in chosen])
    for each, (cost, plan) in zip(chosen, found, strict=True):
        fitted.append((cost, each, plan))
        _tell(progress, 0.8 * len(fitted) / len(chosen))
    fitted.sort(key=lambda each: each[0])
    first, rest = fitted[:N_COMPARED], fitted[N_COMPARED:]
    arguments = [(controller, each.task, plan, conditions) for _, each, plan in first]
    costs = in_order(pool, plan_cost, arguments)
    compared = [(cost, each, plan) for cost, (_, each, plan) in zip(costs, first, strict=True)]
    _tell(progress, 1.0)
    return [*sorted(compared, key=lambda each: each[0]), *rest]


def _holds(
    controller: GraspController, task: Task, plan: GraspPlan, conditions: Conditions
) -> bool:
    """Return whether a plan holds by the task's own rule."""
    return run_plan(controller, Scene.build(task, conditions), plan).outcome.success


def _unlike(ranked: Sequence[TriedGrasp], n: int) -> list[TriedGrasp]:
    """Return the first of each kind and number of fingers, up to ``n``."""
    first: dict[tuple[str, int, bool], TriedGrasp] = {}
    for each in ranked:
        first.setdefault(each.proposal.family, each)
    return list(first.values())[:n]


def _n_held(tried: Sequence[TriedGrasp]) -> int:
    return sum(each.held for each in tried)


def _tell(progress: Progress | None, fraction: float) -> None:
    if progress is not None:
        progress(fraction)


def _part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """Return a progress that fills a part of another."""
    if progress is None:
        return None
    return lambda fraction: progress(start + (end - start) * fraction)

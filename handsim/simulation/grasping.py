"""What grasps, and under which conditions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from handsim.errors import InputError
from handsim.hand.grasp_task import Task
from handsim.hand.model import HandModel, build_hand
from handsim.learning.controller import GraspController
from handsim.motion.recording import RecordingSet
from handsim.simulation.closed_loop import Stage
from handsim.simulation.conditions import Conditions, perturb
from handsim.simulation.plan import GraspPlan
from handsim.simulation.plan_store import PlanStore
from handsim.simulation.planner import plan_grasp, replayed_plan, run_plan
from handsim.simulation.pool import in_order, processes
from handsim.simulation.rollout import Rollout

Grasper = Callable[[Task, Conditions], Rollout]
"""Grasps a task under the given conditions."""
Mode = Literal["plan", "replay"]


def trial_conditions(conditions: Conditions, n_trials: int) -> list[Conditions]:
    """Return nominal conditions and those of ``n_trials`` perturbed runs.

    The perturbed runs have the seeds that follow the nominal one's.
    """
    seeds = range(conditions.seed + 1, conditions.seed + 1 + n_trials)
    return [conditions, *(perturb(conditions, seed) for seed in seeds)]


@dataclass(frozen=True)
class ControllerGrasper:
    """Grasps with a learned controller, by plan or by replaying recorded destinations.

    Attributes
    ----------
    controller
        The learned controller.
    mode
        ``plan`` plans the destination in the subspace, ``replay`` takes the recorded one.
    store
        Where plans are kept, or None to plan every time.
    hints
        Plans of other controllers to begin with.
    """

    controller: GraspController
    mode: Mode = "plan"
    store: PlanStore | None = None
    hints: tuple[PlanStore, ...] = ()

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp ``task``; what has to be planned first is planned for nominal conditions."""
        stage = Stage.build(task, conditions)
        plan = self.plan_for(task, stage)
        return run_plan(self.controller, stage, plan)

    def plan_for(self, task: Task, stage: Stage) -> GraspPlan:
        """Return the stored plan of a task, or make and store it."""
        conditions = stage.conditions
        if self.mode == "replay":
            size = (conditions.hand_length, conditions.hand_breadth, conditions.side)
            return replayed_plan(self.controller, stage, HandModel.from_spec(build_hand(*size)))
        plans = self.store.read() if self.store else {}
        if task.name in plans:
            return plans[task.name]
        _, plan, held = self._planned(task, conditions)
        if self.store is None:
            return plan
        self.store.add(task.name, plan, held)
        return self.store.read()[task.name]  # in degrees there: the last bit may be another

    def prepare(self, tasks: Sequence[Task], conditions: Conditions, n_jobs: int) -> None:
        """Plan and store what is not known yet, several tasks at a time."""
        if self.mode == "replay" or self.store is None:
            return
        known = self.store.read()
        unknown = [task for task in tasks if task.name not in known]
        arguments = [(task, conditions) for task in unknown]
        for name, plan, held in in_order(processes(n_jobs), self._planned, arguments):
            self.store.add(name, plan, held)

    def _planned(self, task: Task, conditions: Conditions) -> tuple[str, GraspPlan, bool]:
        """Plan for nominal conditions: task, plan and whether it held."""
        nominal = Conditions(
            hand_length=conditions.hand_length,
            hand_breadth=conditions.hand_breadth,
            side=conditions.side,
        )
        plan, run = plan_grasp(self.controller, task, nominal, self.hint(task))
        return task.name, plan, run.outcome.success

    def hint(self, task: Task) -> GraspPlan | None:
        """Return a plan of another controller for a task, or None."""
        known = (store.read().get(task.name) for store in self.hints)
        return next((plan for plan in known if plan is not None), None)


def without_object(recordings: RecordingSet, name: str) -> RecordingSet:
    """Return the recordings of all other objects, to learn from without having seen it.

    Raises
    ------
    InputError
        If none are left.
    """
    kept = tuple(r for r in recordings if r.object != name)
    if not kept:
        raise InputError(f"no recordings are left without object '{name}'; add some of others")
    return RecordingSet(kept)

"""What grasps, and under which conditions."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from handsim.errors import FileError, InputError
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.plan_key import PlanKey, key_for, planned_for
from handsim.grasping.planning.plan_store import PlanStore, StoredPlan
from handsim.grasping.planning.planner import SEEDS, plan_grasp, replayed_plan, run_plan
from handsim.grasping.pool import in_order, processes
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import Scene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.recordings.folder import RecordingSet
from handsim.tasks.task import Task

Grasper = Callable[[Task, Conditions], Rollout]
"""Grasps a task under the given conditions."""
Mode = Literal["plan", "replay"]
Note = Callable[[str], None]
"""Called with a line for people."""

ATTEMPTS = 2
"""Searches made for a plan before it is taken that none holds. All are made at once, so that the
same command gives the same answer each time; who raises this has what does not hold searched again.
"""


def trial_conditions(conditions: Conditions, n_trials: int) -> list[Conditions]:
    """Return nominal conditions and those of ``n_trials`` perturbed runs.

    The perturbed runs have the seeds that follow the nominal one's.
    """
    seeds = range(conditions.seed + 1, conditions.seed + 1 + n_trials)
    return [conditions, *(perturb(conditions, seed) for seed in seeds)]


@dataclass(frozen=True)
class Wanted:
    """A plan that has to be searched.

    Attributes
    ----------
    task, conditions
        What to plan for.
    start
        A plan to begin with, or None.
    attempts
        Searches that were made already and found none that holds.
    why
        What is the matter with the plan that is there; empty where there is none.
    """

    task: Task
    conditions: Conditions
    start: GraspPlan | None = None
    attempts: int = 0
    why: str = ""


def search_plan(controller: GraspController, wanted: Wanted) -> StoredPlan:
    """Search until a plan holds or `ATTEMPTS` are made, each with seeds of its own."""
    task, conditions = wanted.task, wanted.conditions
    attempts, plan, held = wanted.attempts, wanted.start, False
    while not held and attempts < ATTEMPTS:
        plan, run = plan_grasp(controller, task, conditions, plan, seed=attempts * SEEDS)
        attempts, held = attempts + 1, run.outcome.success
    assert plan is not None
    return StoredPlan(plan, held, key_for(task, conditions), attempts)


@dataclass(frozen=True)
class ControllerGrasper:
    """Grasps with a learned controller, by plan or by replaying recorded destinations.

    A plan is taken as it is if it was made for the very task, object, hand, schedule and physics
    (`PlanKey`), and holds or was searched for often enough (`ATTEMPTS`). Any other is where a
    search begins.

    Attributes
    ----------
    controller
        The learned controller.
    mode
        ``plan`` plans the destination in the subspace, ``replay`` takes the recorded one.
    store
        Where plans are kept, or None to keep them no longer than the grasper.
    hints
        Plans of other controllers to begin with.
    shared
        More plans of this very controller, which are only read.
    note
        Told which plans are made again and why, and which could not be kept.
    made
        Plans made here, by task: they serve even where the store cannot be written.
    """

    controller: GraspController
    mode: Mode = "plan"
    store: PlanStore | None = None
    hints: tuple[PlanStore, ...] = ()
    shared: tuple[PlanStore, ...] = ()
    note: Note | None = None
    made: dict[str, StoredPlan] = field(default_factory=dict, repr=False, compare=False)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp ``task``; what has to be planned first is planned for nominal conditions."""
        scene = Scene.build(task, conditions)
        plan = self.plan_for(task, scene)
        return run_plan(self.controller, scene, plan)

    def plan_for(self, task: Task, scene: Scene) -> GraspPlan:
        """Return the stored plan of a task, or make and store it."""
        conditions = scene.conditions
        if self.mode == "replay":
            hand = HandModel.from_spec(build_hand(conditions.hand))
            return replayed_plan(self.controller, scene, hand)
        found = self.look_up(task, conditions, scene)
        if isinstance(found, GraspPlan):
            return found
        self.tell_again(found)
        return self.keep(task, search_plan(self.controller, found))

    def prepare(self, tasks: Sequence[Task], conditions: Conditions, n_jobs: int) -> None:
        """Plan and store what is not known yet, several tasks at a time."""
        if self.mode == "replay":
            return
        found = (self.look_up(task, conditions) for task in tasks)
        wanted = [each for each in found if isinstance(each, Wanted)]
        for each in wanted:
            self.tell_again(each)
        arguments = [(self.controller, each) for each in wanted]
        searched = in_order(processes(n_jobs), search_plan, arguments)
        for each, stored in zip(wanted, searched, strict=True):
            self.keep(each.task, stored)

    def look_up(
        self, task: Task, conditions: Conditions, scene: Scene | None = None
    ) -> GraspPlan | Wanted:
        """Return the plan of a task that fits the hand of the conditions, or what to search.

        Parameters
        ----------
        task
            For a right hand.
        conditions
        scene
            Of the task under these conditions, if it is built already.
        """
        entries = list(self._entries(task.name))
        usual = planned_for(conditions)
        if not entries:
            return Wanted(task, usual, self._hint(task))
        key = key_for(task, conditions, scene)
        fitting = [each for each in entries if each.key == key]
        held = [each for each in fitting if each.held]
        final = [each for each in fitting if each.attempts >= ATTEMPTS]
        for each in (*held, *final):
            return each.plan
        start = (fitting or entries)[0]
        attempts = start.attempts if fitting else 0
        return Wanted(task, usual, start.plan, attempts, _why_not(start, key))

    def known(self, tasks: Iterable[Task], conditions: Conditions) -> dict[str, GraspPlan]:
        """Return the plans that fit, by task; nothing is planned."""
        plans = {}
        for task in tasks:
            found = self.look_up(task, conditions)
            if isinstance(found, GraspPlan):
                plans[task.name] = found
            elif found.why:
                self._tell(f"plan of {task.name} {found.why}: left out")
        return plans

    def read(self) -> dict[str, GraspPlan]:
        """Return all plans by task, those included that do not hold or fit any more."""
        stores = (*reversed(self.shared), *([self.store] if self.store else []))
        plans = {name: plan for store in stores for name, plan in store.read().items()}
        return plans | {name: each.plan for name, each in self.made.items()}

    def keep(self, task: Task, stored: StoredPlan) -> GraspPlan:
        """Keep a plan, in memory alone where the store cannot be written, and return it."""
        self.made[task.name] = stored
        if self.store is not None:
            try:
                self.store.add(task.name, stored)
            except (FileError, OSError) as error:
                self._tell(f"plan of {task.name} is used, but could not be kept: {error}")
        return stored.plan

    def tell_again(self, wanted: Wanted) -> None:
        """Say of a plan that is there why it is not taken."""
        if wanted.why:
            self._tell(f"plan of {wanted.task.name} {wanted.why}: planned again")

    def _entries(self, task: str) -> Iterator[StoredPlan]:
        """Yield what is known of a task, the latest first."""
        if task in self.made:
            yield self.made[task]
        for store in (*([self.store] if self.store else []), *self.shared):
            stored = store.entries().get(task)
            if stored is not None:
                yield stored

    def _hint(self, task: Task) -> GraspPlan | None:
        """Return a plan of another controller for a task, or None."""
        known = (store.read().get(task.name) for store in self.hints)
        plan = next((plan for plan in known if plan is not None), None)
        return plan and replace(plan, z_goal=None)  # which is a point of another subspace

    def _tell(self, line: str) -> None:
        if self.note is not None:
            self.note(line)


def _why_not(stored: StoredPlan, key: PlanKey) -> str:
    """Say why a plan is not taken as it is."""
    if stored.key is None:
        return "does not say what it was made for"
    parts = stored.key.differs_in(key)
    if parts:
        return f"is of another {' and another '.join(parts)}"
    return f"did not hold after {stored.attempts} of {ATTEMPTS} searches"


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

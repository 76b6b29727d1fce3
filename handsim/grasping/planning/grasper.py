"""Graspers that use a learned controller, and where their plans come from."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from typing import Literal

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.plan_key import PlanKey, key_for, planned_for
from handsim.grasping.planning.plan_store import Note, PlanStore, StoredPlan, counted
from handsim.grasping.planning.planner import SEEDS, plan_grasp, run_plan
from handsim.grasping.pool import Pool, one_by_one, processes
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.certification import covered
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.learning.transport.transport import Transport
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task
from handsim.types import Progress

Grasper = Callable[[Task, Conditions], Rollout]
"""Grasps a task under the given conditions."""
Mode = Literal["plan", "replay"]
Waiting = Callable[[str], AbstractContextManager[Progress | None]]
"""Called with what takes long: a context whose value is called with the fraction done, or None."""

ATTEMPTS = 2
"""Searches for a plan that holds before one that does not is kept and used.

All are made at once, so that the same command gives the same result each time. After this number is
raised, plans that do not hold are searched again."""


@contextmanager
def nobody_waits(label: str) -> Generator[None, None, None]:
    """Say nothing of how far work is."""
    yield


@dataclass(frozen=True)
class Wanted:
    """A plan that has to be searched.

    Attributes
    ----------
    task, conditions
        What to plan for.
    start
        A plan with which the search begins, or None.
    others
        Plans of other controllers or hands, near which it begins where there is no ``start``.
    attempts
        Searches already made that found no plan that holds.
    why
        Why the stored plan is not used; empty where none is stored.
    """

    task: Task
    conditions: Conditions
    start: GraspPlan | None = None
    attempts: int = 0
    why: str = ""
    others: tuple[StoredPlan, ...] = ()


def replayed_plan(controller: GraspController, scene: Scene, hand: HandModel) -> GraspPlan:
    """Return a plan with the recorded destination and the palm pose of the scripted plan."""
    scripted, _ = scripted_plan(scene.task, hand, side=scene.conditions.hand.side)
    recorded = controller.demonstration(scene.task.name)
    return replace(scripted, q_goal=recorded.q_goal)


def search_plan(
    controller: GraspController, wanted: Wanted, progress: Progress | None = None
) -> StoredPlan:
    """Search until a plan holds or `ATTEMPTS` searches are made, each with seeds of its own.

    What one search finds is where the next begins, beside the plans of other hands. ``progress`` is
    called with the fraction done, as far as it is known: that of this search and those before it.
    """
    task, conditions, hand = wanted.task, wanted.conditions, counted(wanted.conditions.hand)
    attempts, plan, others, held = wanted.attempts, wanted.start, wanted.others, False
    while not held and attempts < ATTEMPTS:
        seed, known = attempts * SEEDS, None if others else plan
        tell = _share(progress, attempts - wanted.attempts, attempts - wanted.attempts + 1)
        plan, run = plan_grasp(
            controller, task, conditions, known, others=others, seed=seed, progress=tell
        )
        attempts, held = attempts + 1, run.outcome.success
        if others:
            others = (StoredPlan(plan, held, hand=hand), *others)
    assert plan is not None
    return StoredPlan(plan, held, key_for(task, conditions), attempts, hand)


@dataclass(frozen=True)
class ControllerGrasper:
    """Grasps with a learned controller, by plan or by replaying recorded destinations.

    A stored plan is used if it was made for the same task, object, hand, schedule and physics
    (`PlanKey`), and either holds or was searched `ATTEMPTS` times. Any other stored plan is the
    start of a search. Where there is none of this controller and hand, the search begins near
    that of another controller for this hand, or else near the plans of other hands, for the task
    and then for others with its object.

    Attributes
    ----------
    controller
        The learned controller.
    mode
        ``plan`` plans the destination in the subspace, ``replay`` takes the recorded one.
    store
        Where plans are kept, or None to keep them in memory alone.
    hints
        Plans of other controllers or hands, with which searches begin.
    shared
        Further plans of this controller, which are only read.
    note
        Called with a line for each plan that is made again, with the reason, and for each that
        could not be stored.
    planning
        Called with a label while a plan is searched: a context whose value is called with the
        fraction done.
    transport
        How the palm comes to things; None: along straight lines. Plans are searched with the one
        that is shipped.
    made
        Plans made by this grasper, by task. They are used even where the store cannot be written.
    proven
        Whether every start is proven to reach the destination of the latest run of each task.
    """

    controller: GraspController
    mode: Mode = "plan"
    store: PlanStore | None = None
    hints: tuple[PlanStore, ...] = ()
    shared: tuple[PlanStore, ...] = ()
    note: Note | None = None
    planning: Waiting = nobody_waits
    transport: Transport | None = field(default_factory=shipped_transport)
    made: dict[str, StoredPlan] = field(
        default_factory=dict[str, StoredPlan], repr=False, compare=False
    )
    proven: dict[str, bool | None] = field(
        default_factory=dict[str, bool | None], repr=False, compare=False
    )

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp ``task``; a plan that is missing is made first, for nominal conditions."""
        scene = Scene.build(task, conditions)
        plan = self.plan_for(task, scene)
        goal = plan.goal_in(self.controller.subspace)
        self.proven[task.name] = covered(self.controller, goal[None])
        return run_plan(self.controller, scene, plan)

    def plan_for(self, task: Task, scene: Scene) -> GraspPlan:
        """Return the stored plan of a task, or make and store it."""
        conditions = scene.conditions
        if self.mode == "replay":
            hand = HandModel.from_spec(build_hand(conditions.hand))
            return self._carried(replayed_plan(self.controller, scene, hand), conditions)
        found = self.look_up(task, conditions, scene)
        if isinstance(found, GraspPlan):
            return found
        self._note_again(found)
        with self.planning(f"planning {task.name}") as progress:
            stored = search_plan(self.controller, found, progress)
        return self._carried(self.keep(task, stored), conditions)

    def prepare(self, tasks: Sequence[Task], conditions: Conditions, n_jobs: int) -> None:
        """Make and store the plans that are missing, in ``n_jobs`` processes."""
        if self.mode == "replay":
            return
        _, missing = self.look_up_all(tasks, conditions)
        pool = processes(min(n_jobs, len(missing)) or 1)
        with self.planning("planning") as progress:
            for _ in search_plans([(self, each) for each in missing], pool, progress):
                pass

    def look_up_all(
        self, tasks: Iterable[Task], conditions: Conditions
    ) -> tuple[dict[str, GraspPlan], list[Wanted]]:
        """Return the plans that fit, by task, and what has to be searched for the other tasks."""
        plans: dict[str, GraspPlan] = {}
        missing: list[Wanted] = []
        for task in tasks:
            found = self.look_up(task, conditions)
            if isinstance(found, Wanted):
                self._note_again(found)
                missing.append(found)
            else:
                plans[task.name] = found
        return plans, missing

    def look_up(
        self, task: Task, conditions: Conditions, scene: Scene | None = None
    ) -> GraspPlan | Wanted:
        """Return the plan of a task for the hand of the conditions, or what to search.

        Parameters
        ----------
        task
            For a right hand.
        conditions
        scene
            Of the task under these conditions, if it is built already.
        """
        entries = list(self._entries(task.name))
        usual, hand = planned_for(conditions), counted(conditions.hand)
        own = [each for each in entries if each.hand in (None, hand)]
        if not entries:
            return self._begun(Wanted(task, usual))
        key = key_for(task, conditions, scene)
        fitting = [each for each in entries if each.key == key]
        held = [each for each in fitting if each.held]
        final = [each for each in fitting if each.attempts >= ATTEMPTS]
        for each in (*held, *final):
            return self._carried(each.plan, conditions)
        latest = (fitting or own or entries)[0]
        why = _why_not(latest, key)
        if not (own or fitting):
            return self._begun(Wanted(task, usual, why=why))
        return Wanted(task, usual, latest.plan, latest.attempts if fitting else 0, why)

    def known(self, tasks: Iterable[Task], conditions: Conditions) -> dict[str, GraspPlan]:
        """Return the plans that fit, by task; none is made."""
        plans: dict[str, GraspPlan] = {}
        for task in tasks:
            found = self.look_up(task, conditions)
            if isinstance(found, GraspPlan):
                plans[task.name] = found
            elif found.why:
                self._tell(f"plan of {task.name} {found.why}: left out")
        return plans

    def read(self) -> dict[str, GraspPlan]:
        """Return all stored plans by task, even those that do not hold or fit."""
        stores = (*reversed(self.shared), *([self.store] if self.store else []))
        plans = {name: plan for store in stores for name, plan in store.read().items()}
        return plans | {name: each.plan for name, each in self.made.items()}

    def keep(self, task: Task, stored: StoredPlan) -> GraspPlan:
        """Store a plan and return it; where the store cannot be written, it stays in memory."""
        stored = replace(stored, plan=replace(stored.plan, transport=None))
        self.made[task.name] = stored
        if self.store is not None:
            self.store.keep(task.name, stored, self.note)
        return stored.plan

    def _carried(self, plan: GraspPlan, conditions: Conditions) -> GraspPlan:
        """Return a plan whose palm comes in as this grasper's does."""
        own = self.transport
        return replace(plan, transport=own and own.for_side(conditions.hand.side))

    def _note_again(self, wanted: Wanted) -> None:
        """Note why a stored plan is not used."""
        if wanted.why:
            self._tell(f"plan of {wanted.task.name} {wanted.why}: planned again")

    def _entries(self, task: str) -> Iterator[StoredPlan]:
        """Yield the stored plans of a task, the latest first."""
        if task in self.made:
            yield self.made[task]
        for store in (*([self.store] if self.store else []), *self.shared):
            stored = store.entries().get(task)
            if stored is not None:
                yield stored

    def _begun(self, wanted: Wanted) -> Wanted:
        """Return what to search with the plans of other controllers or hands to begin with.

        One of this hand is enough: what it holds, another controller of a person's hand holds with
        much the same palm.
        """
        hints = list(self._hints(wanted.task.name))
        for each in hints:
            if each.hand in (None, counted(wanted.conditions.hand)):
                return replace(wanted, others=(each,))
        others = [*self._entries(wanted.task.name), *hints]
        for name in _with_same_object(wanted.task):
            others += self._hints(name)
        return replace(wanted, others=tuple(others))

    def _hints(self, task: str) -> Iterator[StoredPlan]:
        """Yield the plans of other controllers or hands for a task, as this controller has them."""
        for store in dict.fromkeys(self.hints):
            stored = store.entries().get(task)
            if stored is None:
                continue
            if store.controller != self.controller.digest:  # a point of another subspace
                stored = replace(stored, plan=replace(stored.plan, z_goal=None))
            yield stored

    def _tell(self, line: str) -> None:
        if self.note is not None:
            self.note(line)


def search_plans(
    missing: Sequence[tuple[ControllerGrasper, Wanted]],
    pool: Pool,
    progress: Progress | None = None,
) -> Iterator[tuple[int, GraspPlan]]:
    """Search plans, several at a time, and yield each with its number in ``missing``.

    Each plan is stored where its grasper stores plans, before it is yielded. ``progress`` is called
    with the fraction done: after each plan, and in this process within each as well.
    """
    n, within = len(missing), progress if pool is one_by_one else None
    arguments = (
        (i, (grasper.controller, each, _share(within, i, n)))
        for i, (grasper, each) in enumerate(missing)
    )
    i: int
    for done, (i, stored) in enumerate(pool(search_plan, arguments), start=1):
        grasper, wanted = missing[i]
        if progress is not None:
            progress(done / n)
        yield i, grasper.keep(wanted.task, stored)


def _share(progress: Progress | None, done: int, n: int) -> Progress | None:
    """Return what is to be called with the fraction done of the next of ``n`` equal shares."""
    return None if progress is None else lambda fraction: progress((done + fraction) / n)


def _why_not(stored: StoredPlan, key: PlanKey) -> str:
    """Say why a stored plan is not used."""
    if stored.key is None:
        return "does not say what it was made for"
    parts = stored.key.differs_in(key)
    if parts:
        return f"is of another {' and another '.join(parts)}"
    return f"did not hold after {stored.attempts} of {ATTEMPTS} searches"


def _with_same_object(task: Task) -> Iterator[str]:
    """Yield the names of the other tasks of Table I with the object of a task."""
    for each in TASKS:
        if each.name != task.name and each.object_name == task.object_name:
            yield each.name

"""What grasps in each run of a sweep: the demonstrator, or a controller with its plans."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

from handsim.digests import content_digest
from handsim.errors import FileError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.grasper import ControllerGrasper, Grasper, Wanted, search_plans
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.pool import Pool
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.sweep.spec import SweepRun, SweepSpec
from handsim.grasping.sweep.table import ResultsTable
from handsim.learning.controller import GraspController
from handsim.tasks.task import Task
from handsim.types import Progress


@dataclass(frozen=True)
class Source:
    """A controller of a sweep, or the demonstrator.

    Attributes
    ----------
    digest
        Of all that decides how it grasps.
    grasper
        Makes the grasper for the hand of the conditions.
    """

    digest: str
    grasper: Callable[[Conditions], Grasper]


@dataclass(frozen=True)
class Planned:
    """Grasps one task by its plan, with all that another process needs."""

    controller: GraspController
    plan: GraspPlan

    @property
    def digest(self) -> str:
        """Digest of the plan."""
        return _digest(self.plan)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp."""
        return run_plan(self.controller, Scene.build(task, conditions), self.plan)


_Hand = tuple[str, str, str]
"""Controller, size and side, which decide where plans are stored."""


class SweepGraspers:
    """What grasps in the runs that are missing in a table.

    Parameters
    ----------
    spec
    sources
        Controllers by their names in ``spec``.
    table
    """

    def __init__(self, spec: SweepSpec, sources: Mapping[str, Source], table: ResultsTable) -> None:
        self._graspers: dict[_Hand, Grasper] = {}
        self._plans: dict[_Hand, dict[str, GraspPlan]] = {}
        self._missing: list[tuple[_Hand, ControllerGrasper, Wanted]] = []
        first: dict[_Hand, dict[str, SweepRun]] = {}
        for run in spec.runs():
            if run.number not in table:
                first.setdefault(_hand(run), {}).setdefault(run.task.name, run)
        for hand, by_task in first.items():
            usual = next(iter(by_task.values())).usual
            grasper = self._graspers[hand] = sources[hand[0]].grasper(usual)
            if isinstance(grasper, ControllerGrasper) and grasper.mode == "plan":
                tasks = [run.task for run in by_task.values()]
                self._plans[hand] = grasper.read()
                plans, missing = grasper.look_up_all(tasks, usual)
                self._plans[hand] |= plans
                self._missing += [(hand, grasper, each) for each in missing]

    @property
    def n_unplanned(self) -> int:
        """Number of plans that are missing, over all controllers, hands, sides and tasks."""
        return len(self._missing)

    def __getitem__(self, run: SweepRun) -> Grasper:
        """Return what grasps in a run."""
        grasper = self._graspers[_hand(run)]
        if isinstance(grasper, ControllerGrasper) and grasper.mode == "plan":
            return Planned(grasper.controller, self._plans[_hand(run)][run.task.name])
        return grasper

    def plan(self, pool: Pool, progress: Progress | None = None) -> None:
        """Make the plans that are missing and store them where the controllers store plans."""
        wanted = [(grasper, each) for _, grasper, each in self._missing]
        for i, plan in search_plans(wanted, pool, progress):
            hand, _, each = self._missing[i]
            self._plans[hand][each.task.name] = plan
        self._missing = []

    def check(self, table: ResultsTable) -> None:
        """Check that the rows of a table were made by the present plans.

        Raises
        ------
        FileError
            If a row was made by another plan.
        """
        for row in table.rows():
            plans = self._plans.get((row["controller"], row["hand"], row["side"]), {})
            plan = plans.get(row["task"])
            if plan is not None and _digest(plan) != row["plan"]:
                raise FileError(
                    f"{table.path}: holds rows by another plan of {row['task']} than "
                    f"{row['controller']} has now; choose another output, or delete it"
                )


def check_plans(spec: SweepSpec, sources: Mapping[str, Source]) -> None:
    """Read all plans that a sweep may use, before its table is begun.

    Raises
    ------
    FileError
        If a file of plans cannot be read.
    """
    for name, hand, side in product(spec.controllers, spec.hands, spec.sides):
        usual = Conditions(hand=hand.size(side))
        grasper = sources[name].grasper(usual)
        if isinstance(grasper, ControllerGrasper):
            grasper.read()


def _digest(plan: GraspPlan) -> str:
    """Return eight hexadecimal digits of a plan; its last bits do not count."""
    return content_digest(plan.stored)[:8]


def _hand(run: SweepRun) -> _Hand:
    """Return controller, hand and side of a run."""
    return run.controller, run.hand.name, run.side

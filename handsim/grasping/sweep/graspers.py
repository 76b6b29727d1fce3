"""What grasps in each run of a sweep: the script, or a controller with a plan for every hand."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

from handsim.digests import content_digest
from handsim.errors import FileError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.grasper import ControllerGrasper, Grasper, Wanted, search_plan
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
    """A controller of a sweep, or the script.

    Attributes
    ----------
    digest
        Of all that decides what it does.
    grasper
        Makes what grasps with the hand of the conditions.
    """

    digest: str
    grasper: Callable[[Conditions], Grasper]


@dataclass(frozen=True)
class Planned:
    """Grasps one task by its plan; all that a process elsewhere needs."""

    controller: GraspController
    plan: GraspPlan

    @property
    def digest(self) -> str:
        """Of the plan."""
        return _digest(self.plan)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp."""
        return run_plan(self.controller, Scene.build(task, conditions), self.plan)


_Hand = tuple[str, str, str]


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
        self._by_hand: dict[_Hand, Grasper] = {}
        self._plans: dict[_Hand, dict[str, GraspPlan]] = {}
        missing: dict[tuple[_Hand, str], SweepRun] = {}
        for run in spec.runs():
            if run.number not in table:
                missing.setdefault((_hand(run), run.task.name), run)
        self._wanted: list[tuple[SweepRun, Wanted]] = []
        for run in missing.values():
            if _hand(run) not in self._by_hand:
                self._by_hand[_hand(run)] = sources[run.controller].grasper(run.usual)
                grasper = self._planning(run)
                self._plans[_hand(run)] = grasper.read() if grasper else {}
            self._look_up(run)

    @property
    def unplanned(self) -> list[SweepRun]:
        """A run for each controller, hand, side and task that has no plan that fits."""
        return [run for run, _ in self._wanted]

    def __getitem__(self, run: SweepRun) -> Grasper:
        """Return what grasps in a run."""
        grasper = self._planning(run)
        if grasper is None:
            return self._by_hand[_hand(run)]
        return Planned(grasper.controller, self._plans[_hand(run)][run.task.name])

    def plan(self, pool: Pool, progress: Progress | None = None) -> None:
        """Make the plans that are missing and keep them where the controllers keep plans."""
        n = len(self._wanted)
        arguments = (
            (i, (self._controller(run), wanted)) for i, (run, wanted) in enumerate(self._wanted)
        )
        for done, (i, stored) in enumerate(pool(search_plan, arguments), start=1):
            run, _ = self._wanted[i]
            grasper = self._planning(run)
            assert grasper is not None
            self._plans[_hand(run)][run.task.name] = grasper.keep(run.task, stored)
            if progress:
                progress(done / n)
        self._wanted = []

    def check(self, table: ResultsTable) -> None:
        """Check that rows in a table were made by the plans of now.

        Raises
        ------
        FileError
            If a plan is another.
        """
        for row in table.rows():
            plans = self._plans.get((row["controller"], row["hand"], row["side"]), {})
            plan = plans.get(row["task"])
            if plan is not None and _digest(plan) != row["plan"]:
                raise FileError(
                    f"{table.path}: holds rows by another plan of {row['task']} than "
                    f"{row['controller']} has now; choose another output, or delete it"
                )

    def _planning(self, run: SweepRun) -> ControllerGrasper | None:
        grasper = self._by_hand[_hand(run)]
        if isinstance(grasper, ControllerGrasper) and grasper.mode == "plan":
            return grasper
        return None

    def _look_up(self, run: SweepRun) -> None:
        """Find the plan of a run, or note what is to be planned."""
        grasper = self._planning(run)
        if grasper is None:
            return
        found = grasper.look_up(run.task, run.usual)
        if isinstance(found, GraspPlan):
            self._plans[_hand(run)][run.task.name] = found
            return
        grasper.tell_again(found)
        self._wanted.append((run, found))

    def _controller(self, run: SweepRun) -> GraspController:
        grasper = self._planning(run)
        assert grasper is not None
        return grasper.controller


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
    """Return eight hexadecimal digits that tell plans apart, but not by their last bits."""
    return content_digest(plan)[:8]


def _hand(run: SweepRun) -> _Hand:
    """Return what decides where plans are: controller, hand and side."""
    return run.controller, run.hand.name, run.side

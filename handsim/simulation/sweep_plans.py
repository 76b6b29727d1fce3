"""What grasps in each run of a sweep: the script, or a controller with a plan for every hand."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from handsim.errors import FileError
from handsim.hand.grasp_task import Task
from handsim.learning.controller import GraspController
from handsim.simulation.conditions import Conditions
from handsim.simulation.grasping import ControllerGrasper, Grasper
from handsim.simulation.plan import GraspPlan
from handsim.simulation.planner import plan_grasp, run_plan
from handsim.simulation.pool import Pool
from handsim.simulation.rollout import Rollout
from handsim.simulation.stage import Stage
from handsim.simulation.sweep_spec import SweepRun, SweepSpec
from handsim.simulation.sweep_table import ResultsTable

Progress = Callable[[float], None]
"""Called with the fraction done."""


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
        return run_plan(self.controller, Stage.build(task, conditions), self.plan)


_Hand = tuple[str, str, str]


class SweepGraspers:
    """What grasps in the runs that are missing in a table.

    Parameters
    ----------
    spec
    sources
        Controllers by their names in ``spec``.
    table

    Attributes
    ----------
    unplanned
        A run for each controller, hand, side and task that has no plan yet.
    """

    def __init__(self, spec: SweepSpec, sources: Mapping[str, Source], table: ResultsTable) -> None:
        self._by_hand: dict[_Hand, Grasper] = {}
        self._plans: dict[_Hand, dict[str, GraspPlan]] = {}
        missing: dict[tuple[_Hand, str], SweepRun] = {}
        for run in spec.runs():
            if run.number not in table:
                missing.setdefault((_hand(run), run.task.name), run)
        for run in missing.values():
            if _hand(run) not in self._by_hand:
                self._by_hand[_hand(run)] = sources[run.controller].grasper(run.usual)
                self._read_plans(run)
        self.unplanned = [run for run in missing.values() if self._lacks_plan(run)]

    def __getitem__(self, run: SweepRun) -> Grasper:
        """Return what grasps in a run."""
        grasper = self._planning(run)
        if grasper is None:
            return self._by_hand[_hand(run)]
        return Planned(grasper.controller, self._plans[_hand(run)][run.task.name])

    def plan(self, pool: Pool, progress: Progress | None = None) -> None:
        """Make the plans that are missing and keep them where the controllers keep plans."""
        n, jobs = len(self.unplanned), [(run, self._to_plan(run)) for run in self.unplanned]
        by_number = {run.number: run for run in self.unplanned}
        arguments = ((run.number, values) for run, values in jobs)
        for done, (number, (plan, held)) in enumerate(pool(_plan, arguments), start=1):
            self._keep(by_number[number], plan, held)
            if progress:
                progress(done / n)
        self.unplanned = []

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

    def _read_plans(self, run: SweepRun) -> None:
        grasper = self._planning(run)
        if grasper is not None and grasper.store is not None:
            self._plans[_hand(run)] = grasper.store.read()

    def _lacks_plan(self, run: SweepRun) -> bool:
        plans = self._plans.get(_hand(run), {})
        return self._planning(run) is not None and run.task.name not in plans

    def _to_plan(self, run: SweepRun) -> tuple[Any, ...]:
        """Return the arguments of `_plan`."""
        grasper = self._planning(run)
        assert grasper is not None
        return grasper.controller, run.task, run.usual, grasper.hint(run.task)

    def _keep(self, run: SweepRun, plan: GraspPlan, held: bool) -> None:
        """Store a plan, and use it as it is stored."""
        grasper = self._planning(run)
        assert grasper is not None
        if grasper.store is None:
            self._plans.setdefault(_hand(run), {})[run.task.name] = plan
            return
        grasper.store.add(run.task.name, plan, held)
        self._read_plans(run)


def _digest(plan: GraspPlan) -> str:
    """Return eight hexadecimal digits that tell plans apart."""
    numbers = (
        plan.palm.pos, plan.palm.quat, plan.retreat, plan.q_start, plan.q_goal,
        [plan.squeeze, plan.arrive],
    )  # fmt: skip
    return hashlib.sha256(np.concatenate(numbers).tobytes()).hexdigest()[:8]


def _hand(run: SweepRun) -> _Hand:
    """Return what decides where plans are: controller, hand and side."""
    return run.controller, run.hand.name, run.side


def _plan(
    controller: GraspController, task: Task, conditions: Conditions, hint: GraspPlan | None
) -> tuple[GraspPlan, bool]:
    """Plan, and say whether the nominal run holds."""
    plan, run = plan_grasp(controller, task, conditions, hint)
    return plan, run.outcome.success

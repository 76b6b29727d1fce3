"""Run a sweep: many grasps, each of which becomes a row of a table."""

from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields

from handsim.digests import content_digest
from handsim.errors import HandsimError
from handsim.grasping.planning.grasper import Grasper
from handsim.grasping.planning.plan_key import object_content, task_content
from handsim.grasping.pool import Pool
from handsim.grasping.rollout.record import current_versions
from handsim.grasping.sweep.graspers import Planned, Source, SweepGraspers
from handsim.grasping.sweep.spec import SweepRun, SweepSpec
from handsim.grasping.sweep.table import ResultsTable
from handsim.types import Progress


@dataclass(frozen=True)
class SweepRow:
    """One run of a sweep; lengths in m, angles in deg, times in s; ``plan`` is a plan's digest."""

    controller: str
    task: str
    object: str
    hand: str
    hand_length_m: float
    hand_breadth_m: float
    side: str
    friction: float
    mass_scale: float
    seed: int
    plan: str
    nominal: bool
    success: bool
    reason: str
    lift_m: float
    peak_slip_m: float
    peak_tilt_deg: float
    hold_s: float
    penetration_m: float


COLUMNS: tuple[str, ...] = tuple(field.name for field in fields(SweepRow))


def sweep_key(spec: SweepSpec, sources: Mapping[str, Source]) -> str:
    """Return the key of a sweep: a digest of its values, controllers and versions.

    Tasks and objects count by their content, not by their names. Numbers are rounded
    (`handsim.digests`), so that a sweep can be continued on another machine.
    """
    content = {
        **vars(spec),
        "tasks": [task_content(task) for task in spec.tasks],
        "objects": [
            object_content(task.for_side(side).object) for side in spec.sides for task in spec.tasks
        ],
        "controllers": [(name, sources[name].digest) for name in spec.controllers],
        "versions": _versions(),
    }
    return content_digest(content)[:12]


def sweep(
    spec: SweepSpec,
    graspers: SweepGraspers,
    table: ResultsTable,
    pool: Pool,
    progress: Progress | None = None,
) -> None:
    """Make the runs that are missing in a table.

    Parameters
    ----------
    spec
    graspers
        With all plans made.
    table
        Open; rows are appended as they come, and sorted at the end.
    pool
        In which the runs are made.
    progress
        Called with the fraction of all rows that are done.

    Raises
    ------
    FileError
        If rows of the table were made by other plans.
    HandsimError
        If workers are lost for good; all rows done are kept.
    """
    graspers.check(table)
    runs = (run for run in spec.runs() if run.number not in table)
    versions = _versions()
    for number, row in pool(_row, ((r.number, (graspers[r], r, versions)) for r in runs)):
        table.add(number, astuple(row))
        if progress:
            progress(len(table) / spec.n_runs)
    table.complete()


def _row(grasp: Grasper, run: SweepRun, versions: dict[str, str]) -> SweepRow:
    """Make a run, but not where the versions differ from those of the sweep."""
    if _versions() != versions:
        raise HandsimError(
            f"a worker has {_versions()}, and this machine {versions}; install the same"
        )
    rollout = grasp(run.task, run.conditions)
    outcome, conditions = rollout.outcome, rollout.conditions
    return SweepRow(
        controller=run.controller,
        task=run.task.name,
        object=run.task.object_name,
        hand=run.hand.name,
        hand_length_m=conditions.hand.length,
        hand_breadth_m=conditions.hand.breadth,
        side=run.side,
        friction=conditions.friction,
        mass_scale=conditions.mass_scale,
        seed=run.seed,
        plan=grasp.digest if isinstance(grasp, Planned) else "",
        nominal=conditions.nominal,
        success=outcome.success,
        reason=outcome.reason or "",
        lift_m=outcome.lift_m,
        peak_slip_m=outcome.peak_slip_m,
        peak_tilt_deg=outcome.peak_tilt_deg,
        hold_s=outcome.hold_s,
        penetration_m=outcome.penetration_m,
    )


def _versions() -> dict[str, str]:
    """Return the versions on which every digit of a row depends."""
    versions = current_versions()
    return {name: versions[name] for name in ("handsim", "mujoco")}

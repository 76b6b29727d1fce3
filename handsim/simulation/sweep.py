"""Many grasps: tasks, hands, friction and seeds in all combinations, as rows of a table."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product

from handsim.errors import InputError
from handsim.hand.grasp_task import Side, Task
from handsim.hand.population import preset
from handsim.simulation.conditions import Conditions, perturb
from handsim.simulation.grasping import Grasper, TaskResult, run_at_once
from handsim.simulation.rollout import Rollout
from handsim.simulation.trials import wilson_interval


@dataclass(frozen=True)
class SweepRow:
    """One run of a sweep; lengths in m, angles in deg, times in s."""

    task: str
    object: str
    hand: str
    side: str
    friction: float
    seed: int
    nominal: bool
    success: bool
    reason: str
    lift_m: float
    peak_slip_m: float
    peak_tilt_deg: float
    hold_s: float
    penetration_m: float


@dataclass(frozen=True)
class _Cell:
    """What one process does: a task with one hand and friction, seed after seed."""

    task: Task
    hand: str
    side: Side
    friction: float | None
    seeds: tuple[int, ...]


def sweep(
    grasp: Grasper,
    tasks: Sequence[Task],
    *,
    hands: Sequence[str] = ("man-50",),
    sides: Sequence[Side] = ("right",),
    frictions: Sequence[float | None] = (None,),
    seeds: Iterable[int] = (0,),
    n_jobs: int = 1,
) -> Iterator[SweepRow]:
    """Grasp in all combinations and yield the runs in order, as they come.

    Parameters
    ----------
    grasp
        What grasps; a controller should have its plans already, for every hand and side.
    tasks
    hands
        Presets of hand sizes (`handsim.hand.population.PRESETS`).
    sides
    frictions
        Of the hand; None is the usual one in nominal runs and drawn in perturbed ones.
    seeds
        0 is a nominal run, all others are perturbed.
    n_jobs
        Processes at once.

    Raises
    ------
    InputError
        If there is nothing to do.
    UnknownNameError
        If there is no such hand size.
    """
    for hand in hands:
        preset(hand)
    kept = tuple(seeds)
    cells = [_Cell(*each, kept) for each in product(tasks, hands, sides, frictions)]
    if not (cells and kept):
        raise InputError(
            "a sweep of nothing; give a task, a hand, a side, a friction and a seed at least"
        )
    for rows in run_at_once(_rows, [(grasp, cell) for cell in cells], n_jobs):
        yield from rows


def _rows(grasp: Grasper, cell: _Cell) -> list[SweepRow]:
    length, breadth = preset(cell.hand)
    usual = Conditions(hand_length=length, hand_breadth=breadth, side=cell.side)
    rows = []
    for seed in cell.seeds:
        conditions = perturb(usual, seed) if seed else usual
        if cell.friction is not None:
            conditions = replace(conditions, friction=cell.friction)
        rows.append(_row(cell, grasp(cell.task, conditions)))
    return rows


def _row(cell: _Cell, run: Rollout) -> SweepRow:
    outcome, conditions = run.outcome, run.conditions
    return SweepRow(
        task=cell.task.name,
        object=cell.task.object_name,
        hand=cell.hand,
        side=cell.side,
        friction=conditions.friction,
        seed=conditions.seed,
        nominal=conditions.nominal,
        success=outcome.success,
        reason=outcome.reason or "",
        lift_m=outcome.lift_m,
        peak_slip_m=outcome.peak_slip_m,
        peak_tilt_deg=outcome.peak_tilt_deg,
        hold_s=outcome.hold_s,
        penetration_m=outcome.penetration_m,
    )


def as_csv(rows: Iterable[SweepRow]) -> str:
    """Return rows as comma-separated text with a header."""
    names = [field.name for field in fields(SweepRow)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        values = (getattr(row, name) for name in names)
        writer.writerow(f"{v:.6g}" if isinstance(v, float) else v for v in values)
    return text.getvalue()


def results_table(columns: dict[str, Sequence[TaskResult]]) -> str:
    """Return a Markdown table of tasks against graspers, with rates and their intervals below.

    Parameters
    ----------
    columns
        Results by the grasper's name, each of the same tasks in the same order.
    """
    names = list(columns)
    lines = [f"| task | {' | '.join(names)} |", f"|---|{'---|' * len(names)}"]
    for results in zip(*columns.values(), strict=True):
        cells = [_cell(result) for result in results]
        lines.append(f"| {results[0].task.name} | {' | '.join(cells)} |")
    lines.append(f"| **all** | {' | '.join(_total(columns[name]) for name in names)} |")
    return "\n".join(lines) + "\n"


def _cell(result: TaskResult) -> str:
    nominal = result.nominal.outcome.reason or "held"
    return f"{nominal}, {result.successes}/{len(result.trials)}" if result.trials else nominal


def _total(results: Sequence[TaskResult]) -> str:
    held = sum(result.nominal.outcome.success for result in results)
    successes = sum(result.successes for result in results)
    trials = sum(len(result.trials) for result in results)
    if not trials:
        return f"{held} of {len(results)}"
    low, high = wilson_interval(successes, trials)
    rate = f"{100 * successes / trials:.0f} % ({100 * low:.0f} to {100 * high:.0f})"
    return f"{held} of {len(results)}, perturbed {rate}"

"""The tables of grasps in README.md: an arm, human forces, rules that only a grasp can pass.

Run: .venv/bin/python -m tests.benchmarks.human_grasps [GRASPER ...] [-o runs.csv] [--jobs N]
    [--sets nominal ...] [--side left] [--hand-length M --hand-breadth M] [--transport people]

A grasper is ``demonstrator``, ``built-in`` or a controller file, whose plans lie beside it or are
made first. Each of the 24 tasks is grasped under ten seeds of the glove's noise, in 20 perturbed
trials, and in five trials that are hard in one thing each. No search has seen these seeds.
"""

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from handsim.cli.defaults import PalmTransport, planning_grasper
from handsim.grasping.conditions import Conditions, Hard, made_hard, perturb
from handsim.grasping.judging.rates import wilson_interval
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.grasping.planning.grasper import ControllerGrasper, Grasper
from handsim.grasping.pool import in_order, processes
from handsim.grasping.sweep.graspers import Planned
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import MEDIAN_HAND, HandSize

NOMINAL = range(5001, 5011)
PERTURBED = range(101, 121)
HARD = range(301, 306)
SETS = ("nominal", "perturbed", *get_args(Hard))

USUAL = PalmTransport.of(None)


@dataclass(frozen=True)
class Trial:
    """One run of a table: a task in one of the sets, and its outcome."""

    grasper: str
    task: str
    kind: str
    seed: int
    outcome: Outcome


def trials_of(usual: Conditions, sets: Sequence[str] = SETS) -> list[tuple[str, int, Conditions]]:
    """Return set, seed and conditions of all runs of a task in some of the sets."""
    found = [("nominal", seed, replace(usual, seed=seed)) for seed in NOMINAL]
    found += [("perturbed", seed, perturb(usual, seed)) for seed in PERTURBED]
    for kind in get_args(Hard):
        found += [(kind, seed, made_hard(usual, seed, kind)) for seed in HARD]
    return [each for each in found if each[0] in sets]


def outcome_of(grasper: Grasper, task: str, conditions: Conditions) -> Outcome:
    """Grasp, in another process."""
    return grasper(task_by_name(task), conditions).outcome


def grasper_for(name: str, usual: Conditions, transport: PalmTransport) -> Grasper:
    """Return what grasps by its name."""
    if name == "demonstrator":
        return demonstrate
    path = None if name == "built-in" else Path(name)
    return transport.by(planning_grasper(path, usual))


def run(
    name: str,
    n_jobs: int,
    usual: Conditions,
    sets: Sequence[str] = SETS,
    transport: PalmTransport = USUAL,
) -> list[Trial]:
    """Make all runs of a grasper in some of the sets."""
    grasper = grasper_for(name, usual, transport)
    by_task = dict.fromkeys((task.name for task in TASKS), grasper)
    if isinstance(grasper, ControllerGrasper):
        grasper.prepare(TASKS, usual, n_jobs)
        plans, _ = grasper.look_up_all(TASKS, usual)
        by_task = {task: Planned(grasper.controller, plan) for task, plan in plans.items()}
    asked = [(task.name, *each) for task in TASKS for each in trials_of(usual, sets)]
    arguments = [(by_task[task], task, conditions) for task, _, _, conditions in asked]
    outcomes = in_order(processes(n_jobs), outcome_of, arguments)
    return [
        Trial(name, task, kind, seed, outcome)
        for (task, kind, seed, _), outcome in zip(asked, outcomes, strict=True)
    ]


def summary(trials: Sequence[Trial]) -> str:
    """Return the lines of a grasper's table."""
    nominal = [each for each in trials if each.kind == "nominal"]
    lines = _of_nominal(nominal) if nominal else []
    for kind in SETS[1:]:
        held = [each.outcome.success for each in trials if each.kind == kind]
        if not held:
            continue
        low, high = wilson_interval(sum(held), len(held))
        share = 100 * np.mean(held)
        lines.append(
            f"{kind}: {sum(held)} of {len(held)}, {share:.0f} % "
            f"({100 * low:.0f} to {100 * high:.0f})"
        )
    return "\n".join([*lines, *_of_forces([each for each in nominal if each.outcome.success])])


def _of_nominal(nominal: Sequence[Trial]) -> list[str]:
    by_seed = [sum(t.outcome.success for t in nominal if t.seed == seed) for seed in NOMINAL]
    said = f"{np.mean(by_seed):.1f} of {len(TASKS)} tasks, worst {min(by_seed)}"
    return [f"nominal, ten seeds: {said}"]


def _of_forces(held: Sequence[Trial]) -> list[str]:
    """Return what grasps without perturbation needed, as far as there are any that held."""
    outcomes = [each.outcome for each in held]
    lifted = [
        each.outcome.forces_n["thumb"] / each.outcome.need_n
        for each in held
        if task_by_name(each.task).rule.lifted
    ]
    said: list[str] = []
    if lifted:
        said.append(
            f"thumb in the hold, lifted things: {np.median(lifted):.1f} times the need in the "
            f"median, {max(lifted):.1f} at most"
        )
    if outcomes:
        strain = [each.strain for each in outcomes]
        said.append(f"table {max(each.table_force_n for each in outcomes):.0f} N at most")
        said.append(
            f"strain of the arm {np.median(strain):.2f} in the median, {max(strain):.2f} at most"
        )
    return ["; ".join(said)] if said else []


def by_task(trials: Sequence[Trial]) -> str:
    """Return rows of tasks: how many runs of each set held."""
    sets = [kind for kind in SETS if any(trial.kind == kind for trial in trials)]
    lines = [f"| task | {' | '.join(sets)} |", f"|---|{'---|' * len(sets)}"]
    for task in TASKS:
        cells: list[str] = []
        for kind in sets:
            held = [t.outcome.success for t in trials if t.task == task.name and t.kind == kind]
            cells.append(f"{sum(held)}/{len(held)}")
        lines.append(f"| {task.name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def write(trials: Sequence[Trial], path: Path) -> None:
    """Write a row for each run."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["grasper", "task", "set", "seed", "success", "reason", "thumb_n", "need_n"])
        for t in trials:
            o = t.outcome
            thumb = o.forces_n.get("thumb", 0.0)
            rows.writerow([t.grasper, t.task, t.kind, t.seed, o.success, o.reason, thumb, o.need_n])


def main() -> None:
    """Make the runs and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("graspers", nargs="*", default=["demonstrator", "built-in"])
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sets", nargs="+", choices=SETS, default=SETS)
    parser.add_argument("--side", choices=("right", "left"), default=MEDIAN_HAND.side)
    parser.add_argument("--hand-length", type=float, default=MEDIAN_HAND.length)
    parser.add_argument("--hand-breadth", type=float, default=MEDIAN_HAND.breadth)
    parser.add_argument("--transport", help="as of handsim grasp; controllers only")
    asked = parser.parse_args()
    usual = Conditions(hand=HandSize(asked.hand_length, asked.hand_breadth, asked.side))
    transport = PalmTransport.of(asked.transport)
    made: list[Trial] = []
    for name in asked.graspers:
        trials = run(name, asked.jobs, usual, asked.sets, transport)
        made += trials
        print(f"{name}\n{summary(trials)}\n\n{by_task(trials)}\n", flush=True)
        if asked.output:
            write(made, asked.output)


if __name__ == "__main__":
    main()

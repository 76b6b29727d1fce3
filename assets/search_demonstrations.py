"""Search what alignment alone does not hold, and store it as data.

``python assets/search_demonstrations.py [TASK...]`` searches the named tasks anew, or, without
names, all that have no stored offsets and do not hold in the search's own tries.

With ``--only squeeze`` or ``--only grip`` nothing else changes: how far the hand squeezes after its
reach, or how hard fingers that have touched press. Only what leaves the recorded reach as it is to
the bit is tried, so that all that was learned from it stays, too.
"""

import argparse
import sys
from time import perf_counter
from typing import Literal

from handsim.errors import HandsimError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator_offsets import (
    DemonstratorOffsets,
    demonstrator_offsets,
    demonstrator_offsets_file,
    write_demonstrator_offsets,
)
from handsim.grasping.planning.trials.scripted_trials import search_grip, search_offsets
from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS, task_by_name

N_PERTURBED = 6
GENERATIONS = 14
N_NOMINAL = 60
N_PERTURBED_GRIPS = 20


def search_grips(names: list[str], only: Literal["squeeze", "grip"], n_jobs: int) -> None:
    """Search how the named tasks, or all, are held, and store it, task by task."""
    for name in names or [task.name for task in TASKS]:
        found = dict(demonstrator_offsets())
        started = perf_counter()
        held, offsets = search_grip(
            task_by_name(name),
            Conditions(),
            found.get(name, DemonstratorOffsets()),
            only,
            n_nominal=N_NOMINAL,
            n_perturbed=N_PERTURBED_GRIPS,
            n_jobs=n_jobs,
        )
        if any(offsets.values):
            write_demonstrator_offsets({**found, name: offsets}, demonstrator_offsets_file())
            demonstrator_offsets.cache_clear()
        took = perf_counter() - started
        sys.stderr.write(
            f"{name}: {held[0]} of {N_NOMINAL} nominal and {held[1]} of {N_PERTURBED_GRIPS} "
            f"perturbed runs held, after {took:.0f} s\n"
        )


def main(names: list[str]) -> None:
    """Search and store, task by task."""
    found = dict(demonstrator_offsets())
    tasks = [task_by_name(name) for name in names]
    for task in tasks or [*TASKS, PHONE_TODAY_VIEW]:
        if not names and task.name in found:
            continue
        started = perf_counter()
        cost, offsets = search_offsets(
            task,
            Conditions(),
            0,
            found.get(task.name),
            generations=GENERATIONS,
            n_perturbed=N_PERTURBED,
        )
        if any(offsets.values):
            found[task.name] = offsets
            write_demonstrator_offsets(found, demonstrator_offsets_file())
        took = perf_counter() - started
        sys.stderr.write(f"{task.name}: cost {cost:.2f} after {took:.0f} s\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", metavar="TASK")
    parser.add_argument("--only", choices=("squeeze", "grip"))
    parser.add_argument("--jobs", type=int, default=1)
    asked = parser.parse_args()
    try:
        if asked.only:
            search_grips(asked.tasks, asked.only, asked.jobs)
        else:
            main(asked.tasks)
    except HandsimError as error:
        sys.exit(str(error))

"""Search what alignment alone does not hold, and store it as data.

``python assets/search_demonstrations.py [TASK...]`` searches the named tasks anew, or, without
names, all that have no stored offsets and do not hold in the search's own tries.
"""

import sys
from time import perf_counter

from handsim.errors import HandsimError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator_offsets import (
    demonstrator_offsets,
    demonstrator_offsets_file,
    write_demonstrator_offsets,
)
from handsim.grasping.planning.trials.scripted_trials import search_offsets
from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS, task_by_name

N_PERTURBED = 6
GENERATIONS = 14


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
    try:
        main(sys.argv[1:])
    except HandsimError as error:
        sys.exit(str(error))

"""Search what alignment alone does not hold, and store it as data.

``python -m handsim.simulation.demonstrations [TASK...]`` searches the named tasks anew, or, without
names, all that have no stored adjustment and do not hold in the search's own tries.
"""

import sys
from functools import partial
from time import perf_counter

from handsim.errors import HandsimError
from handsim.hand.grasp_task import Task
from handsim.hand.model import HandModel, build_hand
from handsim.hand.tasks import PHONE_TODAY_VIEW, TASKS, task_by_name
from handsim.simulation.adjustment import (
    Adjustment,
    adjustments,
    adjustments_file,
    write_adjustments,
)
from handsim.simulation.closed_loop import Stage
from handsim.simulation.conditions import Conditions
from handsim.simulation.demonstrator import demonstrate_on
from handsim.simulation.search import cost_of, mean_cost, minimise, shortened, tried_conditions

N_PERTURBED = 6
GENERATIONS = 14


def search_adjustment(
    task: Task,
    start: Adjustment | None = None,
    *,
    generations: int = GENERATIONS,
    n_perturbed: int = N_PERTURBED,
    seed: int = 0,
) -> tuple[float, Adjustment]:
    """Search what to change of a scripted grasp so that it holds, perturbed as well.

    Parameters
    ----------
    task
        For the right hand.
    start
        Where the search begins; by default nothing is changed.
    generations
        Of 8 adjustments each; it ends sooner when all tries hold with room to spare.
    n_perturbed
        Perturbed tries of every adjustment whose nominal try holds.
    seed
        Of the search.

    Returns
    -------
    float, Adjustment
        The mean cost (`cost_of`) of the best, below 0 only if all tries held.
    """
    quick = shortened(task)
    stages = [Stage.build(quick, each) for each in tried_conditions(Conditions(), n_perturbed)]
    hand = HandModel.from_spec(build_hand())

    def cost(point: Adjustment, stage: Stage) -> float:
        return cost_of(demonstrate_on(stage, hand, point, brief=True), quick)

    least, point = minimise(
        lambda x: mean_cost([partial(cost, Adjustment.of(x), stage) for stage in stages]),
        (start or Adjustment()).point,
        generations=generations,
        seed=seed,
    )
    return least, Adjustment.of(point)


def main(names: list[str]) -> None:
    """Search and store, task by task."""
    found = dict(adjustments())
    tasks = [task_by_name(name) for name in names]
    for task in tasks or [*TASKS, PHONE_TODAY_VIEW]:
        if not names and task.name in found:
            continue
        started = perf_counter()
        cost, adjustment = search_adjustment(task, found.get(task.name))
        if any(adjustment.values):
            found[task.name] = adjustment
            write_adjustments(found, adjustments_file())
        took = perf_counter() - started
        sys.stderr.write(f"{task.name}: cost {cost:.2f} after {took:.0f} s\n")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except HandsimError as error:
        sys.exit(str(error))

"""Search what alignment alone does not hold, and store it as data.

``python assets/search_demonstrations.py [TASK...]`` searches the named tasks anew, or, without
names, all that have no stored offsets and do not hold in the search's own tries.
"""

import sys
from functools import partial
from time import perf_counter

from handsim.errors import HandsimError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrate_on, scripted_plan
from handsim.grasping.planning.demonstrator_offsets import (
    DemonstratorOffsets,
    demonstrator_offsets,
    demonstrator_offsets_file,
    write_demonstrator_offsets,
)
from handsim.grasping.planning.search import (
    cost_of,
    mean_cost,
    minimise,
    out_of_reach,
    shortened,
    tried_conditions,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS, task_by_name
from handsim.tasks.task import Task

N_PERTURBED = 6
GENERATIONS = 14


def search_offsets(
    task: Task,
    start: DemonstratorOffsets | None = None,
    *,
    generations: int = GENERATIONS,
    n_perturbed: int = N_PERTURBED,
    seed: int = 0,
) -> tuple[float, DemonstratorOffsets]:
    """Search what to change of a scripted grasp so that it holds, perturbed as well.

    Parameters
    ----------
    task
        For the right hand.
    start
        Where the search begins; by default nothing is changed.
    generations
        Of 8 demonstrator_offsets each; it ends sooner when all tries hold with room to spare.
    n_perturbed
        Perturbed tries of every offsets whose nominal try holds.
    seed
        Of the search.

    Returns
    -------
    float, DemonstratorOffsets
        The mean cost (`cost_of`) of the best, below 0 only if all tries held.
    """
    quick = shortened(task)
    scenes = [Scene.build(quick, each) for each in tried_conditions(Conditions(), n_perturbed)]
    hand = HandModel.from_spec(build_hand())

    def cost(point: DemonstratorOffsets, scene: Scene) -> float:
        plan, _ = scripted_plan(scene.task, hand, point)
        far = out_of_reach(scene, plan)
        return (
            cost_of(demonstrate_on(scene, hand, point, brief=True), quick) if far is None else far
        )

    least, point = minimise(
        lambda x: mean_cost([partial(cost, DemonstratorOffsets.of(x), scene) for scene in scenes]),
        (start or DemonstratorOffsets()).point,
        generations=generations,
        seed=seed,
    )
    return least, DemonstratorOffsets.of(point)


def main(names: list[str]) -> None:
    """Search and store, task by task."""
    found = dict(demonstrator_offsets())
    tasks = [task_by_name(name) for name in names]
    for task in tasks or [*TASKS, PHONE_TODAY_VIEW]:
        if not names and task.name in found:
            continue
        started = perf_counter()
        cost, offsets = search_offsets(task, found.get(task.name))
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

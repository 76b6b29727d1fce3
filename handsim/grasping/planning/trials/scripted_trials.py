"""Proposed grasps run by script: once each, then perturbed, then searched around."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np

from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.planning.demonstrator import (
    demonstrate,
    demonstrate_on,
    demonstrated_reach,
    scripted_plan,
)
from handsim.grasping.planning.demonstrator_offsets import SPREADS, DemonstratorOffsets
from handsim.grasping.planning.search import (
    SEARCH_SEED,
    cost_of,
    minimise,
    out_of_reach,
    robust_cost,
    shortened,
    tried_conditions,
)
from handsim.grasping.planning.trial_variation import USUAL, trial_variation
from handsim.grasping.planning.trials.laying import LaidGrasp
from handsim.grasping.pool import in_order, processes
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.objects.proposals import Proposal
from handsim.tasks.task import Task
from handsim.types import Progress

N_PERTURBED = 3
"""Perturbed runs by which the best grasps are compared."""
N_SEARCHED_WITH = 2
"""Perturbed runs of every point of a search."""
GENERATIONS = 6
"""Of a search, of 8 points each."""
NOISE_SEED = 2000
"""Seed of the first run in which nothing but the glove's noise differs, far from those of trials.
"""
GRIP_CHANGES = tuple(i / 12 for i in range(-12, 13))
"""Changes of squeeze or grip that are compared, in units of `SPREADS`."""
FAILED = 1.0
"""Least cost of a run that did not hold (`search.cost_of`)."""


@dataclass(frozen=True)
class TriedGrasp:
    """A proposal, its task, and the cost of one brief run of it: below `FAILED` where it held."""

    proposal: Proposal
    task: Task
    cost: float

    @property
    def held(self) -> bool:
        """Whether it was held."""
        return self.cost < FAILED


@dataclass(frozen=True)
class ScriptedGrasper:
    """Grasps by script with offsets that were found for one task."""

    offsets: DemonstratorOffsets = field(default_factory=DemonstratorOffsets)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp; perturbed runs vary in posture and timing, as `demonstrate` varies them."""
        return demonstrate(task, conditions, offsets=self.offsets)


def try_by_script(
    laid: Sequence[LaidGrasp],
    conditions: Conditions,
    *,
    n_jobs: int = 1,
    progress: Progress | None = None,
) -> tuple[TriedGrasp, ...]:
    """Run each proposal once by script, briefly.

    Parameters
    ----------
    laid
        What to try.
    conditions
        Of the runs.
    n_jobs
        Processes at once.
    progress
        Called with the fraction done.
    """
    costs = in_order(processes(n_jobs), script_cost, [(each.task, conditions) for each in laid])
    tried: list[TriedGrasp] = []
    for i, (each, cost) in enumerate(zip(laid, costs, strict=True), start=1):
        tried.append(TriedGrasp(each.proposal, each.task, cost))
        if progress is not None:
            progress(i / len(laid))
    return tuple(tried)


@dataclass(frozen=True)
class _Runs:
    """Brief runs of a task by script, the first of them nominal."""

    scenes: tuple[Scene, ...]
    hand: HandModel

    @classmethod
    def of(cls, task: Task, tried: Sequence[Conditions]) -> "_Runs":
        scenes = tuple(Scene.build(shortened(task), each) for each in tried)
        return cls(scenes, HandModel.from_spec(build_hand(tried[0].hand)))

    def cost(self, offsets: DemonstratorOffsets) -> float:
        """Return the mean cost, for which later runs are left out where it is great anyway."""
        return robust_cost([partial(self._cost, scene, offsets) for scene in self.scenes])

    def costs(self, offsets: DemonstratorOffsets) -> list[float]:
        """Return the costs of all runs."""
        return [self._cost(scene, offsets) for scene in self.scenes]

    def _cost(self, scene: Scene, offsets: DemonstratorOffsets) -> float:
        conditions = scene.conditions
        plan, _ = scripted_plan(scene.task, self.hand, offsets, conditions.hand.side)
        far = out_of_reach(scene, plan)
        if far is not None:
            return far
        variation = USUAL if conditions.nominal else trial_variation(conditions.seed)
        run = demonstrate_on(scene, self.hand, offsets, variation=variation, brief=True)
        return cost_of(run, scene.task)


def script_cost(task: Task, conditions: Conditions, n_perturbed: int = 0) -> float:
    """Return the mean cost of brief scripted runs, nominal and perturbed."""
    return _Runs.of(task, tried_conditions(conditions, n_perturbed)).cost(DemonstratorOffsets())


def search_offsets(
    task: Task,
    conditions: Conditions,
    seed: int,
    start: DemonstratorOffsets | None = None,
    *,
    generations: int = GENERATIONS,
    n_perturbed: int = N_SEARCHED_WITH,
) -> tuple[float, DemonstratorOffsets]:
    """Search offsets with which a scripted grasp holds, perturbed as well.

    Parameters
    ----------
    task
        For the right hand.
    conditions
        Nominal conditions.
    seed
        Of the search.
    start
        Where the search begins; by default nothing is changed.
    generations
        Of 8 offsets each; it ends sooner when all runs hold with room to spare.
    n_perturbed
        Perturbed runs of all offsets whose nominal run holds.

    Returns
    -------
    float, DemonstratorOffsets
        The least cost (`robust_cost`) and its offsets.
    """
    runs = _Runs.of(task, tried_conditions(conditions, n_perturbed))
    least, point = minimise(
        lambda x: runs.cost(DemonstratorOffsets.of(x)),
        (start or DemonstratorOffsets()).point,
        generations=generations,
        seed=seed,
    )
    return least, DemonstratorOffsets.of(point)


def search_grip(
    task: Task,
    conditions: Conditions,
    start: DemonstratorOffsets,
    name: Literal["squeeze", "grip"],
    *,
    n_nominal: int,
    n_perturbed: int,
    n_jobs: int = 1,
) -> tuple[tuple[int, int], DemonstratorOffsets]:
    """Search the squeeze or the grip with which a scripted grasp holds most often.

    Of `GRIP_CHANGES` those are compared with which the reach that is recorded as an experiment
    stays as it is to the bit. Fingers that touch before its end may change the last readings. All
    make the same runs, since what holds in a few runs may do so by chance. That is kept which holds
    most often as it is, with other noise of the glove; of those the one that holds most often
    perturbed; of those the cheapest.

    Parameters
    ----------
    task
        For the right hand.
    conditions
        Nominal conditions.
    start
        What is changed.
    name
        The offset that changes.
    n_nominal, n_perturbed
        Runs with each change.
    n_jobs
        Processes at once.

    Returns
    -------
    tuple of int, DemonstratorOffsets
        How many of the nominal and of the perturbed runs hold, and the offsets.
    """
    nominal = [replace(conditions, seed=NOISE_SEED + i) for i in range(n_nominal)]
    perturbed = [perturb(conditions, SEARCH_SEED + i) for i in range(n_perturbed)]
    along = np.array([each == name for each in SPREADS])
    changed = [DemonstratorOffsets.of(start.point + change * along) for change in GRIP_CHANGES]
    tried = [each for each in changed if _same_reach(task, start, each)]
    asked = [(task, (*nominal, *perturbed), offsets) for offsets in tried]
    ranks: list[tuple[int, int, float]] = []
    for costs in in_order(processes(n_jobs), _costs_of, asked):
        held = [cost < FAILED for cost in costs]
        ranks.append((sum(held[:n_nominal]), sum(held[n_nominal:]), -float(np.mean(costs))))
    best = max(range(len(tried)), key=ranks.__getitem__)
    return ranks[best][:2], tried[best]


def _same_reach(task: Task, one: DemonstratorOffsets, other: DemonstratorOffsets) -> bool:
    """Whether both are recorded with the same readings."""
    before, after = demonstrated_reach(task, one), demonstrated_reach(task, other)
    return before is not None and after is not None and np.array_equal(before.q, after.q)


def _costs_of(task: Task, tried: Sequence[Conditions], offsets: DemonstratorOffsets) -> list[float]:
    """Return the costs of runs, in another process."""
    return _Runs.of(task, tried).costs(offsets)

"""The cost of a run in a search for a plan, and an evolutionary search that minimises it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import cma
import numpy as np

from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.rollout.record import Rollout
from handsim.tasks.task import Task
from handsim.types import Array

ENOUGH = -0.4
"""Mean cost at which a search ends: every run holds, well within every limit."""
SEARCH_SEED = 1000
"""Seed of the first perturbed run of a search, far from the seeds of trials."""
WORST = 5.0
"""About the greatest cost of a failure."""
SEARCH_HOLD = 1.0
"""Time that a search holds the object [s]; the plan found is then tested by the task's own rule."""


def shortened(task: Task) -> Task:
    """Return a task that holds its object for at most `SEARCH_HOLD`."""
    return replace(task, rule=replace(task.rule, hold=min(task.rule.hold, SEARCH_HOLD)))


def tried_conditions(nominal: Conditions, n_perturbed: int) -> list[Conditions]:
    """Return the conditions of the runs of a search: the nominal ones, then perturbed ones."""
    return [nominal, *(perturb(nominal, SEARCH_SEED + i) for i in range(n_perturbed))]


def cost_of(rollout: Rollout, task: Task) -> float:
    """Return the cost of a run: at least 1 where it failed, -1 to 0 where it held.

    A failure costs less the longer it held and the more of the task it did. A success costs less
    the farther slip and tilt are below their limits.
    """
    outcome, rule = rollout.outcome, task.rule
    slip = min(outcome.peak_slip_m / rule.slip, 5.0)
    tilt = min(outcome.peak_tilt_deg / rule.tilt_deg, 5.0)
    if outcome.success:
        return max(slip, tilt) - 1.0
    held = min(outcome.hold_s / rule.hold, 1.0) if rule.hold else 0.0
    rises = rule.lift > 0 and rule.kind != "slide"
    lifted = min(outcome.lift_m / rule.lift, 1.0) if rises else 0.0
    squeezed = rollout.contact_force[rollout.time > rollout.phases[1].start]
    grip = float((squeezed > 0).mean(axis=0).mean())
    missing = (1 - held) + 0.5 * (1 - lifted) + (1 - outcome.done) + 0.5 * (1 - grip)
    return 1.0 + missing + 0.1 * (slip + tilt)


def mean_cost(costs_in_turn: Sequence[Callable[[], float]]) -> float:
    """Return the mean cost of runs, of which the nominal one is the first.

    After a nominal failure no other run is made; the cost is then above that of any plan that fails
    only when perturbed. After three failures the other runs count as failures of the same cost.
    """
    costs: list[float] = []
    for cost in costs_in_turn:
        costs.append(cost())
        if costs[0] >= 1:
            return costs[0] + WORST
        failures = [each for each in costs if each >= 1]
        if len(failures) == 3:
            costs += [float(np.mean(failures))] * (len(costs_in_turn) - len(costs))
            break
    return float(np.mean(costs))


def minimise(
    cost: Callable[[Array], float],
    start: Array,
    *,
    generations: int,
    population: int = 8,
    seed: int = 0,
    enough: float = ENOUGH,
) -> tuple[float, Array]:
    """Minimise a cost by CMA-ES from ``start``, in units of the initial spreads (n,).

    Returns
    -------
    float, (n,)
        The least cost found, and its point; the start counts too.

    References
    ----------
    N. Hansen & A. Ostermeier (2001), Evol. Comput. 9(2):159-195.
    """
    best: tuple[float, Array] = (cost(start), start)
    options = {
        "seed": seed + 1,  # 0 would mean a seed from the clock
        "popsize": population,
        "maxiter": generations,
        "verbose": -9,
    }
    strategy = cma.CMAEvolutionStrategy(start, 0.7, options)
    while not strategy.stop() and best[0] > enough:
        points = strategy.ask()
        costs = [cost(point) for point in points]
        strategy.tell(points, costs)
        least = int(np.argmin(costs))
        if costs[least] < best[0]:
            best = (costs[least], np.array(points[least]))
    return best

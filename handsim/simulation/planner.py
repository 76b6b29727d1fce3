"""Find the palm pose and the destination in the subspace with which a controller grasps.

A posture put through a few principal components no longer touches where it touched: the fingertips
move. What was recorded is therefore only where the search begins. Each candidate is tried in the
physics that it will be used in, and the first that meets the task's rule with room to spare ends
the search.
"""

from collections.abc import Iterator

import cma
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.hand.grasp_task import Task
from handsim.hand.model import HandModel, build_hand
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.simulation.alignment import align_palm, opposition
from handsim.simulation.closed_loop import Stage, simulate
from handsim.simulation.closings import REST
from handsim.simulation.conditions import Conditions
from handsim.simulation.demonstrator import plan_for
from handsim.simulation.drivers import learned_driver
from handsim.simulation.plan import GraspPlan, schedule_for
from handsim.simulation.rollout import Rollout

Array = npt.NDArray[np.float64]

GENERATIONS = 12
POPULATION = 8
STEP_COMPONENT = np.deg2rad(12.0)
"""Initial spread of the search along each component [rad]."""
STEP_POSITION = 0.012
"""Initial spread of the palm's position [m]."""
STEP_TURN = np.deg2rad(8.0)
"""Initial spread of the palm's orientation [rad]."""
ENOUGH = -0.5
"""Cost at which the search ends: held throughout, and half of every limit to spare."""


def replayed_plan(controller: GraspController, stage: Stage, hand: HandModel) -> GraspPlan:
    """Return the plan that takes the recorded destination as it is, palm pose by the script."""
    scripted, _ = plan_for(stage.task, hand)
    recorded = controller.demonstration(stage.task.name)
    return GraspPlan(scripted.palm, scripted.retreat, REST, recorded.q_goal, scripted.squeeze)


def plan_grasp(
    controller: GraspController,
    task: Task,
    conditions: Conditions,
    known: GraspPlan | None = None,
    seed: int = 0,
) -> tuple[GraspPlan, Rollout]:
    """Search a plan and return it with the run that shows what it does.

    Parameters
    ----------
    controller
        What will drive the fingers.
    task
        For a right hand; it is mirrored as the conditions say.
    conditions
        Nominal conditions to plan for.
    known
        A plan to try first, such as that of another controller.
    seed
        Of the search.

    Returns
    -------
    GraspPlan, Rollout
        The best found; the run's outcome says whether it holds.
    """
    stage = Stage.build(task, conditions)
    hand = HandModel.from_spec(
        build_hand(conditions.hand_length, conditions.hand_breadth, conditions.side)
    )
    search = _Search(controller, stage, hand)
    best: tuple[float, GraspPlan, Rollout] | None = None
    starts = list(search.starts(known))
    tried = [search.attempt(plan) for plan in starts]
    best = min(tried, key=lambda attempt: attempt[0])
    if best[0] <= ENOUGH:
        return best[1], best[2]
    options = {
        "seed": seed + 1,  # 0 would mean a seed from the clock
        "popsize": POPULATION,
        "maxiter": GENERATIONS,
        "verbose": -9,
    }
    strategy = cma.CMAEvolutionStrategy(np.zeros(search.size), 1.0, options)
    centre = best[1]
    while not strategy.stop() and best[0] > ENOUGH:
        points = strategy.ask()
        attempts = [search.attempt(search.varied(centre, point)) for point in points]
        strategy.tell(points, [attempt[0] for attempt in attempts])
        best = min([best, *attempts], key=lambda attempt: attempt[0])
    return best[1], best[2]


class _Search:
    """What is varied, and what an attempt costs."""

    def __init__(self, controller: GraspController, stage: Stage, hand: HandModel) -> None:
        self.controller, self.stage, self.hand = controller, stage, hand
        self.n_components = len(controller.subspace.components_)
        self.size = self.n_components + 6

    def starts(self, known: GraspPlan | None) -> Iterator[GraspPlan]:
        """Plans to try before any search."""
        if known is not None:
            yield known
        scripted, _ = plan_for(self.stage.task, self.hand)
        for q_goal in self._destinations():
            posture = self._in_subspace(q_goal)
            aligned = align_palm(
                opposition(self.hand, posture, self.stage.task.grasp), self.stage.task.grasp
            )
            for palm in (scripted.palm, aligned):
                yield GraspPlan(palm, scripted.retreat, REST, posture, scripted.squeeze)

    def _destinations(self) -> Iterator[Array]:
        """Recorded destinations: those of the task, else of the object, else of all."""
        recorded = self.controller.demonstrations
        task = self.stage.task
        same_task = [r for r in recorded if r.task == task.name]
        same_object = [r for r in recorded if r.object == task.object_name]
        for record in (same_task or same_object or recorded)[:4]:
            yield record.q_goal

    def _in_subspace(self, q: Array) -> Array:
        """What is left of a posture in the subspace."""
        subspace = self.controller.subspace
        return clip_to_range(subspace.inverse_transform(subspace.transform(q)))

    def varied(self, plan: GraspPlan, point: Array) -> GraspPlan:
        """Return a plan displaced by ``point`` (size,), in units of the initial spreads."""
        subspace = self.controller.subspace
        n = self.n_components
        z = subspace.transform(plan.q_goal) + STEP_COMPONENT * point[:n]
        palm = plan.palm.moved(
            STEP_POSITION * point[n : n + 3], Rotation.from_rotvec(STEP_TURN * point[n + 3 :])
        )
        posture = clip_to_range(subspace.inverse_transform(z))
        return GraspPlan(palm, plan.retreat, plan.q_start, posture, plan.squeeze)

    def attempt(self, plan: GraspPlan) -> tuple[float, GraspPlan, Rollout]:
        """Run a plan and say what it costs; less is better."""
        schedule = schedule_for(self.stage.task)
        driver = learned_driver(self.controller, plan, self.stage.lead, schedule)
        rollout = simulate(self.stage, plan, driver, schedule=schedule)
        return cost_of(rollout, self.stage.task), plan, rollout


def cost_of(rollout: Rollout, task: Task) -> float:
    """Cost of a run for the search: at least 1 where it failed, -1 to 0 where it held.

    A failure costs less the longer it held and the nearer it came; a success is worth what is
    left of the limits on slip and tilt.
    """
    outcome, rule = rollout.outcome, task.rule
    slip = min(outcome.peak_slip_m / rule.slip, 5.0)
    tilt = min(outcome.peak_tilt_deg / rule.tilt_deg, 5.0)
    if outcome.success:
        return max(slip, tilt) - 1.0
    held = min(outcome.hold_s / rule.hold, 1.0) if rule.hold else 0.0
    lifted = min(outcome.lift_m / rule.lift, 1.0) if rule.lift else 0.0
    grip = float((rollout.contact_force > 0).any(axis=0).sum()) / rollout.contact_force.shape[1]
    return 1.0 + (1 - held) + 0.5 * (1 - lifted) + 0.5 * (1 - grip) + 0.1 * (slip + tilt)

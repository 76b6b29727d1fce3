"""Find the palm pose and the destination in the subspace with which a controller grasps.

A posture put through a few principal components no longer touches where it touched: the fingertips
move. So the coordinates are first fitted to where a scripted grasp has the finger pads
(`fingertip_fit`), beginning at each recorded destination. The best few are tried in the physics
that they will be used in. Where none holds with room to spare, a search goes on from there.
"""

from dataclasses import replace
from functools import partial
from operator import itemgetter

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.fingertip_fit import fit_fingertips, pad_targets
from handsim.grasping.planning.search import (
    WORST,
    cost_of,
    mean_cost,
    minimise,
    shortened,
    tried_conditions,
)
from handsim.grasping.rollout.drivers import learned_driver
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import Scene, simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.tasks.task import Task
from handsim.types import Array

GENERATIONS = 14
SEARCHES = 3
"""Starts that are searched from, one after the other, until the nominal try holds."""
SEEDS = SEARCHES + 1
"""Seeds that one planning may use, one after the other: the searches', and the whole hold's."""
N_PERTURBED = 2
"""Perturbed tries of every plan whose nominal try holds."""
N_PLACEMENTS = 3
"""Placements of each kind that are tried in physics."""
LEVERS = (0.0, 0.7)
"""Weights of the lever between thumb and fingers, one for each kind of placement: what is wide is
held without, what is thin turns away with any."""
ARRIVALS = (0.6, 0.85)
"""Fractions of the reach at which the palm may be in place: a hand that opens little on its
learned path has to be there sooner."""
DISTINCT = np.deg2rad(5.0)
"""Distance between placements' coordinates below which they are taken for the same [rad]."""
UNFAMILIAR = 0.002
"""How much worse a placement from another task's destination counts [m]."""
EDGE = 0.08
"""Share of the workspace along each component, at either end, where no destination is put: about
the layer in which beta falls to zero."""
NOMINAL_FAILS = 1 + WORST
"""Least mean cost of a plan whose nominal try fails (`search.mean_cost`)."""
NO_WAY = 10.0
"""Cost of a destination that the navigation function cannot lead to."""
STEPS = {
    "z": np.deg2rad(8.0),
    "shift": 0.008,
    "turn": np.deg2rad(7.0),
    "squeeze": 0.25,
    "arrive": 0.08,
}
"""Initial spreads of the search: components and turn [rad], shift [m], squeeze, arrival."""
ARRIVAL_RANGE = (0.4, 0.95)


def replayed_plan(controller: GraspController, scene: Scene, hand: HandModel) -> GraspPlan:
    """Return the plan that takes the recorded destination as it is, palm pose by the script."""
    scripted, _ = scripted_plan(scene.task, hand, side=scene.conditions.hand.side)
    recorded = controller.demonstration(scene.task.name)
    return replace(scripted, q_goal=recorded.q_goal)


def plan_grasp(
    controller: GraspController,
    task: Task,
    conditions: Conditions,
    known: GraspPlan | None = None,
    *,
    generations: int = GENERATIONS,
    seed: int = 0,
) -> tuple[GraspPlan, Rollout]:
    """Search a plan and return it with the nominal run that shows what it does.

    Parameters
    ----------
    controller
        What will drive the fingers.
    task
        For a right hand; it is mirrored as the conditions say.
    conditions
        Nominal conditions to plan for.
    known
        A plan to try first. Without ``z_goal``, as one of another controller is to be, it leads
        to the projection of its posture.
    generations
        Of the search where nothing tried at first holds with room to spare.
    seed
        Of the search, which takes `SEEDS` from there on.

    Returns
    -------
    GraspPlan, Rollout
        The best found; the run's outcome says whether it holds.
    """
    search = _Search(controller, shortened(task), conditions)
    starts = [] if known is None else [search.aimed(known)]
    starts += search.starts()
    ranked = sorted((search.cost(plan), i) for i, plan in enumerate(starts))
    best = (ranked[0][0], starts[ranked[0][1]])
    for attempt, (_, start) in enumerate(ranked[:SEARCHES]):
        if best[0] < NOMINAL_FAILS and attempt > 0:
            break
        found = search.from_start(starts[start], generations, seed + attempt)
        best = min(best, found, key=itemgetter(0))
    plan = best[1]
    run = run_plan(controller, Scene.build(task, conditions), plan)
    if best[0] < NOMINAL_FAILS and not run.outcome.success:  # what is held longer creeps farther
        whole = _Search(controller, task, conditions)
        plan = whole.from_start(plan, generations, seed + SEARCHES)[1]
        run = run_plan(controller, Scene.build(task, conditions), plan)
    return plan, run


def run_plan(
    controller: GraspController, scene: Scene, plan: GraspPlan, *, brief: bool = False
) -> Rollout:
    """Grasp on a scene with a controller by a plan."""
    schedule = schedule_for(scene.task)
    driver = learned_driver(controller, plan, scene.lead, schedule)
    return simulate(scene, plan, driver, schedule=schedule, brief=brief)


class _Search:
    """What is tried and varied, and what it costs."""

    def __init__(self, controller: GraspController, task: Task, conditions: Conditions) -> None:
        self.controller = controller
        self.task = task.for_side(conditions.hand.side)
        tried = tried_conditions(conditions, N_PERTURBED)
        self.scenes = [Scene.build(task, each) for each in tried]
        self.hand = HandModel.from_spec(build_hand(conditions.hand))
        self.scripted, _ = scripted_plan(self.task, self.hand, side=conditions.hand.side)
        self.size = len(controller.subspace.components_) + 8
        low, high = controller.navigation.obstacle.lower, controller.navigation.obstacle.upper
        margin = EDGE * (high - low)
        self.box = (low + margin, high - margin)

    def starts(self) -> list[GraspPlan]:
        """Return the best placements of each kind, with the palm in place sooner or later."""
        taken: list[Array] = []
        plans = []
        for lever in LEVERS:
            plans += self._placed(lever, taken)
        return [replace(plan, arrive=arrive) for plan in plans for arrive in ARRIVALS]

    def _placed(self, lever: float, taken: list[Array]) -> list[GraspPlan]:
        """Return the best placements whose coordinates are not ``taken``, and add theirs."""
        subspace = self.controller.subspace
        targets = pad_targets(self.hand, self.scripted, self.task.grasp)
        placed = []
        for record in self.controller.demonstrations:
            placement = fit_fingertips(self.hand, subspace, targets, record.z_goal, self.box, lever)
            familiar = 0.0 if record.task == self.task.name else UNFAMILIAR
            placed.append((placement.error + familiar, placement, record))
        plans: list[GraspPlan] = []
        for _, placement, record in sorted(placed, key=lambda each: each[0]):
            if any(np.linalg.norm(placement.z - z) < DISTINCT for z in taken):
                continue
            taken.append(placement.z)
            plans.append(
                replace(
                    self.scripted,
                    palm=placement.palm,
                    q_start=clip_to_range(record.q_start),
                    **self._destination(placement.z),
                    squeeze=placement.squeeze,
                )
            )
            if len(plans) == N_PLACEMENTS:
                break
        return plans

    def aimed(self, plan: GraspPlan) -> GraspPlan:
        """Return a plan with its destination in this controller's subspace."""
        return plan if plan.z_goal is not None else replace(plan, z_goal=self._goal(plan))

    def _goal(self, plan: GraspPlan) -> Array:
        """Return where a plan leads to, (n_components,) [rad]."""
        if plan.z_goal is not None:
            return plan.z_goal
        return self.controller.subspace.transform(plan.q_goal)

    def _destination(self, z: Array) -> dict[str, Array]:
        """Return a destination as fields of a plan: in the subspace, and as a posture."""
        return {
            "z_goal": z,
            "q_goal": clip_to_range(self.controller.subspace.inverse_transform(z)),
        }

    def from_start(self, start: GraspPlan, generations: int, seed: int) -> tuple[float, GraspPlan]:
        """Search around a plan; returns the least cost met and its plan, ``start`` included."""
        cost, point = minimise(
            lambda x: self.cost(self.varied(start, x)),
            np.zeros(self.size),
            generations=generations,
            seed=seed,
        )
        return cost, self.varied(start, point)

    def varied(self, plan: GraspPlan, point: Array) -> GraspPlan:
        """Return a plan displaced by ``point`` (size,), in units of the initial spreads."""
        n = len(self.controller.subspace.components_)
        z = np.clip(self._goal(plan) + STEPS["z"] * point[:n], *self.box)
        turn = Rotation.from_rotvec(STEPS["turn"] * point[n + 3 : n + 6])
        return replace(
            plan,
            palm=plan.palm.moved(STEPS["shift"] * point[n : n + 3], turn),
            **self._destination(z),
            squeeze=max(0.0, plan.squeeze + STEPS["squeeze"] * float(point[n + 6])),
            arrive=float(np.clip(plan.arrive + STEPS["arrive"] * point[n + 7], *ARRIVAL_RANGE)),
        )

    def cost(self, plan: GraspPlan) -> float:
        """Run a plan, nominal and perturbed, and return its mean cost."""
        return mean_cost([partial(self._cost_on, scene, plan) for scene in self.scenes])

    def _cost_on(self, scene: Scene, plan: GraspPlan) -> float:
        try:
            self.controller.navigation.check_goal(self._goal(plan))
        except InputError:  # too far from what was recorded
            return NO_WAY
        return cost_of(run_plan(self.controller, scene, plan, brief=True), self.task)

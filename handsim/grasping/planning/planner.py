"""Find the palm pose and the destination in the subspace with which a controller grasps.

Projecting a posture onto a few principal components moves its fingertips. The coordinates are
therefore first fitted so that the finger pads stand where a scripted grasp has them
(`fingertip_fit`), starting from each recorded destination. The best fits are run in physics. Where
none holds with room to spare, an evolutionary search starts from the best of them. What several
searches find is compared in perturbed runs that none of them has seen.

Where plans are known, of another hand for instance, they are run first. The first that holds with
room to spare is kept, and nothing is fitted or searched.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.fingertip_fit import (
    FingertipFit,
    carried_over,
    fit_fingertips,
    pad_targets,
)
from handsim.grasping.planning.plan_store import StoredPlan
from handsim.grasping.planning.search import (
    STEPS,
    WORST,
    Effort,
    Estimate,
    Found,
    cost_of,
    minimise,
    out_of_reach,
    robust_cost,
    shortened,
    tried_conditions,
    varied_around,
    within_reach,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import learned_driver
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import Demonstration
from handsim.learning.transport.stored import shipped_transport
from handsim.tasks.task import Task
from handsim.types import Array, Progress

GENERATIONS = 14
NEAR = Effort(generations=6, spread=0.5)
"""Of a search where plans of others are known: what it finds, it finds soon and near."""
SEARCHES = 3
"""Largest number of starts that are searched from, until a nominal run holds."""
N_NEAR = 2  # the same where plans of other hands are known
SEEDS = SEARCHES + 1
"""Seeds that `plan_grasp` may use: one for each search, and one for the full hold time."""
N_PERTURBED = 2
"""Perturbed runs of every plan whose nominal run holds, unless more are asked for."""
N_CONFIRMED = 6
"""Further perturbed runs, by which plans of several searches are compared."""
ENOUGH = 0.8
"""Share of runs, the nominal one counted, that a plan has to hold for the search to end."""
FAIR = 0.25
"""The same for what is found near plans of others: of the perturbed runs one at least."""
N_FITS = 3
"""Fits for each of `LEVERS` that are run in physics."""
LEVERS = (0.0, 0.7)
"""Weights of the lever between thumb and fingers in a fit (`fit_fingertips`).

Wide objects are held by fits without it. Thin objects turn away where there is a lever at all."""
ARRIVALS = (0.6, 0.85)
"""Fractions of the reach at which the palm is in place, each of which is tried.

A hand that opens little on its learned path has to be there sooner."""
N_STARTS = N_FITS * len(LEVERS) * len(ARRIVALS)  # at most
DISTINCT = np.deg2rad(5.0)
"""Distance of coordinates below which two fits count as the same [rad]."""
UNFAMILIAR = 0.002
"""Added to the error of a fit that starts from the destination of another task [m]."""
EDGE = 0.08
"""Share of the workspace along each component, at either end, without destinations: about the
layer in which beta falls to zero."""
NOMINAL_FAILS = 1 + WORST
"""Least mean cost of a plan whose nominal run fails (`search.robust_cost`)."""
NO_WAY = 10.0  # cost of a destination that the navigation function cannot lead to


def plan_grasp(
    controller: GraspController,
    task: Task,
    conditions: Conditions,
    known: GraspPlan | None = None,
    *,
    others: Sequence[StoredPlan] = (),
    generations: int = GENERATIONS,
    n_perturbed: int = N_PERTURBED,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[GraspPlan, Rollout]:
    """Search a plan and return it with its nominal run.

    Parameters
    ----------
    controller
        What will drive the fingers.
    task
        For a right hand; it is mirrored as the conditions say.
    conditions
        Nominal conditions to plan for.
    known
        A plan to try first. A plan of another controller must come without ``z_goal``; its
        destination is then the projection of its posture.
    others
        Plans of other controllers or hands, where ``known`` is None, carried over to this one and
        tried in turn. Where none holds with room to spare, the first search is from the best.
    generations, n_perturbed
        Of the search, which is made where no start holds with room to spare (`NEAR` where plans of
        other hands are known), and perturbed runs of every plan whose nominal run holds.
    seed
        First of the `SEEDS` seeds that the search may use.
    progress
        Called with the fraction done, as far as can be told (`search.Estimate`).

    Returns
    -------
    GraspPlan, Rollout
        The best found; the run's outcome says whether it holds.
    """
    effort, n_searches = (NEAR, N_NEAR) if others else (Effort(generations), SEARCHES)
    estimate = Estimate(progress)
    search = _Search(controller, shortened(task), conditions, estimate, n_perturbed)
    estimate.expect(len(others or (known,)), effort.most)
    found = Found(
        search.confirmed,
        search.from_start,
        lambda plan: run_plan(controller, Scene.build(task, conditions), plan),
    )
    for plan in search.known(known, others):
        found.add(plan, search.cost(plan))
        found.propose(-1)
        if (kept := found.kept(ENOUGH)) is not None:
            return kept
    if others:
        estimate.expect(effort.most, N_STARTS + effort.most)
        found.search_from(found.ranked()[0], effort, seed)
        if (kept := found.kept(FAIR)) is not None:
            return kept
    n_known = len(found.starts)
    estimate.expect(N_STARTS, effort.most)
    for plan in search.starts():
        found.add(plan, search.cost(plan))
    if (best := found.ranked()[0]) >= n_known:
        found.propose(best)
    for start in found.ranked():
        if len(found.searched) == n_searches or found.best[0] >= ENOUGH:
            break
        if start not in found.searched:
            further = (n_searches - len(found.searched) - 1) * effort.most
            estimate.expect(effort.most, further)
            found.search_from(start, effort, seed)
    held, plan = found.best
    run = found.whole(plan)
    if held > 0 and not run.outcome.success:  # what is held longer creeps farther
        longer = _Search(controller, task, conditions, estimate, n_perturbed)
        estimate.expect(effort.most)
        plan = longer.from_start(plan, effort, seed + SEARCHES)[1]
        run = found.whole(plan)
    return plan, run


def run_plan(
    controller: GraspController, scene: Scene, plan: GraspPlan, *, brief: bool = False
) -> Rollout:
    """Grasp on a scene with a controller by a plan."""
    schedule = schedule_for(scene.task)
    driver = learned_driver(controller, plan, scene.lead, schedule, scene.task.object_name)
    return simulate(scene, plan, driver, schedule=schedule, brief=brief)


def brief_cost(controller: GraspController, scene: Scene, plan: GraspPlan) -> float:
    """Return the cost of a run that ends once the object is lost, as searches make them."""
    if refused(controller, plan):
        return NO_WAY
    far = out_of_reach(scene, plan)
    if far is not None:
        return far
    return cost_of(run_plan(controller, scene, plan, brief=True), scene.task)


def refused(controller: GraspController, plan: GraspPlan) -> bool:
    """Whether a controller cannot lead to the destination of a plan."""
    try:
        controller.check_goal(plan.goal_in(controller.subspace))
    except InputError:
        return True
    return False


def aimed_at(controller: GraspController, plan: GraspPlan, z: Array) -> GraspPlan:
    """Return a plan with the destination z (n_components,) [rad] and its posture."""
    q_goal = clip_to_range(controller.subspace.inverse_transform(z))
    return replace(plan, z_goal=z, q_goal=q_goal)


def varied(
    controller: GraspController, plan: GraspPlan, point: Array, box: tuple[Array, Array]
) -> GraspPlan:
    """Return a plan changed by ``point`` (n_components + 9,), in units of `STEPS`.

    Its destination stays in ``box``, as of `destination_box`.
    """
    n = len(controller.subspace.components_)
    z = np.clip(plan.goal_in(controller.subspace) + STEPS["z"] * point[:n], *box)
    return varied_around(aimed_at(controller, plan, z), point[n:])


def destination_box(controller: GraspController) -> tuple[Array, Array]:
    """Return the least and greatest coordinates of destinations, (n_components,) [rad] each."""
    obstacle, inner = controller.navigation.obstacle, controller.navigation.inner
    margin = EDGE * (obstacle.upper - obstacle.lower)
    return (
        np.maximum(obstacle.lower + margin, inner[0]),
        np.minimum(obstacle.upper - margin, inner[1]),
    )


class _Search:
    """The starts of a search, their variations, and what each costs."""

    def __init__(
        self,
        controller: GraspController,
        task: Task,
        conditions: Conditions,
        estimate: Estimate,
        n_perturbed: int = N_PERTURBED,
    ) -> None:
        self.controller, self.estimate = controller, estimate
        self.grasp, self.size = task.grasp, conditions.hand
        self.task = task.for_side(conditions.hand.side)
        tried = tried_conditions(conditions, n_perturbed + N_CONFIRMED)
        scenes = [Scene.build(task, each) for each in tried]
        self.scenes, self.unseen = scenes[: 1 + n_perturbed], scenes[1 + n_perturbed :]
        self.hand = HandModel.from_spec(build_hand(conditions.hand))
        self.transport = shipped_transport(conditions.hand.side)
        self.scripted, _ = scripted_plan(self.task, self.hand, side=conditions.hand.side)
        self.n_varied = len(controller.subspace.components_) + 9
        self.box = destination_box(controller)

    def starts(self) -> list[GraspPlan]:
        """Return plans by the best fits with each lever, each with every arrival."""
        taken: list[Array] = []
        plans: list[GraspPlan] = []
        for lever in LEVERS:
            plans += self._fitted(lever, taken)
        return [replace(plan, arrive=arrive) for plan in plans for arrive in ARRIVALS]

    def _fitted(self, lever: float, taken: list[Array]) -> list[GraspPlan]:
        """Return plans by the best fits whose coordinates are not ``taken``, and add theirs."""
        subspace = self.controller.subspace
        targets = pad_targets(self.hand, self.scripted, self.task.grasp)
        fits: list[tuple[float, FingertipFit, Demonstration]] = []
        for record in self.controller.demonstrations:
            fit = fit_fingertips(self.hand, subspace, targets, record.z_goal, self.box, lever)
            familiar = 0.0 if record.task == self.task.name else UNFAMILIAR
            fits.append((fit.error + familiar, fit, record))
        plans: list[GraspPlan] = []
        for _, fit, record in sorted(fits, key=lambda each: each[0]):
            if any(np.linalg.norm(fit.z - z) < DISTINCT for z in taken):
                continue
            taken.append(fit.z)
            plans.append(
                replace(
                    aimed_at(self.controller, self.scripted, fit.z),
                    palm=fit.palm,
                    transport=self.transport,
                    q_start=clip_to_range(record.q_start),
                    squeeze=fit.squeeze,
                )
            )
            if len(plans) == N_FITS:
                break
        return plans

    def known(self, known: GraspPlan | None, others: Sequence[StoredPlan]) -> Iterator[GraspPlan]:
        """Yield plans whose destinations are given in the subspace of this controller.

        They are the one that is known, or those of other hands as plans of this one.
        """
        if known is not None:
            yield self._aimed(known)
            return
        subspace = self.controller.subspace
        for each in others:
            hands = (each.hand or self.size, self.size)
            plan = carried_over(each.plan, hands, self.grasp, subspace, self.box)
            yield self._aimed(within_reach(self.scenes[0], plan))

    def _aimed(self, plan: GraspPlan) -> GraspPlan:
        """Return a plan with its destination, moved to where this controller can lead."""
        plan = replace(plan, transport=self.transport)
        z = plan.goal_in(self.controller.subspace)
        within = np.clip(z, *self.box)
        if (within == z).all():
            return replace(plan, z_goal=z)
        return aimed_at(self.controller, plan, within)

    def from_start(self, start: GraspPlan, effort: Effort, seed: int) -> tuple[float, GraspPlan]:
        """Search around a plan; return the least cost found and its plan. ``start`` counts too."""
        cost, point = minimise(
            lambda x: self.cost(varied(self.controller, start, x, self.box)),
            np.zeros(self.n_varied),
            generations=effort.generations,
            seed=seed,
            spread=effort.spread,
        )
        return cost, varied(self.controller, start, point, self.box)

    def confirmed(self, plan: GraspPlan, cost: float) -> tuple[float, GraspPlan]:
        """Return how often a plan holds in runs that no search has seen, and the plan.

        A search finds what suits the few perturbed runs that it makes; of what several searches
        found, that is best which holds in other runs, too. 0 if the nominal run does not hold.
        """
        if cost >= NOMINAL_FAILS:
            return 0.0, plan
        costs = [self._cost_on(scene, plan) for scene in self.unseen]
        held = 1.0 + sum(each < 1.0 for each in costs)
        margin = 0.01 * float(np.mean(np.minimum(costs, WORST)))  # decides where as many hold
        return (held - margin) / (1 + len(costs)), plan

    def cost(self, plan: GraspPlan) -> float:
        """Run a plan, nominal and perturbed, and return its mean cost."""
        cost = robust_cost([partial(self._cost_on, scene, plan) for scene in self.scenes])
        self.estimate.step()
        return cost

    def _cost_on(self, scene: Scene, plan: GraspPlan) -> float:
        return brief_cost(self.controller, scene, plan)

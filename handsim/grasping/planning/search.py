"""The cost of a run in a search for a plan, and an evolutionary search that minimises it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import cma
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.arm.reaching_arm import ReachingArm
from handsim.grasping.conditions import Conditions, Perturbation, perturb
from handsim.grasping.plan import GraspPlan, Pose, schedule_for
from handsim.grasping.rollout.commands import expected_path, read_at
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.record import Rollout
from handsim.tasks.grip_rules import (
    MAX_MARGIN,
    MAX_PENETRATION,
    MAX_PUSH,
    MAX_PUSH_TURN_DEG,
    OPPOSED_SHARE,
)
from handsim.tasks.rules import Outcome
from handsim.tasks.task import PassRule, Task
from handsim.types import Array, Progress

ENOUGH = -0.25
"""Cost of a plan at which a search ends: every run holds, well within every limit."""
BROKEN = 0.3
"""Cost of breaking a rule of every grasp by as much again as its limit."""
MAX_STRAIN = 2.0
"""Strain of the arm that counts as a limit is passed; see `ArmPosture.strain`."""
NO_ARM = 8.0
"""Strain beyond which no run is made: no arm gets there."""
N_AROUND = 36
"""Turns about a round object that are compared (`within_reach`)."""
WIDE = Perturbation(
    position=0.007,
    yaw=float(np.deg2rad(7.0)),
    friction=(0.35, 0.8),
    mass=0.5,
    shake=3.0,
    bias=float(np.deg2rad(1.5)),
)
"""What every other perturbed run of a search meets: more than people do in most trials."""
SEARCH_SEED = 1000
"""Seed of the first perturbed run of a search, far from the seeds of trials."""
POPULATION = 8
"""Plans of one generation of a search."""
WORST = 5.0
"""About the greatest cost of a failure, which is 5.9."""
STEPS = {
    "z": np.deg2rad(8.0), "shift": 0.008, "turn": np.deg2rad(7.0),
    "squeeze": 0.25, "arrive": 0.08, "grip": 0.25,
}  # fmt: skip
"""Initial spreads of a search: components and turn [rad], shift [m], squeeze, arrival, and the
natural logarithm of the grip."""
ARRIVAL_RANGE = (0.4, 0.95)
SEARCH_HOLD = 1.0
"""Time that a search holds the object [s]; the plan found is then tested by the task's own rule."""


def shortened(task: Task) -> Task:
    """Return a task that holds its object for at most `SEARCH_HOLD`."""
    return replace(task, rule=replace(task.rule, hold=min(task.rule.hold, SEARCH_HOLD)))


def tried_conditions(nominal: Conditions, n_perturbed: int) -> list[Conditions]:
    """Return the conditions of the runs of a search: the nominal ones, then perturbed ones.

    The perturbed ones are by turns those of usual trials and `WIDE` ones.
    """
    ranges = (None, WIDE)
    perturbed = (perturb(nominal, SEARCH_SEED + i, ranges[i % 2]) for i in range(n_perturbed))
    return [nominal, *perturbed]


def cost_of(rollout: Rollout, task: Task) -> float:
    """Return the cost of a run: 1 to 5.9 where it failed, -1 to 0.9 where it held.

    A failure costs less the longer it held, the more of the task it did, and the less it breaks the
    rules of every grasp. A success costs less the farther it is from all limits; above 0 it takes
    an arm strained beyond `MAX_STRAIN`, which no rule forbids.
    """
    outcome, rule = rollout.outcome, task.rule
    slip = min(outcome.peak_slip_m / rule.slip, 5.0)
    tilt = min(outcome.peak_tilt_deg / rule.tilt_deg, 5.0)
    used = used_of_limits(outcome, rule)
    if outcome.success:
        return min(max(slip, tilt, *used), 1.9) - 1.0
    held = min(outcome.hold_s / rule.hold, 1.0) if rule.hold else 0.0
    rises = rule.lift > 0 and rule.kind != "slide"
    lifted = min(outcome.lift_m / rule.lift, 1.0) if rises else 0.0
    squeezed = rollout.contact_force[rollout.time > rollout.phases[1].start]
    grip = float((squeezed > 0).mean(axis=0).mean())
    missing = (1 - held) + 0.5 * (1 - lifted) + (1 - outcome.done) + 0.5 * (1 - grip)
    broken = sum(each - 1.0 for each in used if each > 1.0)
    broken += 1.0 - min(outcome.opposed / OPPOSED_SHARE, 1.0)
    return 1.0 + missing + 0.1 * (slip + tilt) + BROKEN * min(broken, 3.0)


@dataclass(frozen=True)
class Effort:
    """How long and how far around its start a search goes: see `minimise`."""

    generations: int
    spread: float = 0.7

    @property
    def most(self) -> int:
        """The greatest number of plans that are run."""
        return 1 + POPULATION * self.generations


class Estimate:
    """Says how far a search is, by the plans that were run and those that are ahead.

    What may have to be done counts by half: most often a search ends early, seldom late.

    Parameters
    ----------
    tell
        Called with the fraction done after each plan, or None.
    """

    def __init__(self, tell: Progress | None) -> None:
        self._tell, self._done, self._ahead = tell, 0, 0

    def expect(self, now: int, perhaps: int = 0) -> None:
        """Say how many plans are run now at most, and how many more perhaps after that."""
        self._ahead = now + perhaps // 2

    def step(self) -> None:
        """Note that a plan was run."""
        self._done, self._ahead = self._done + 1, max(self._ahead - 1, 0)
        if self._tell is not None:
            self._tell(self._done / (self._done + self._ahead))


Candidate = tuple[float, GraspPlan]
"""A share of runs that hold, and the plan of which they are."""


@dataclass
class Found:
    """What one planning has tried and found.

    Attributes
    ----------
    confirm
        Returns how often a plan holds in runs that no search has seen; it is given its cost, too.
    search
        Searches from a plan, with an effort and a seed.
    whole
        Runs a plan in its task as it is.
    starts, costs
        Plans from which a search may start, and what each costs.
    candidates
        Plans that may be kept.
    searched
        Numbers of the starts that were searched from.
    """

    confirm: Callable[[GraspPlan, float], Candidate]
    search: Callable[[GraspPlan, Effort, int], tuple[float, GraspPlan]]
    whole: Callable[[GraspPlan], Rollout]
    starts: list[GraspPlan] = field(default_factory=list[GraspPlan])
    costs: list[float] = field(default_factory=list[float])
    candidates: list[Candidate] = field(default_factory=list[Candidate])
    searched: set[int] = field(default_factory=set[int])

    @property
    def best(self) -> Candidate:
        """The candidate that holds most often; the first of equals."""
        return max(self.candidates, key=lambda candidate: candidate[0])

    def ranked(self) -> list[int]:
        """Return the numbers of the starts, the cheapest first."""
        return sorted(range(len(self.costs)), key=self.costs.__getitem__)

    def add(self, plan: GraspPlan, cost: float) -> None:
        """Add a start."""
        self.starts.append(plan)
        self.costs.append(cost)

    def propose(self, start: int) -> None:
        """Make a start a candidate."""
        self.candidates.append(self.confirm(self.starts[start], self.costs[start]))

    def search_from(self, start: int, effort: Effort, seed: int) -> None:
        """Search from a start and make what is found a candidate.

        Each search has a seed of its own: ``seed`` and those that follow.
        """
        cost, plan = self.search(self.starts[start], effort, seed + len(self.searched))
        self.searched.add(start)
        self.candidates.append(self.confirm(plan, cost))

    def kept(self, enough: float) -> tuple[GraspPlan, Rollout] | None:
        """Return the best candidate and its run if it holds often enough, and in its whole task."""
        share, plan = self.best
        if share < enough:
            return None
        run = self.whole(plan)
        return (plan, run) if run.outcome.success else None


def varied_around(plan: GraspPlan, point: Array) -> GraspPlan:
    """Return a plan with its destination, all else changed by ``point`` (9,), in `STEPS`."""
    return replace(
        plan,
        palm=plan.palm.moved(
            STEPS["shift"] * point[:3], Rotation.from_rotvec(STEPS["turn"] * point[3:6])
        ),
        squeeze=max(0.0, plan.squeeze + STEPS["squeeze"] * float(point[6])),
        arrive=float(np.clip(plan.arrive + STEPS["arrive"] * point[7], *ARRIVAL_RANGE)),
        grip=plan.grip * float(np.exp(STEPS["grip"] * point[8])),
    )


def strain_of(plan: GraspPlan, task: Task, arm: ReachingArm) -> float:
    """Return how far from natural an arm is at worst that follows a plan (`ArmPosture.strain`).

    The task is that of the arm's side. No run is made.
    """
    schedule = schedule_for(task)
    pos, quat = expected_path(plan, task, schedule).poses(read_at(schedule))
    return float(arm.posture(pos, quat, plan.q_goal[WRIST_COLUMNS]).strain.max())


def out_of_reach(scene: Scene, plan: GraspPlan) -> float | None:
    """Return the cost of a plan that no arm can follow, which needs no run; None for others."""
    if scene.arm is None:
        return None
    strain = strain_of(plan, scene.task, scene.arm)
    return None if strain <= NO_ARM else WORST + min(strain, 100.0) / 20.0


def within_reach(scene: Scene, plan: GraspPlan) -> GraspPlan:
    """Return a plan that an arm can follow where another turn about the object makes it one.

    A plan that no arm can follow is turned about the axis of a round object to where it strains
    the arm least. What another hand turns on it, such as a lid, it may begin elsewhere.
    """
    if scene.object.symmetry is None or out_of_reach(scene, plan) is None:
        return plan
    axis = np.eye(3)["xyz".index(scene.object.symmetry)]
    around = np.linspace(0.0, 2.0 * np.pi, N_AROUND, endpoint=False)
    turned = [_about(plan, Rotation.from_rotvec(angle * axis)) for angle in around]
    assert scene.arm is not None
    strains = [strain_of(each, scene.task, scene.arm) for each in turned]
    return turned[int(np.argmin(strains))]


def _about(plan: GraspPlan, turn: Rotation) -> GraspPlan:
    """Return a plan turned about the origin of the object."""
    palm = Pose(turn.apply(plan.palm.pos), (turn * plan.palm.rotation).as_quat(scalar_first=True))
    return replace(plan, palm=palm, retreat=turn.apply(plan.retreat))


def used_of_limits(outcome: Outcome, rule: PassRule) -> tuple[float, ...]:
    """Return how much a run uses of the limits that every grasp has, 1 where it is all."""
    return (
        outcome.penetration_m / MAX_PENETRATION,
        outcome.pushed_m / MAX_PUSH,
        outcome.pushed_deg / MAX_PUSH_TURN_DEG,
        outcome.table_force_n / rule.table_force,
        outcome.margin / MAX_MARGIN if rule.lifted else 0.0,
        outcome.strain / MAX_STRAIN,
    )


def robust_cost(costs_in_turn: Sequence[Callable[[], float]]) -> float:
    """Return the cost of a plan by those of its runs, of which the nominal one is the first.

    It is the mean of two: the mean cost of all runs, and that of the worst quarter.

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
    worst = sorted(costs)[-max(1, len(costs) // 4) :]
    return 0.5 * float(np.mean(costs)) + 0.5 * float(np.mean(worst))


def minimise(
    cost: Callable[[Array], float],
    start: Array,
    *,
    generations: int,
    population: int = POPULATION,
    seed: int = 0,
    enough: float = ENOUGH,
    spread: float = 0.7,
) -> tuple[float, Array]:
    """Minimise a cost by CMA-ES from ``start``, in units of the initial spreads (n,).

    ``spread`` is the standard deviation of the first generation, in these units.

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
    strategy = cma.CMAEvolutionStrategy(start, spread, options)
    while not strategy.stop() and best[0] > enough:
        points = strategy.ask()
        costs = [cost(point) for point in points]
        strategy.tell(points, costs)
        least = int(np.argmin(costs))
        if costs[least] < best[0]:
            best = (costs[least], np.array(points[least]))
    return best

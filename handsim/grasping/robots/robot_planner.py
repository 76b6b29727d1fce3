"""Find the palm pose and the destination with which a robot hand grasps that follows a person's.

The start is what a person's hand does: a plan of the same lead for the same task. Its posture is
mapped to the robot, whose palm goes where its fingertips come to lie where the person's pads were.
Around that an evolutionary search varies destination, palm, squeeze, arrival and grip, as for the
person's hand. The destination of a script stays.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.planning.planner import NO_WAY
from handsim.grasping.planning.search import (
    Effort,
    Estimate,
    cost_of,
    minimise,
    robust_cost,
    shortened,
    tried_conditions,
)
from handsim.grasping.robots.robot_clearance import cleared
from handsim.grasping.robots.robot_lead import Lead
from handsim.grasping.robots.robot_movement import RobotMovement, robot_movement
from handsim.grasping.robots.robot_run import simulate_robot
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.grasping.robots.robot_start import palm_for
from handsim.grasping.rollout.commands import Commands, expected_path
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.glove import RATE, DataGlove
from handsim.grasping.rollout.record import Rollout
from handsim.retargeting.retarget import Retargeter
from handsim.tasks.task import Task
from handsim.types import Array, Progress

GENERATIONS = 14
"""Of the search."""
ENOUGH = 0.0
"""Cost at which the search ends: every run holds, within all limits."""
ATTEMPTS = 2
"""Searches until a plan holds in its whole task."""
N_PERTURBED = 2
"""Perturbed runs of every plan whose nominal run holds."""
SLOWEST = 2.0
"""Greatest time constant of servos with which a hand can grasp [s]; those of Shadow, Allegro and
LEAP have 0.02 to 0.1."""
SQUEEZE_LAGS = 5.0
"""How much longer a robot squeezes than a person, in time constants of its servos."""


@dataclass(frozen=True)
class RobotTold:
    """What a robot is told in a run, before anything disturbs it.

    Attributes
    ----------
    driver
        Of the person's hand.
    commands
        With the path of the robot's palm.
    movement
        Mapped to the robot.
    """

    driver: Driver
    commands: Commands
    movement: RobotMovement


@dataclass(frozen=True)
class RobotGrasps:
    """Makes runs of one robot hand that follows one lead.

    Attributes
    ----------
    lead
        What moves the person's hand.
    retargeter
        Maps postures to the robot; its openings should keep their width (``opening_scale=1``).
    """

    lead: Lead
    retargeter: Retargeter

    def run(
        self,
        scene: RobotScene,
        plan: GraspPlan,
        mapped: Array | None = None,
        *,
        brief: bool = False,
    ) -> Rollout:
        """Grasp on a scene by the plan of a person's hand, which the robot follows.

        ``mapped`` is that of `robot_movement`, if it is known.
        """
        return self.run_told(scene, plan, self.told(scene, plan, mapped), brief=brief)

    def told(self, scene: RobotScene, plan: GraspPlan, mapped: Array | None = None) -> RobotTold:
        """Return what the robot is told in all runs of a task by a plan, whatever disturbs them.

        ``mapped`` is that of `robot_movement`, if it is known.
        """
        schedule = self.schedule(scene)
        driver = self.lead.driver(scene, plan, schedule)
        usual = Commands.of(plan, scene.task, schedule, self.retargeter.person.size)
        arrival = plan.arrive * schedule.reach
        movement = robot_movement(self.retargeter, driver, usual, arrival, scene.gripping, mapped)
        q, x = driver.destination, movement.told[-1]
        palm = palm_for(self.retargeter, plan.palm, q, x, scene.gripping)
        pos, quat = expected_path(replace(plan, palm=palm), scene.task, schedule).poses(usual.times)
        pos = pos + Rotation.from_quat(quat, scalar_first=True).apply(movement.shift)
        commands = replace(usual, palm_pos=pos, palm_quat=quat)
        return RobotTold(driver, cleared(scene, commands, movement, arrival), movement)

    def run_told(
        self, scene: RobotScene, plan: GraspPlan, told: RobotTold, *, brief: bool = False
    ) -> Rollout:
        """Grasp on a scene by a plan of which it is known what the robot is told."""
        commands = told.commands.disturbed(scene.conditions, DataGlove())
        return simulate_robot(scene, plan, told.driver, commands, told.movement, brief=brief)

    def schedule(self, scene: RobotScene) -> Schedule:
        """Return the timing of a task, with a squeeze that lasts until slow servos have closed.

        Raises
        ------
        InputError
            If they are slower than `SLOWEST`.
        """
        robot = self.retargeter.robot
        lag = RobotServos.at(robot, robot.reference).lag
        if not lag <= SLOWEST:
            raise InputError(
                f"the hand's servos follow with a time constant of {lag:.3g} s, more than "
                f"{SLOWEST:g}; give them more gain or less damping"
            )
        usual = schedule_for(scene.task)
        longer = round(SQUEEZE_LAGS * lag * RATE) / RATE  # whole readings
        return replace(usual, squeeze=usual.squeeze + longer)

    def costs(self, scenes: Sequence[RobotScene], plan: GraspPlan) -> Iterator[Callable[[], float]]:
        """Yield what makes the runs of a plan, each of which ends once the object is lost.

        Each returns its cost. The scenes are of one task.
        """
        if self.lead.refuses(plan):
            yield from (lambda: NO_WAY for _ in scenes)
            return
        told = self.told(scenes[0], plan)
        for scene in scenes:
            yield lambda scene=scene: cost_of(
                self.run_told(scene, plan, told, brief=True), scene.task
            )


def plan_robot_grasp(
    grasps: RobotGrasps,
    task: Task,
    conditions: Conditions,
    starts: Sequence[GraspPlan],
    *,
    generations: int = GENERATIONS,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[GraspPlan, Rollout, Array]:
    """Search a plan for a robot hand; return it, its nominal run, and to what that was mapped.

    Parameters
    ----------
    grasps
    task
        For a right hand; it is mirrored as the robot's side says.
    conditions
        Nominal conditions to plan for.
    starts
        Plans of this lead for a robot or a person's hand of the same side, palms included.
    generations
        Of a search, which is made where the best start does not hold with room to spare.
    seed
        Of the first search; what does not hold in its whole task is where another one begins, in
        that task.
    progress
        Called with the fraction done, as far as can be told (`search.Estimate`).
    """
    robot = grasps.retargeter.robot
    tried = tried_conditions(conditions, N_PERTURBED)

    def scenes_of(task: Task) -> list[RobotScene]:
        return [RobotScene.build(task, each, robot) for each in tried]

    scenes = scenes_of(shortened(task))
    estimate = Estimate(progress)
    most = Effort(generations).most
    estimate.expect(len(starts) + most)

    def cost(plan: GraspPlan) -> float:
        found = robust_cost(list(grasps.costs(scenes, plan)))
        estimate.step()
        return found

    whole = RobotScene.build(task, conditions, robot)
    plan = _first_good(starts, cost)
    attempt = 0
    while True:
        start = plan
        if attempt:  # what the short task does not show, the whole one does
            estimate.expect(most)
            scenes = scenes_of(task)
        _, point = minimise(
            lambda x, start=start: cost(grasps.lead.varied(start, x)),
            np.zeros(grasps.lead.n_varied),
            generations=generations,
            seed=seed + attempt,
            enough=ENOUGH,
        )
        plan = grasps.lead.varied(start, point)
        told = grasps.told(whole, plan)
        attempt, run = attempt + 1, grasps.run_told(whole, plan, told)
        if run.outcome.success or attempt == ATTEMPTS:
            return plan, run, told.movement.mapped


def _first_good(starts: Sequence[GraspPlan], cost: Callable[[GraspPlan], float]) -> GraspPlan:
    """Return the first plan with which a search would end, else the one of least cost."""
    costs: list[float] = []
    for start in starts:
        costs.append(cost(start))
        if costs[-1] <= ENOUGH:
            break
    return starts[int(np.argmin(costs))]

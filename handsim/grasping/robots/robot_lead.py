"""What moves the person's hand that a robot hand follows: a learned controller, or a script."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from handsim.digests import content_digest
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Schedule
from handsim.grasping.planning.demonstrator import demonstrate, scripted_plan
from handsim.grasping.planning.demonstrator_offsets import DemonstratorOffsets, demonstrator_offsets
from handsim.grasping.planning.grasper import ControllerGrasper, Waiting, nobody_waits
from handsim.grasping.planning.planner import destination_box, refused, varied
from handsim.grasping.planning.search import varied_around
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver, ScriptedDriver, learned_driver
from handsim.grasping.rollout.record import Rollout
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import N_JOINTS
from handsim.learning.controller import GraspController
from handsim.tasks.task import Task
from handsim.types import Array, HandSize


class Lead(Protocol):
    """Moves a person's hand, and knows what a search may change of its plans."""

    @property
    def digest(self) -> str:
        """Tells leads apart whose plans are not the same."""
        ...

    @property
    def planning(self) -> Waiting:
        """Called with a label while a plan is searched (`ControllerGrasper.planning`)."""
        ...

    @property
    def n_varied(self) -> int:
        """Numbers that a search varies."""
        ...

    def plan(self, task: Task, conditions: Conditions) -> GraspPlan:
        """Return the plan of the person's hand; the task is for a right hand."""
        ...

    def run(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp with the person's hand."""
        ...

    def driver(self, scene: RobotScene, plan: GraspPlan, schedule: Schedule) -> Driver:
        """Return what moves the joints, without the lead for servos: the robot's have their own."""
        ...

    def refuses(self, plan: GraspPlan) -> bool:
        """Whether it cannot lead to the destination of a plan."""
        ...

    def varied(self, plan: GraspPlan, point: Array) -> GraspPlan:
        """Return a plan changed by ``point`` (n_varied,), in units of `search.STEPS`."""
        ...


@dataclass(frozen=True)
class LearnedLead:
    """A learned controller leads.

    Attributes
    ----------
    people
        Grasps with the controller and a person's hand: whence a first plan comes.
    """

    people: ControllerGrasper

    @property
    def controller(self) -> GraspController:
        """The controller."""
        return self.people.controller

    @property
    def digest(self) -> str:
        """Digest of the controller."""
        return self.controller.digest

    @property
    def planning(self) -> Waiting:
        """That of the grasper."""
        return self.people.planning

    @property
    def n_varied(self) -> int:
        """Components, three numbers each of shift and turn, squeeze, arrival and grip."""
        return len(self.controller.subspace.components_) + 9

    def plan(self, task: Task, conditions: Conditions) -> GraspPlan:
        """Return the stored plan of the person's hand, or make it; its base goes straight."""
        return replace(self.people.plan_for(task, Scene.build(task, conditions)), transport=None)

    def run(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp with the person's hand."""
        return self.people(task, conditions)

    def driver(self, scene: RobotScene, plan: GraspPlan, schedule: Schedule) -> Driver:
        """Return the driver that follows the learned flow, within the subspace from the first.

        A robot hand begins where the first of these postures is mapped to.
        """
        no_lead = np.zeros(N_JOINTS)
        name = scene.task.object_name
        led = learned_driver(self.controller, plan, no_lead, schedule, name)
        return replace(led, outside=None)

    def refuses(self, plan: GraspPlan) -> bool:
        """Whether the destination is outside of what the controller knows."""
        return refused(self.controller, plan)

    def varied(self, plan: GraspPlan, point: Array) -> GraspPlan:
        """Return a plan with another destination, palm, squeeze, arrival and grip."""
        return varied(self.controller, plan, point, destination_box(self.controller))


@dataclass(frozen=True)
class ScriptedLead:
    """The demonstrator's script leads, in all 22 joints.

    Attributes
    ----------
    offsets
        Of the script; by default those stored for each task.
    planning
        Called with a label while a plan is searched.
    """

    offsets: DemonstratorOffsets | None = None
    planning: Waiting = nobody_waits
    n_varied: int = 9

    @property
    def digest(self) -> str:
        """Digest of the offsets."""
        stored = {name: each.values for name, each in demonstrator_offsets().items()}
        return content_digest("script", stored if self.offsets is None else self.offsets.values)

    def plan(self, task: Task, conditions: Conditions) -> GraspPlan:
        """Return the script's plan."""
        size = conditions.hand
        return scripted_plan(task.for_side(size.side), _hand(size), self.offsets, size.side)[0]

    def run(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp with the person's hand."""
        return demonstrate(task, conditions, offsets=self.offsets)

    def driver(self, scene: RobotScene, plan: GraspPlan, schedule: Schedule) -> Driver:
        """Return the driver from rest by the widest posture to the destination."""
        size = scene.conditions.hand
        _, q_open = scripted_plan(scene.task, _hand(size), self.offsets, size.side)
        return ScriptedDriver(plan.q_start, q_open, plan.q_goal, schedule.reach)

    def refuses(self, plan: GraspPlan) -> bool:
        """Return False: a script plays any posture."""
        return False

    def varied(self, plan: GraspPlan, point: Array) -> GraspPlan:
        """Return a plan with another palm, squeeze, arrival and grip."""
        return varied_around(plan, point)


@lru_cache(maxsize=8)
def _hand(size: HandSize) -> HandModel:
    """Return a hand by itself, which takes longer to build than to pose."""
    return HandModel.from_spec(build_hand(size))

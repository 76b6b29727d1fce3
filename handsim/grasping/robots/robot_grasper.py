"""A grasper that lets a robot hand follow a controller, and keeps its plans."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from handsim.digests import content_digest
from handsim.errors import FileError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_key import PlanKey, key_of
from handsim.grasping.planning.plan_store import PlanStore, StoredPlan
from handsim.grasping.robots.robot_grip import GRIP_SETTINGS
from handsim.grasping.robots.robot_movement import WIDER
from handsim.grasping.robots.robot_planner import RobotGrasps, plan_robot_grasp
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_start import ARRIVALS, clear_of_table
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.task import Task
from handsim.types import MEDIAN_HAND, HandSize

OPENING_SCALE = 1.0
"""Openings keep the width of the objects, whatever the size of the robot."""


@dataclass(frozen=True)
class RobotGrasper:
    """Grasps with a robot hand that follows a controller, on a free base.

    A plan is that of a person's hand, varied until the robot that follows it holds. It is stored
    and used again for the same controller, hand, task, object and physics.

    Attributes
    ----------
    people
        Grasps with the controller and a person's hand: whence a first plan comes.
    robot
        The hand.
    folder
        Where plans are kept, or None to keep them in memory alone.
    note
        Called with a line for each plan that is searched, or could not be stored.
    made
        Plans made by this grasper, by task.
    """

    people: ControllerGrasper
    robot: RobotHand
    folder: Path | None = None
    note: Callable[[str], None] | None = None
    made: dict[str, StoredPlan] = field(
        default_factory=dict[str, StoredPlan], repr=False, compare=False
    )

    def __getstate__(self) -> dict[str, Any]:
        """Return what another process needs; it maps postures anew."""
        return {name: value for name, value in vars(self).items() if name != "grasps"}

    @cached_property
    def grasps(self) -> RobotGrasps:
        """Makes the runs."""
        return RobotGrasps(
            self.people.controller, Retargeter(self.robot, opening_scale=OPENING_SCALE)
        )

    def conditions_of(self, conditions: Conditions) -> Conditions:
        """Return conditions with the base and the side of the robot."""
        size = replace(MEDIAN_HAND, side=self.robot.side)
        return replace(conditions, base="free", hand=size)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp ``task``; a plan that is missing is made first, for nominal conditions."""
        asked = self.conditions_of(conditions)
        scene = RobotScene.build(task, asked, self.robot)
        return self.grasps.run(scene, self.plan_for(task, asked))

    def plan_for(self, task: Task, conditions: Conditions) -> GraspPlan:
        """Return the stored plan of a task, or search and store it."""
        usual = self.conditions_of(Conditions())
        scene = RobotScene.build(task, usual, self.robot)
        key, store = key_of_robot(scene), self._store(scene)
        stored = self.made.get(task.name)
        if stored is None and store is not None:
            stored = store.entries().get(task.name)
        if stored is not None and stored.key == key:
            return stored.plan
        self._tell(f"plan of {task.name} is searched for this hand, which takes minutes")
        started = self._start(task, scene)
        starts = [replace(started, arrive=arrive) for arrive in ARRIVALS]
        plan, run = plan_robot_grasp(self.grasps, task, usual, starts)
        self.made[task.name] = made = StoredPlan(plan, run.outcome.success, key)
        if store is not None:
            try:
                store.add(task.name, made)
            except (FileError, OSError) as error:
                self._tell(f"plan of {task.name} is used, but could not be kept: {error}")
        return plan

    def _start(self, task: Task, scene: RobotScene) -> GraspPlan:
        """Return the plan of a person's hand with which a search begins."""
        of_person = Conditions(
            hand=HandSize(MEDIAN_HAND.length, MEDIAN_HAND.breadth, self.robot.side)
        )
        plan = self.people.plan_for(task, Scene.build(task, of_person))
        return clear_of_table(self.grasps.retargeter, scene, plan)

    def _store(self, scene: RobotScene) -> PlanStore | None:
        """Return the store of this hand's plans."""
        if self.folder is None:
            return None
        digest = f"{self.people.controller.digest} {key_of_robot(scene).hand}"
        owner = hashlib.sha256(digest.encode()).hexdigest()[:16]
        return PlanStore(self.folder / f"{owner}.json", owner)

    def _tell(self, line: str) -> None:
        if self.note is not None:
            self.note(line)


def key_of_robot(scene: RobotScene) -> PlanKey:
    """Return the key of plans for a nominal scene with a robot hand."""
    key = key_of(scene)
    settings = content_digest(key.physics, WIDER, OPENING_SCALE, GRIP_SETTINGS)
    return replace(key, physics=settings)

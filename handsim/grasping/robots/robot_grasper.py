"""A grasper that lets a robot hand follow a controller or a script, and keeps its plans."""

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from handsim.digests import content_digest
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.plan_key import PlanKey, key_of
from handsim.grasping.planning.plan_store import Note, PlanStore, StoredPlan, store_of
from handsim.grasping.robots.robot_clearance import CLEARANCE, RISES
from handsim.grasping.robots.robot_grip import GRIP_SETTINGS
from handsim.grasping.robots.robot_lead import Lead
from handsim.grasping.robots.robot_movement import WIDER
from handsim.grasping.robots.robot_planner import RobotGrasps, plan_robot_grasp
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_start import ARRIVALS, clear_of_table, palm_at_grasp
from handsim.grasping.rollout.record import Rollout
from handsim.objects.object import GraspObject
from handsim.recordings.phases import CUTOFF
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.task import Task
from handsim.types import MEDIAN_HAND, Base

OPENING_SCALE = 1.0
"""Openings keep the width of the objects, whatever the size of the robot."""


@dataclass(frozen=True)
class RobotGrasper:
    """Grasps with a robot hand that follows a person's, on a free or a mounted base.

    A plan is that of a person's hand, varied until the robot that follows it holds. It is stored
    and used again for the same lead, hand, base, task, object and physics.

    Attributes
    ----------
    lead
        What moves the person's hand that the robot follows.
    robot
        The hand.
    folder
        Where plans are kept, or None to keep them in memory alone.
    note
        Called with a line for each plan that is searched, or could not be stored.
    made
        Plans made by this grasper, by task.
    """

    lead: Lead
    robot: RobotHand
    folder: Path | None = None
    note: Note | None = None
    made: dict[str, StoredPlan] = field(
        default_factory=dict[str, StoredPlan], repr=False, compare=False
    )

    def __getstate__(self) -> dict[str, Any]:
        """Return what another process needs; it maps postures anew."""
        return {name: value for name, value in vars(self).items() if name != "grasps"}

    @cached_property
    def grasps(self) -> RobotGrasps:
        """Makes the runs."""
        return RobotGrasps(self.lead, Retargeter(self.robot, opening_scale=OPENING_SCALE))

    def usual(self, base: Base = "free") -> Conditions:
        """Return the conditions that are planned for."""
        return self.conditions_of(Conditions(base=base))

    def conditions_of(self, conditions: Conditions) -> Conditions:
        """Return conditions with the side of the robot, and a free base where none is mounted."""
        size = replace(MEDIAN_HAND, side=self.robot.side)
        base = "mounted" if conditions.base == "mounted" else "free"
        return replace(conditions, base=base, hand=size)

    def __call__(self, task: Task, conditions: Conditions) -> Rollout:
        """Grasp ``task``; a plan that is missing is made first, for nominal conditions."""
        of_robot = self.conditions_of(conditions)
        scene = RobotScene.build(task, of_robot, self.robot)
        kept = self.stored_for(task, of_robot.base)
        return self.grasps.run(scene, kept.plan, kept.mapped)

    def stored_for(self, task: Task, base: Base = "free") -> StoredPlan:
        """Return the stored plan of a task, or search and store it."""
        key = self._key(task, base)
        known = self._known(task, key)
        if known is not None and known.key == key:
            return known
        if self.note is not None:
            self.note(f"plan of {task.name} is searched for this hand, which takes minutes")
        starts = self._starts(task, base)
        with self.lead.planning(f"planning {task.name}") as progress:
            plan, run, mapped = plan_robot_grasp(
                self.grasps, task, self.usual(base), starts, progress=progress
            )
        self.made[task.name] = made = StoredPlan(plan, run.outcome.success, key, mapped=mapped)
        store = self._store(key)
        if store is not None:
            store.keep(task.name, made, self.note)
        return made

    def _known(self, task: Task, key: PlanKey) -> StoredPlan | None:
        """Return the plan kept of a task for this hand and base, be it for other settings."""
        made, store = self.made.get(task.name), self._store(key)
        if made is not None and made.key is not None and made.key.hand == key.hand:
            return made
        return None if store is None else store.entries().get(task.name)

    def _starts(self, task: Task, base: Base) -> list[GraspPlan]:
        """Return plans with which a search begins: by what a person's hand is told, and does.

        The plan kept for this hand comes first, if it is for other settings; then, on a mount, that
        for a free base.
        """
        of_person = replace(self.usual(), base="arm")
        told = self.lead.plan(task, of_person)
        done = replace(told, palm=palm_at_grasp(self.lead.run(task, of_person)))
        scene = RobotScene.build(task, self.usual(base), self.robot)
        clear = [clear_of_table(self.grasps.retargeter, scene, plan) for plan in (told, done)]
        starts = [replace(plan, arrive=arrive) for plan in clear for arrive in ARRIVALS]
        bases: tuple[Base, ...] = ("mounted", "free") if base == "mounted" else ("free",)
        known = [self._known(task, self._key(task, each)) for each in bases]
        return [*(each.plan for each in known if each is not None), *starts]

    def _key(self, task: Task, base: Base) -> PlanKey:
        """Return the key of plans for a task on a base."""
        return _usual_key(task, task.object, self.usual(base), self.robot)

    def _store(self, key: PlanKey) -> PlanStore | None:
        """Return the store of this hand's plans."""
        if self.folder is None:
            return None
        return store_of(self.folder, self.lead.digest, key.hand)


@lru_cache(maxsize=256)
def _usual_key(
    task: Task, grasp_object: GraspObject, conditions: Conditions, robot: RobotHand
) -> PlanKey:
    """Build the scene that is planned for and return its key."""
    return key_of_robot(RobotScene.build(task, conditions, robot))


def key_of_robot(scene: RobotScene) -> PlanKey:
    """Return the key of plans for a nominal scene with a robot hand."""
    key = key_of(scene, beside=())
    base = (CLEARANCE, RISES, "even")  # steps from reading to reading
    settings = (WIDER, OPENING_SCALE, CUTOFF, GRIP_SETTINGS, *base)
    return replace(key, physics=content_digest(key.physics, *settings))

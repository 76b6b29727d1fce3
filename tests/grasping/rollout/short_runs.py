"""Short runs in which nothing touches, by a driver that keeps what it is asked."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import Schedule
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import LOWER, UPPER
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")
SCHEDULE = Schedule(steps=(0.1,), hold=0.4, reach=0.05, squeeze=0.05)
"""Sixty-one readings: reach, squeeze, lift and a hold that is shaken."""


class Asking:
    """A driver that keeps what it is asked and follows what it reads."""

    name, reach = "asking", SCHEDULE.reach
    destination = np.linspace(LOWER, UPPER, 5)[2]

    def __init__(self):
        self.asked = []

    def start(self, n):
        return np.zeros((n, 1))

    def step(self, time, dt, reference, readings):
        self.asked.append((time, readings[0].copy(), dt, float(reference[0, 0])))
        return readings, reference + 1.0

    def coordinates(self, readings):
        return readings[:, :0]

    def arrived(self, reading):
        self.at_last = reading
        return True


@cache
def high_plan():
    """Far from the object, so that nothing touches."""
    plan, _ = scripted_plan(TASK, HandModel.from_spec(build_hand()))
    return replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.3])))


def made_with(task=TASK, **values):
    """A short run, its commands, scene, driver and plan."""
    scene = Scene.build(task, Conditions(**values))
    plan, driver = high_plan(), Asking()
    run = simulate(scene, plan, driver, DataGlove(), SCHEDULE)
    commands = Commands.of(plan, task, SCHEDULE).disturbed(scene.conditions, DataGlove())
    return SimpleNamespace(run=run, commands=commands, scene=scene, driver=driver, plan=plan)

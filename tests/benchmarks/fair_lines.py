"""What the learned path is worth in grasps: the same planning for it and for straight lines.

Run: .venv/bin/python -m tests.benchmarks.fair_lines [--ways NAME ...] [--tasks NAME ...] [--jobs N]

``learned`` follows the built-in controller, ``components`` a straight line in its components and
``joints`` one in the space of the 22 joints, both with minimum jerk and both in the closed loop of
the learned path. Each way has plans searched for it, by the search that `handsim grasp` makes, from
the same starts and with the same seeds. Then come ten nominal and 20 perturbed runs a task.
"""

import argparse
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.plan import ramp
from handsim.grasping.planning import planner
from handsim.grasping.planning.grasper import Wanted, search_plan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.pool import processes
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import LearnedDriver, learned_driver
from handsim.learning.controller import GraspController
from handsim.learning.movement.timing import Timing
from handsim.tasks.table_one import TASKS, task_by_name
from tests.benchmarks.human_grasps import NOMINAL, PERTURBED

Way = Literal["learned", "components", "joints"]
BACK = 0.1
"""Time in which a line draws what has left it back [s]."""


def pace(time: float, duration: float) -> float:
    """Return the derivative of `ramp` by time [1/s]."""
    s = min(max(time / duration, 0.0), 1.0)
    return 30 * s**2 * (1 - s) ** 2 / duration


@dataclass(frozen=True)
class LineTiming:
    """Velocities along a straight line with minimum jerk."""

    z_start: np.ndarray
    z_goal: np.ndarray
    duration: float

    def velocities(self, z: np.ndarray, time: float) -> np.ndarray:
        way, done = self.z_goal - self.z_start, ramp(time, 0.0, self.duration)
        return pace(time, self.duration) * way + (self.z_start + done * way - z) / BACK


class LineController(GraspController):
    """A controller whose movements are straight lines."""

    def timing(self, z_start, z_goal, duration, grasped=None) -> Timing:
        return LineTiming(np.asarray(z_start), np.asarray(z_goal), duration)


class JointLineController(LineController):
    """The same in the space of joints: what the first posture has beside the components fades
    over the whole reach."""


def driver_of(controller, plan, lead, schedule, grasped=None) -> LearnedDriver:
    """Return a controller's driver as `learned_driver` does; lines in joints end as one."""
    driver = learned_driver(controller, plan, lead, schedule, grasped)
    if isinstance(controller, JointLineController):
        return replace(driver, widest_at=schedule.reach)
    return driver


def controller_for(way: Way) -> GraspController:
    """Return the built-in controller, or one that moves along lines in its place."""
    built_in = GraspController.load(data_folder("assets") / "controller.npz")
    kinds = {"components": LineController, "joints": JointLineController}
    if way == "learned":
        return built_in
    return kinds[way](**{name: getattr(built_in, name) for name in built_in.__dataclass_fields__})


def compared(way: Way, name: str) -> tuple[int, int, str]:
    """Plan a task for a way; return how many nominal and perturbed runs hold, and most failures."""
    planner.learned_driver = driver_of  # in this process alone: the search's and the runs' own
    controller, task, usual = controller_for(way), task_by_name(name), Conditions()
    plan = search_plan(controller, Wanted(task, usual)).plan
    nominal = [replace(usual, seed=seed) for seed in NOMINAL]
    trials = [*nominal, *(perturb(usual, seed) for seed in PERTURBED)]
    outcomes = [run_plan(controller, Scene.build(task, each), plan).outcome for each in trials]
    held = [outcome.success for outcome in outcomes]
    reasons = [outcome.reason for outcome in outcomes if outcome.reason]
    most = max(set(reasons), key=reasons.count) if reasons else ""
    return sum(held[: len(NOMINAL)]), sum(held[len(NOMINAL) :]), most


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ways", nargs="+", choices=get_args(Way), default=get_args(Way))
    parser.add_argument("--tasks", nargs="+", default=[task.name for task in TASKS])
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    jobs = [((way, name), (way, name)) for way in asked.ways for name in asked.tasks]
    found: dict[tuple[str, str], tuple[int, int, str]] = {}
    for key, result in processes(asked.jobs)(compared, jobs):
        found[key] = result
        print(*key, *result, flush=True)
    for way in asked.ways:
        rows = [found[way, name] for name in asked.tasks]
        nominal, perturbed = (sum(row[i] for row in rows) for i in (0, 1))
        n = len(asked.tasks)
        print(
            f"{way}: nominal {nominal / len(NOMINAL):.1f} of {n}, "
            f"perturbed {perturbed} of {len(PERTURBED) * n}"
        )


if __name__ == "__main__":
    main()

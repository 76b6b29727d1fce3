"""Search plans of the built-in controller longer than a command does, and store the better ones.

``python assets/search_plans.py TASK... [--seeds 4] [--generations 18] [--perturbed 3] [--first 100]
[--jobs 2]``

Each task is searched once for each seed, by turns from the stored plan and the usual starts, and
from the usual starts alone. What is found and the stored plan are then compared in runs that
neither a search nor a table of results has seen; the one that holds most often is stored, the
stored one if as many hold.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from handsim.cli.defaults import planning_grasper
from handsim.errors import HandsimError
from handsim.grasping.conditions import Conditions, made_hard, perturb
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.grasper import ATTEMPTS, ControllerGrasper
from handsim.grasping.planning.plan_key import key_for
from handsim.grasping.planning.plan_store import StoredPlan
from handsim.grasping.planning.planner import SEEDS, plan_grasp, run_plan
from handsim.grasping.pool import processes
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.tasks.table_one import task_by_name

FIRST_SEED = 100
"""Of a search, beyond those that commands use."""
USUAL = Conditions()
COMPARED = [
    *(replace(USUAL, seed=seed) for seed in range(7001, 7006)),
    *(perturb(USUAL, seed) for seed in range(7001, 7021)),
    *(made_hard(USUAL, seed, "friction") for seed in range(7001, 7006)),
]
"""Runs in which plans are compared: nominal, perturbed, and with a friction of 0.3."""


def n_held(controller: GraspController, name: str, plan: GraspPlan) -> int:
    """Return in how many of the runs in which plans are compared one holds."""
    task = task_by_name(name)
    scenes = [Scene.build(task, each) for each in COMPARED]
    carried = replace(plan, transport=shipped_transport())
    return sum(run_plan(controller, scene, carried).outcome.success for scene in scenes)


def searched(
    controller: GraspController,
    name: str,
    known: GraspPlan | None,
    seed: int,
    generations: int,
    n_perturbed: int,
) -> tuple[int, GraspPlan]:
    """Search from one seed; return how often what is found holds, and the plan."""
    plan, _ = plan_grasp(
        controller,
        task_by_name(name),
        USUAL,
        known,
        generations=generations,
        n_perturbed=n_perturbed,
        seed=seed,
    )
    return n_held(controller, name, plan), plan


def search(grasper: ControllerGrasper, asked: argparse.Namespace) -> None:
    """Search all tasks at once and store what is better than what is stored."""
    started, controller, plans = perf_counter(), grasper.controller, grasper.read()
    pool = processes(asked.jobs)
    arguments = [(name, (controller, name, plans[name])) for name in asked.tasks if name in plans]
    most = dict.fromkeys(asked.tasks, 0) | dict(pool(n_held, arguments))
    seeds = range(asked.first, asked.first + asked.seeds * SEEDS, SEEDS)
    effort = (asked.generations, asked.perturbed)
    jobs = [
        (name, (controller, name, None if i % 2 else plans.get(name), seed, *effort))
        for i, seed in enumerate(seeds)
        for name in asked.tasks
    ]
    for name, (held, plan) in pool(searched, jobs):
        took, of = perf_counter() - started, len(COMPARED)
        sys.stderr.write(f"{took:.0f} s: {name} held {held} of {of}, so far {most[name]}\n")
        if held > most[name]:
            most[name], task = held, task_by_name(name)
            success = run_plan(controller, Scene.build(task, USUAL), plan).outcome.success
            stored = StoredPlan(plan, success, key_for(task, USUAL), max(ATTEMPTS, asked.seeds))
            grasper.keep(task, stored)


def main() -> None:
    """Search and store."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="+", type=lambda name: task_by_name(name).name)
    parser.add_argument("--controller", type=Path)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--generations", type=int, default=18)
    parser.add_argument("--perturbed", type=int, default=3)
    parser.add_argument("--first", type=int, default=FIRST_SEED, help="the first seed")
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    search(planning_grasper(asked.controller, USUAL), asked)


if __name__ == "__main__":
    try:
        main()
    except HandsimError as error:
        sys.exit(str(error))

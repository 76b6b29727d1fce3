"""Many grasps at once, on MuJoCo's batches of simulations.

Runs whose models have one shape (seeds, frictions, masses, sizes of the hand, plans) share a batch;
others are made side by side. Either way each comes out as `simulate` makes it, bit for bit.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import os
from collections.abc import Hashable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import replace
from importlib.util import find_spec

import mujoco

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver, learned_driver
from handsim.grasping.rollout.lockstep import Job, Lockstep
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import run_alone
from handsim.grasping.silence import silent
from handsim.learning.controller import GraspController
from handsim.tasks.task import Task


def grasp_batch(
    controller: GraspController,
    task: Task,
    plan: GraspPlan,
    conditions: Iterable[Conditions],
    n_threads: int | None = None,
) -> list[Rollout]:
    """Grasp with a controller by one plan under many conditions, as `run_plan` does under one.

    Parameters
    ----------
    controller, task, plan
    conditions
        Of the runs: seeds, frictions, masses, places of the object, sizes of the hand.
    n_threads
        By default as many as there are processors.
    """
    scenes: dict[Conditions, Scene] = {}
    drivers: dict[tuple[str, bytes], Driver] = {}
    jobs = []
    for each in conditions:
        seen = replace(each, seed=0, nominal=True, shake=0.0)  # what makes no other scene
        if seen not in scenes:
            scenes[seen] = Scene.build(task, each)
        scene = replace(scenes[seen], conditions=each)
        key = (each.hand.side, scene.lead.tobytes())
        if key not in drivers:
            schedule = schedule_for(scene.task)
            drivers[key] = learned_driver(controller, plan, scene.lead, schedule)
        jobs.append(Job(scene, plan, drivers[key]))
    return simulate_batch(jobs, n_threads)


@silent()
def simulate_batch(jobs: Sequence[Job], n_threads: int | None = None) -> list[Rollout]:
    """Make many runs at once, each as `simulate` does.

    Every thread steps batches of its own, so that one reads and commands while others step.

    Parameters
    ----------
    jobs
    n_threads
        By default as many as there are processors.

    Returns
    -------
    list of Rollout
        In the order of the jobs.
    """
    n_threads = n_threads or os.cpu_count() or 1
    shards = [group[i::n_threads] for group in _groups(jobs) for i in range(n_threads)]
    shards = [shard for shard in shards if shard]
    with ThreadPoolExecutor(n_threads) as pool:
        made = pool.map(_made, ([jobs[i] for i in shard] for shard in shards))
        runs = {
            i: run
            for shard, each in zip(shards, made, strict=True)
            for i, run in zip(shard, each, strict=True)
        }
    return [runs[i] for i in range(len(jobs))]


def _groups(jobs: Sequence[Job]) -> list[list[int]]:
    """Return the jobs that can share a batch, by number: those whose models have one shape."""
    groups: dict[Hashable, list[int]] = {}
    for i, job in enumerate(jobs):
        scene, hand, model = job.scene, job.scene.hand, job.scene.hand.model
        # All sizes that a model counts, which is more than MuJoCo asks for but costs nothing.
        fields = [getattr(model, name) for name in dir(model) if name.startswith("n")]
        sizes = tuple(each for each in fields if isinstance(each, int))
        places = (scene.mocap, *hand.qpos_index.tolist(), model.names)
        groups.setdefault((sizes, places, model.opt.timestep), []).append(i)
    return list(groups.values())


def _made(jobs: Sequence[Job]) -> list[Rollout]:
    """Make runs of one shape, in a batch where MuJoCo has batches (since 4.0)."""
    if len(jobs) == 1 or find_spec("mujoco.batch") is None:
        return [_alone(job) for job in jobs]
    return [run or _alone(job) for run, job in zip(Lockstep(jobs).made(), jobs, strict=True)]


def _alone(job: Job) -> Rollout:
    """Make a run by itself, with a model and a state of its own: others may be using the scene."""
    model = copy(job.scene.hand.model)
    hand = replace(job.scene.hand, model=model, data=mujoco.MjData(model))
    scene = replace(job.scene, hand=hand)
    return run_alone(scene, job.plan, job.driver, job.glove, job.schedule)

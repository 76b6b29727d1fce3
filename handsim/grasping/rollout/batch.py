"""Many grasps at once, on MuJoCo's batches of simulations.

Runs whose models have one shape share a batch: those that differ in seed, friction, mass, hand size
or plan. Each run gives the same bits as by `simulate`.
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

from handsim.errors import UnknownNameError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.rollout._stepping import DEVICES, Device
from handsim.grasping.rollout._warp_worlds import need_warp, shared_key
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver, learned_driver
from handsim.grasping.rollout.jobs import Job, command_key
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import run_jobs
from handsim.learning.controller import GraspController
from handsim.silence import silent
from handsim.tasks.task import Task


def grasp_batch(
    controller: GraspController,
    task: Task,
    plan: GraspPlan,
    conditions: Iterable[Conditions],
    n_threads: int | None = None,
    device: Device = "cpu",
) -> list[Rollout]:
    """Grasp with a controller by one plan under many conditions, as `run_plan` does under one.

    Parameters
    ----------
    controller, task, plan
    conditions
        One for each run: seed, friction, mass, place of the object, size of the hand.
    n_threads
        By default one for each processor.
    device
        As in `simulate_batch`.

    Raises
    ------
    InputError, MissingToolError
        As `simulate_batch`.
    """
    scenes: dict[Conditions, Scene] = {}
    drivers: dict[tuple[str, bytes], Driver] = {}
    jobs = []
    for each in conditions:
        built_for = replace(each, seed=0, nominal=True, shake=0.0)  # these leave the scene as it is
        if built_for not in scenes:
            scenes[built_for] = Scene.build(task, each)
        scene = replace(scenes[built_for], conditions=each)
        key = (each.hand.side, scene.lead.tobytes())
        if key not in drivers:
            schedule = schedule_for(scene.task)
            drivers[key] = learned_driver(
                controller, plan, scene.lead, schedule, scene.task.object_name
            )
        jobs.append(Job(scene, plan, drivers[key]))
    return simulate_batch(jobs, n_threads, device)


@silent()
def simulate_batch(
    jobs: Sequence[Job], n_threads: int | None = None, device: Device = "cpu"
) -> list[Rollout]:
    """Make many runs at once, each as `simulate` does.

    Every thread has batches of its own, so that one reads and commands while others step.

    Parameters
    ----------
    jobs
    n_threads
        By default one for each processor. ``warp`` has one.
    device
        ``warp`` steps all runs of one shape together with mujoco_warp, on a GPU where there is one,
        in single precision. A run that it has no room for is made by MuJoCo.

    Returns
    -------
    list of Rollout
        In the order of the jobs.

    Raises
    ------
    UnknownNameError
        If there is no such device.
    MissingToolError
        If mujoco_warp is not installed.
    InputError
        If mujoco_warp lacks something that a scene has.
    """
    if device not in DEVICES:
        raise UnknownNameError("device", device, DEVICES)
    if device == "warp":
        return _in_worlds(jobs)
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


def _in_worlds(jobs: Sequence[Job]) -> list[Rollout]:
    """Make runs in the worlds of mujoco_warp, as many together as can be."""
    need_warp()
    runs: dict[int, Rollout] = {}
    for group in _groups(jobs):
        alike: dict[Hashable, list[int]] = {}
        for i in group:
            alike.setdefault(shared_key(jobs[i].scene.hand.model), []).append(i)
        for numbers in alike.values():
            made = run_jobs([jobs[i] for i in numbers], device="warp")
            for i, run in zip(numbers, made, strict=True):
                runs[i] = run or _by_itself(jobs[i])
    return [runs[i] for i in range(len(jobs))]


def _groups(jobs: Sequence[Job]) -> list[list[int]]:
    """Return the numbers of jobs that can share a batch: their models have one shape.

    Within a group, jobs that are commanded together follow each other.
    """
    groups: dict[Hashable, dict[Hashable, list[int]]] = {}
    for i, job in enumerate(jobs):
        scene, hand, model = job.scene, job.scene.hand, job.scene.hand.model
        # All sizes of a model, which is more than MuJoCo asks for but costs nothing.
        fields = [getattr(model, name) for name in dir(model) if name.startswith("n")]
        sizes = tuple(each for each in fields if isinstance(each, int))
        places = (scene.mocap, *hand.qpos_index.tolist(), model.names)
        shape = (sizes, places, model.opt.timestep)
        groups.setdefault(shape, {}).setdefault(command_key(job), []).append(i)
    return [[i for alike in group.values() for i in alike] for group in groups.values()]


def _made(jobs: Sequence[Job]) -> list[Rollout]:
    """Make runs of one shape, in a batch where MuJoCo has batches (since 4.0)."""
    if len(jobs) == 1 or find_spec("mujoco.batch") is None:
        return [_by_itself(job) for job in jobs]
    return [run or _by_itself(job) for run, job in zip(run_jobs(jobs), jobs, strict=True)]


def _by_itself(job: Job) -> Rollout:
    """Make a run by itself, in a copy of its scene, since other threads may use the scene."""
    model = copy(job.scene.hand.model)
    hand = replace(job.scene.hand, model=model, data=mujoco.MjData(model))
    (run,) = run_jobs([replace(job, scene=replace(job.scene, hand=hand))])
    assert run is not None  # only a batch leaves runs out
    return run

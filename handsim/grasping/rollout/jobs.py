"""Runs that are to be made, and which of them are commanded together."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import DataGlove
from handsim.types import Array, Index

COMMANDS = ("ctrl", "mocap_pos", "mocap_quat")
"""MuJoCo's arrays that a run commands."""


@dataclass(frozen=True)
class Job:
    """One run to be made.

    Jobs that share a driver object are commanded together, which is faster.

    Attributes
    ----------
    scene
        Scene of the task.
    plan
        Where palm and fingers go.
    driver
        What moves the fingers during the reach.
    schedule
        Timing; by default that of the task.
    glove
        How the joints are read; by default with 1 degree steps and noise.
    """

    scene: Scene
    plan: GraspPlan
    driver: Driver
    schedule: Schedule | None = None
    glove: DataGlove = field(default_factory=DataGlove)

    @property
    def run_schedule(self) -> Schedule:
        """The schedule, or that of the task."""
        return self.schedule or schedule_for(self.scene.task)


def command_key(job: Job) -> Hashable:
    """Return a key that is equal for jobs which are commanded together."""
    palm = job.scene.hand.model.body("palm")
    wrist = (job.scene.conditions.hand.side, *palm.pos.tolist(), *palm.quat.tolist())
    return id(job.driver), job.glove, job.run_schedule, wrist


@dataclass(frozen=True)
class Group:
    """Runs that are commanded together: they share driver, schedule, glove and wrist.

    Attributes
    ----------
    driver, glove, wrist
        What they share.
    commands
        Those of all the runs (`Commands.together`).
    last
        Row of the first reading after the reach, at which the rest of the run is commanded.
    qpos_index, ctrl_index
        Where the hand's joints and actuators are in MuJoCo's arrays.
    qpos : (n_runs, nq)
        Positions of the simulations, a live view.
    ctrl, mocap_pos, mocap_quat : (n_readings, n_runs, ...)
        What the runs are commanded, written reading by reading.
    """

    driver: Driver
    glove: DataGlove
    wrist: Wrist
    commands: Commands
    last: int
    qpos_index: Index
    ctrl_index: Index
    qpos: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array

    def command(self, tick: int) -> None:
        """Read the gloves and write the commands of a reading, and at ``last`` of all that follow.

        Does nothing once all is commanded.
        """
        n = len(self.commands.times)
        if tick > self.last or tick >= n:
            return
        rows = tick if tick < self.last else slice(tick, n)
        commands = self.commands
        readings = self.glove.reading(self.qpos[:, self.qpos_index], commands.disturbance[tick])
        targets = self.driver.targets(float(commands.times[tick]), readings)
        ctrl = commands.commanded(targets, rows)
        self.ctrl[rows][..., self.ctrl_index] = ctrl
        self.mocap_pos[rows], self.mocap_quat[rows] = self.wrist.forearm(
            commands.palm_pos[rows], commands.palm_quat[rows], ctrl
        )


def commands_of(jobs: Sequence[Job]) -> list[Commands]:
    """Return the commands of each run; what differs in disturbances alone is made once."""
    undisturbed: dict[Hashable, Commands] = {}
    found = []
    for job in jobs:
        task, schedule = job.scene.task, job.run_schedule
        key = (id(job.plan), id(task), schedule)
        if key not in undisturbed:
            undisturbed[key] = Commands.of(job.plan, task, schedule)
        found.append(undisturbed[key].disturbed(job.scene.conditions, job.glove))
    return found


def groups_of(
    jobs: Sequence[Job], commands: Sequence[Commands], qpos: Array, samples: Mapping[str, Array]
) -> list[Group]:
    """Gather the runs that are commanded together.

    Parameters
    ----------
    jobs, commands
        Of each run.
    qpos : (n_runs, nq)
        Positions of their simulations.
    samples
        Where commands go: `COMMANDS` by name, (n_readings, n_runs, ...).
    """
    groups = []
    for _, members in groupby(range(len(jobs)), key=lambda i: command_key(jobs[i])):
        runs = list(members)
        job, hand = jobs[runs[0]], jobs[runs[0]].scene.hand
        together = Commands.together([commands[i] for i in runs])
        where = slice(runs[0], runs[-1] + 1)
        group = Group(
            job.driver,
            job.glove,
            Wrist(hand.model),
            together,
            int(np.searchsorted(together.times, job.driver.reach, side="right")),
            hand.qpos_index,
            hand.ctrl_index,
            qpos[where],
            *(samples[name][:, where] for name in COMMANDS),
        )
        groups.append(group)
    return groups

"""Runs of one shape in one batch of MuJoCo, reading after reading.

MuJoCo steps a batch as it steps each simulation by itself, to the bit, and so does what is here:
arrays over runs are only added, multiplied and compared element by element, and where single runs
multiply vectors and matrices there are as many such products.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.record import Rollout, record_of
from handsim.grasping.rollout.run import LOOKED_AT, diverged, steps_per_reading
from handsim.grasping.rollout.sensing import Senses
from handsim.hand.model import HandModel
from handsim.joints import CONTACT_PARTS, N_JOINTS, clip_to_range
from handsim.types import Array, Index


@dataclass(frozen=True)
class Job:
    """One run that is to be made: what `simulate` is given.

    Runs of the same driver are driven together, so that it pays to give equal ones as one object.

    Attributes
    ----------
    scene, plan, driver
    schedule
        Timing; by default that of the task.
    glove
        How the joints are read.
    """

    scene: Scene
    plan: GraspPlan
    driver: Driver
    schedule: Schedule | None = None
    glove: DataGlove = field(default_factory=DataGlove)


class Lockstep:
    """Runs that share a batch; arrays over readings are (n_runs, n_readings, ...).

    Parameters
    ----------
    jobs
        Their models have one shape.
    """

    def __init__(self, jobs: Sequence[Job]) -> None:
        from mujoco.batch import Batch

        self.jobs = jobs
        self.hand, self.mocap = jobs[0].scene.hand, jobs[0].scene.mocap
        self.batch = Batch(self.hand.model, len(jobs), 1)
        self.batch.set_models([job.scene.hand.model for job in jobs])
        self.senses = Senses(self.hand.model)
        self.sensed = self.batch.bind("sensordata")[:, self.senses.first :]
        self.all_commands = _all_commands(jobs)
        self.teams = _teams(jobs, self.all_commands)
        self.ends = np.array([len(commands.times) for commands in self.all_commands])
        self.unstable = np.zeros(len(jobs), dtype=bool)
        self.unseen = np.zeros(len(jobs), dtype=bool)
        shape = (len(jobs), int(self.ends.max()))
        places = self.commanded() | self.visible()
        self.samples: dict[str, Array] = {
            name: np.zeros((*shape, *at.shape[1:])) for name, at in places.items()
        }
        self.samples["contact_force"] = np.zeros((*shape, len(CONTACT_PARTS)))
        self.samples["penetration"] = np.zeros(shape)
        self.samples["poses"] = np.zeros((*shape, self.senses.n_poses))
        # Of the last readings: velocities after them, counts of warnings, and what sensors told.
        n_warnings, recent = self.batch.warning.shape[1], (len(jobs), LOOKED_AT)
        self.after = np.zeros((*recent, self.hand.model.nv))
        self.warned = np.zeros((*recent, n_warnings), dtype=np.int32)
        self.told = np.zeros((*recent, self.sensed.shape[1]))

    def commanded(self) -> dict[str, Array]:
        """Return where the batch takes commands, (n_runs, ...), by name."""
        bind = self.batch.bind
        return {"ctrl": bind("ctrl")} | {
            name: bind(name)[:, self.mocap] for name in ("mocap_pos", "mocap_quat")
        }

    def visible(self) -> dict[str, Array]:
        """Return where the batch has what is kept as it is, (n_runs, ...), by name."""
        return {name: self.batch.bind(name) for name in ("qpos", "qvel")}

    def made(self) -> list[Rollout | None]:
        """Make the runs; None for one that had more contacts than its sensors could tell."""
        self.start()
        batch, samples = self.batch, self.samples
        sent = [(samples[name], at) for name, at in self.commanded().items()]
        kept = [(samples[name], at) for name, at in self.visible().items()]
        warnings, substeps = batch.warning[:, :, 1], steps_per_reading(self.hand.model)
        qpos, qvel, sensed = batch.bind("qpos"), batch.bind("qvel"), self.sensed
        n = int(self.ends.max())
        for tick in range(n):
            active, recent = self.ends > tick, tick % LOOKED_AT
            for team in self.teams:
                team.command(tick, qpos, samples)
            for rows, place in sent:
                place[:] = rows[:, tick]
            for rows, place in kept:
                rows[:, tick] = place
            self.told[:, recent] = sensed
            batch.step(active, nstep=substeps)
            self.after[:, recent], self.warned[:, recent] = qvel, warnings
            if recent + 1 == LOOKED_AT or tick + 1 == n:
                self.look_at(tick - recent, recent + 1)
        return [self.run(i) for i in range(len(self.jobs))]

    def look_at(self, start: int, n: int) -> None:
        """Take in what was told in the last ``n`` readings, and end runs that have diverged."""
        samples, rows, told = self.samples, slice(start, start + n), self.told[:, :n]
        force, depth, crowded = self.senses.contacts(told.reshape(-1, told.shape[-1]))
        samples["contact_force"][:, rows] = force.reshape(len(told), n, -1)
        samples["penetration"][:, rows] = depth.reshape(len(told), n)
        samples["poses"][:, rows] = told[:, :, : self.senses.n_poses]
        bad = diverged(self.after[:, :n], self.warned[:, :n])
        bad &= np.arange(start, start + n) < self.ends[:, None]
        for i in np.flatnonzero(bad.any(axis=1)):
            self.ends[i], self.unstable[i] = start + int(bad[i].argmax()) + 1, True
        within = np.arange(start, start + n) < self.ends[:, None]
        self.unseen |= (crowded.reshape(len(told), n) & within).any(axis=1)

    def start(self) -> None:
        """Put hands and forearms at the start, at rest, as `HandModel.set_posture` does."""
        batch, hand = self.batch, self.hand
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        qpos, ctrl = batch.bind("qpos"), batch.bind("ctrl")
        free = int(hand.model.joint("forearm").qposadr[0])
        for i, (job, commands) in enumerate(zip(self.jobs, self.all_commands, strict=True)):
            model, q = job.scene.hand.model, job.plan.q_start
            pose = Wrist(model).forearm(commands.palm_pos[0], commands.palm_quat[0], q)
            qpos[i, free : free + 3], qpos[i, free + 3 : free + 7] = pose
            qpos[i, hand.qpos_index] = q
            ctrl[i, hand.ctrl_index] = np.clip(q, *model.actuator_ctrlrange[hand.ctrl_index].T)
        batch.forward()

    def run(self, i: int) -> Rollout | None:
        """Judge a run."""
        if self.unseen[i]:
            return None
        job, unstable = self.jobs[i], bool(self.unstable[i])
        # Copies, so that one run that is kept does not keep all others in memory.
        seen = {name: rows[i, : self.ends[i]].copy() for name, rows in self.samples.items()}
        seen |= self.senses.poses(seen.pop("poses"))
        return record_of(
            job.scene, self.all_commands[i], job.driver, job.glove, seen, unstable=unstable
        )


@dataclass(frozen=True)
class _Team:
    """Runs of one driver, timing, glove and wrist: their commands are arrays over all of them.

    Attributes
    ----------
    driver, glove, hand, wrist, times
        What they have in common.
    members : (n,)
        Numbers of the runs.
    closed
        First reading at which the targets are what they are for good.
    palm_pos, palm_quat, added, disturbance
        Of their all_commands, (n, n_readings, ...).
    """

    driver: Driver
    glove: DataGlove
    hand: HandModel
    wrist: Wrist
    times: Array
    members: Index
    closed: int
    palm_pos: Array
    palm_quat: Array
    added: Array
    disturbance: Array

    def command(self, tick: int, qpos: Array, samples: dict[str, Array]) -> None:
        """Read the gloves and lay down where actuators and forearms go.

        From reading ``closed`` on nothing is left to be done: then all of the rest is laid down.
        """
        if tick > self.closed or tick >= len(self.times):
            return
        rows = slice(tick, tick + 1 if tick < self.closed else len(self.times))
        q = qpos[self.members[:, None], self.hand.qpos_index]
        reading = self.glove.reading(q, self.disturbance[:, tick])
        targets = self.driver.targets(float(self.times[tick]), reading)
        ctrl = clip_to_range(targets[..., None, :] + self.added[:, rows])
        pos, quat = self.wrist.forearms(
            self.palm_pos[:, rows].reshape(-1, 3),
            self.palm_quat[:, rows].reshape(-1, 4),
            ctrl.reshape(-1, N_JOINTS),
        )
        there = np.ix_(self.members, np.arange(rows.start, rows.stop))
        samples["ctrl"][(*(axis[..., None] for axis in there), self.hand.ctrl_index)] = ctrl
        samples["mocap_pos"][there] = pos.reshape(*ctrl.shape[:2], 3)
        samples["mocap_quat"][there] = quat.reshape(*ctrl.shape[:2], 4)


def _all_commands(jobs: Sequence[Job]) -> list[Commands]:
    """Lay down the runs; what differs in noise alone is laid down once."""
    undisturbed: dict[Hashable, Commands] = {}
    all_commands = []
    for job in jobs:
        task = job.scene.task
        schedule = job.schedule or schedule_for(task)
        key = (id(job.plan), id(task), schedule)
        if key not in undisturbed:
            undisturbed[key] = Commands.of(job.plan, task, schedule)
        all_commands.append(undisturbed[key].disturbed(job.scene.conditions, job.glove))
    return all_commands


def _teams(jobs: Sequence[Job], all_commands: Sequence[Commands]) -> list[_Team]:
    """Gather the runs that are commanded together."""
    members: dict[Hashable, list[int]] = {}
    for i, (job, commands) in enumerate(zip(jobs, all_commands, strict=True)):
        palm = job.scene.hand.model.body("palm")
        wrist = (job.scene.conditions.hand.side, *palm.pos.tolist(), *palm.quat.tolist())
        key = (id(job.driver), job.glove, commands.schedule, wrist)
        members.setdefault(key, []).append(i)
    teams = []
    for those in members.values():
        job, times = jobs[those[0]], all_commands[those[0]].times
        team = _Team(
            job.driver,
            job.glove,
            job.scene.hand,
            Wrist(job.scene.hand.model),
            times,
            np.array(those),
            int(np.searchsorted(times, job.driver.reach, side="right")),
            *(
                np.stack([getattr(all_commands[i], name) for i in those])
                for name in ("palm_pos", "palm_quat", "added", "disturbance")
            ),
        )
        teams.append(team)
    return teams

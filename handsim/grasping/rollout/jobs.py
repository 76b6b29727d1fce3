"""Runs that are to be made, and which of them are commanded together."""

import math
from collections import deque
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from handsim.arm.arm_strength import leading_targets
from handsim.grasping.gripping.grip import GripLayer, Ungripped, shares_of
from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.rollout._stepping import COMMANDS, Simulations
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import WRIST_COLUMNS, Wrist
from handsim.grasping.rollout.glove import RATE, DataGlove, Measured
from handsim.grasping.rollout.sensing import Sensors
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, LOWER, UPPER
from handsim.types import Array, Index

FEELING = 0.25
"""Time constant with which an arm that carries something is put where it was to be [s]: people see
and feel that it sags, and lift more."""
MOST_FELT = 0.3
"""Most that targets are moved for it [rad]: half of what a joint's greatest torque asks for."""
_FELT = 1.0 / (FEELING * RATE)


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
    gripped
        Whether the grip layer holds forces; otherwise the driver's targets go to the actuators.
    """

    scene: Scene
    plan: GraspPlan
    driver: Driver
    schedule: Schedule | None = None
    glove: DataGlove = field(default_factory=DataGlove)
    gripped: bool = True

    @property
    def run_schedule(self) -> Schedule:
        """The schedule, or that of the task."""
        return self.schedule or schedule_for(self.scene.task)


def command_key(job: Job) -> Hashable:
    """Return a key that is equal for jobs which are commanded together."""
    palm = job.scene.hand.model.body("palm")
    wrist = (job.scene.conditions.hand.side, *palm.pos.tolist(), *palm.quat.tolist())
    grasp = (
        job.scene.conditions.base,
        job.scene.task.name,
        job.plan.squeeze,
        job.scene.conditions.latency,
        job.gripped,
    )
    return id(job.driver), job.glove, job.run_schedule, wrist, grasp


@dataclass(frozen=True)
class ArmCommands:
    """What the arms of some runs are commanded.

    Attributes
    ----------
    qpos, ctrl
        Where the arms' joints and actuators are in MuJoCo's arrays.
    path, arm, wrist : (n_readings, n_runs, 5), twice, and (n_readings, n_runs, 2) [rad]
        Where arms are to be, targets that lead as compliant joints need it, and those of wrists.
    """

    qpos: slice | Index
    ctrl: slice | Index
    path: Array
    arm: Array
    wrist: Array

    @classmethod
    def of(cls, scene: Scene, commands: Sequence[Commands]) -> "ArmCommands | None":
        """Return those of some runs; None where no arm carries the hand."""
        if scene.arm is None:
            return None
        found = [each.reach for each in commands if each.reach is not None]
        geometry = scene.arm.geometry
        paths = [each.arm for each in found]
        arms = [leading_targets(path, 1.0 / RATE, geometry) for path in paths]
        made = (np.stack(each, axis=1) for each in (paths, arms, [each.wrist for each in found]))
        return cls(_slice_of(scene.arm_qpos), _slice_of(scene.arm_ctrl), *made)


@dataclass
class Group:
    """Runs that are commanded together: they share driver, schedule, glove and wrist.

    Attributes
    ----------
    driver, glove, wrist
        What they share.
    commands
        Those of all the runs (`Commands.together`).
    grip
        Holds the forces of their fingers.
    last
        Row of the first reading after the reach, from which on the driver is not asked.
    delay
        Age of what is measured, in readings.
    hand
        Where the hand's joints and actuators are in MuJoCo's arrays.
    sensors
        What the sensors' values mean.
    qpos, sensordata : (n_runs, nq), (n_runs, n_values)
        Of the simulations, live views.
    ctrl, mocap_pos, mocap_quat : (n_readings, n_runs, ...)
        What the runs are commanded, written reading by reading. With an arm the latter two say
        where the palm is to be.
    reach
        Angles of the arms; None without.
    """

    driver: Driver
    glove: DataGlove
    wrist: Wrist
    commands: Commands
    grip: GripLayer | Ungripped
    last: int
    delay: int
    hand: HandModel
    sensors: Sensors
    qpos: Array
    sensordata: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array
    reach: "ArmCommands | None" = None

    def __post_init__(self) -> None:
        """Begin where the driver begins."""
        self._reference = self.driver.start(len(self.qpos))
        self._measured: deque[Measured] = deque(maxlen=self.delay + 1)
        self._told: Array = np.empty(0)
        self._sags: Array = np.zeros(1)
        self._held: list[list[float]] = []
        self._way: Array = np.empty(0)
        self._target: Array = np.empty(0)
        self._arrived = False
        # Numbers are faster than arrays of one, and slices than indices that follow each other.
        self._joints_ctrl = _slice_of(self.hand.ctrl_index)
        gripped = isinstance(self.grip, GripLayer)
        self._flexes = [gripped and any(row) for row in self.commands.flexion.tolist()]
        self._closed: list[float] = self.commands.closed.tolist()
        self._any_lost = [any(row) for row in self.commands.lost.tolist()]
        if self.reach is not None:
            self.ctrl[:, :, self.reach.ctrl] = self.reach.arm
            self.mocap_pos[:] = self.commands.palm_pos
            self.mocap_quat[:] = self.commands.palm_quat

    def measure(self, tick: int) -> None:
        """Read gloves and fingertips."""
        if tick < len(self.commands.times):
            self._measured.append(self._measure(tick))

    def seen(self) -> tuple[Array, Array, Array]:
        """Return where the driver means runs to be, what it reads, and what gloves do (n, 22)."""
        now = self._measured[0]
        return self._reference, self._reading(now), self.glove.reading(now.q, now.noise)

    def command(self, tick: int) -> None:
        """Write the commands that follow from what was measured."""
        commands = self.commands
        if tick >= len(commands.times):
            return
        measured = self._measured[0]
        told = self._tell(tick, measured)
        acting = tick >= commands.action
        slip = load = None
        if acting and commands.lifted:
            slip = self._slip(tick > commands.action)
            load = (self.sensors.carried(self.sensordata) / commands.weight[tick]).tolist()
        closed = self._closed[tick]
        if self.grip.feel(measured.forces):
            self.grip.touch(self._reading(measured))
        q = self.grip.command(told, slip, load, closed, 1.0 / RATE, acting=acting)
        if self._flexes[tick]:
            q = q + commands.flexion[tick]
        q = np.minimum(np.maximum(q, LOWER), UPPER)
        ctrl = self.ctrl[tick]
        if self.reach is not None:
            q[:, WRIST_COLUMNS] = self.reach.wrist[tick]
            if slip is not None:
                self._sags = self._sags + (self.reach.path[tick] - self.qpos[:, self.reach.qpos])
                ctrl[:, self.reach.ctrl] += np.minimum(
                    np.maximum(_FELT * self._sags, -MOST_FELT), MOST_FELT
                )
        ctrl[:, self._joints_ctrl] = q

    def _slip(self, known: bool) -> list[float]:
        """Return how fast the objects move in the palms [m/s]; 0 where it is not known before."""
        held = self.sensors.held(self.sensordata).tolist()
        before, self._held = self._held if known else held, held
        return [
            RATE * math.sqrt((x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c))
            for (x, y, z), (a, b, c) in zip(held, before, strict=True)
        ]

    def _measure(self, tick: int) -> Measured:
        """Return what is measured now, without what is lost of it."""
        commands, q = self.commands, self.qpos.take(self.hand.qpos_index, axis=1)
        forces = self.sensors.finger_forces(self.sensordata)
        measured = Measured(q, commands.disturbance[tick], None, forces)
        if self.reach is not None:
            # Until the driver has told something, the wrist is read as it is.
            told = self._told if tick else self._reading(measured)
            measured = measured._replace(wrist=told[:, WRIST_COLUMNS])
        if self._any_lost[tick] and self._measured:
            return measured.without(commands.lost[tick], self._measured[-1])
        return measured

    def _reading(self, measured: Measured) -> Array:
        """Return what the gloves read, (n_runs, 22) [rad]."""
        reading = self.glove.reading(measured.q, measured.noise)
        if measured.wrist is not None:
            reading[:, WRIST_COLUMNS] = measured.wrist
        return reading

    def _tell(self, tick: int, measured: Measured) -> Array:
        """Return where the hand is to go (n_runs, 22) [rad], and put the forearm there."""
        commands, driver = self.commands, self.driver
        if tick < self.last:
            time = float(commands.times[tick])
            reading = self._reading(measured)
            told, self._reference = driver.step(time, 1.0 / RATE, self._reference, reading)
            self._told = told if told.ndim > 1 else np.broadcast_to(told, reading.shape)
            if self.reach is None:
                self._carry(tick, self._told)
            return self._told
        if tick == self.last:
            self._way = driver.destination - self._told
            if self.reach is None:
                closed = commands.closed[tick:, None, None]
                self._carry(slice(tick, None), self._told + closed * self._way)
        if not self._arrived:
            closed = self._closed[tick]
            self._target, self._arrived = self._told + closed * self._way, closed == 1.0
        return self._target

    def _carry(self, rows: int | slice, told: Array) -> None:
        """Put the forearm where palm and wrist need it."""
        self.mocap_pos[rows], self.mocap_quat[rows] = self.wrist.forearm(
            self.commands.palm_pos[rows], self.commands.palm_quat[rows], told
        )


def _slice_of(index: Index) -> slice | Index:
    """Return a slice where indices follow each other."""
    first, n = int(index[0]), len(index)
    return slice(first, first + n) if np.array_equal(index, first + np.arange(n)) else index


def commands_of(jobs: Sequence[Job]) -> list[Commands]:
    """Return the commands of each run; what differs in disturbances alone is made once."""
    undisturbed: dict[Hashable, Commands] = {}
    found = []
    for job in jobs:
        task, schedule = job.scene.task, job.run_schedule
        size = job.scene.conditions.hand
        key = (id(job.plan), id(task), schedule, size)
        if key not in undisturbed:
            undisturbed[key] = Commands.of(job.plan, task, schedule, size)
        made = undisturbed[key].disturbed(job.scene.conditions, job.glove)
        arm = job.scene.arm
        found.append(made if arm is None else made.reached(arm, job.plan.q_goal))
    return found


def groups_of(
    jobs: Sequence[Job],
    commands: Sequence[Commands],
    simulations: Simulations,
    samples: Mapping[str, Array],
) -> list[Group]:
    """Gather the runs that are commanded together.

    Parameters
    ----------
    jobs, commands
        Of each run.
    simulations
        In which they are made.
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
            _grip_of([jobs[i] for i in runs], together.closing),
            int(np.searchsorted(together.times, job.driver.reach, side="right")),
            round(job.scene.conditions.latency * RATE),
            hand,
            simulations.sensors,
            simulations.qpos[where],
            simulations.sensordata[where],
            *(samples[name][: len(together.times), where] for name in COMMANDS),
            reach=ArmCommands.of(job.scene, [commands[i] for i in runs]),
        )
        groups.append(group)
    return groups


def _grip_of(jobs: Sequence[Job], closing: Array) -> GripLayer | Ungripped:
    """Return the grip layer of runs of one task."""
    if not jobs[0].gripped:
        return Ungripped()
    task = jobs[0].scene.task
    flexed = {finger for step in task.steps for finger in step.flex}
    return GripLayer(
        closing,
        shares_of(task.grasp.fingers),
        np.array([finger in flexed for finger in FINGERS]),
        np.array([job.plan.grip for job in jobs]),
    )

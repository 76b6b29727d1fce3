"""Runs that are to be made, and which of them are commanded together."""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from handsim.grasping.gripping.grip import GripLayer, Rows, Ungripped, shares_of
from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.rollout._stepping import COMMANDS, Simulations
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import WRIST_COLUMNS, CarryingArms, Wrist
from handsim.grasping.rollout.glove import RATE, DataGlove, LateGloves
from handsim.grasping.rollout.sensing import Sensors
from handsim.joints import FINGERS, LOWER, UPPER
from handsim.types import Array, Index

_LOWER: list[float] = LOWER.tolist()
_UPPER: list[float] = UPPER.tolist()


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


@dataclass
class Group:
    """Runs that are commanded together: they share driver, schedule, glove and wrist.

    Attributes
    ----------
    driver, wrist
        What they share.
    commands
        Those of all the runs (`Commands.together`).
    gloves
        What they measure.
    grip
        Holds the forces of their fingers.
    last
        Row of the first reading after the reach, from which on the driver is not asked.
    sensors
        What the sensors' values mean.
    sensordata : (n_runs, n_values)
        Of the simulations, a live view.
    ctrl : (n_readings, n_runs, 22) [rad]
        What the joints are commanded, written reading by reading.
    mocap_pos, mocap_quat : (n_readings, n_runs, 3) [m], (n_readings, n_runs, 4)
        Where forearms are to be, written likewise; with an arm, where palms are to be.
    arms
        None where no arm carries the hand.
    """

    driver: Driver
    wrist: Wrist
    commands: Commands
    gloves: LateGloves
    grip: GripLayer | Ungripped
    last: int
    sensors: Sensors
    sensordata: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array
    arms: CarryingArms | None = None

    def __post_init__(self) -> None:
        """Begin where the driver begins."""
        commands = self.commands
        self._reference = self.driver.start(len(self.sensordata))
        self._told, self._way, self._target = np.empty((3, 0))
        self._arrived = False
        self._carries: list[list[float]] = []
        self._held = self._carries
        # Numbers are faster than arrays of one.
        flexes = np.asarray(commands.flexion.any(axis=1)) & isinstance(self.grip, GripLayer)
        self._flexes: list[bool] = flexes.tolist()
        self._closed: list[float] = commands.closed.tolist()
        self._weights: list[float] = commands.weight.ravel().tolist()
        if self.arms is not None:
            self.mocap_pos[:] = commands.palm_pos
            self.mocap_quat[:] = commands.palm_quat

    def measure(self, tick: int) -> None:
        """Read gloves and fingertips."""
        if tick < len(self._closed):
            told = self._told if tick and self.arms is not None else None
            forces, self._carries = self.sensors.felt(self.sensordata)
            self.gloves.measure(tick, told, forces)

    def seen(self) -> tuple[Array, Array, Array]:
        """Return where the driver means runs to be, what it reads, and what gloves do (n, 22)."""
        return self._reference, self.gloves.read_by_driver(), self.gloves.read()

    def command(self, tick: int) -> None:
        """Write the commands that follow from what was measured."""
        if tick >= len(self._closed):
            return
        commands, grip, arms = self.commands, self.grip, self.arms
        told = self._tell(tick)
        acting = tick >= commands.action
        slip = load = None
        if acting and commands.lifted:
            slip, load = self._carrying(tick)
        if grip.feel(self.gloves.forces):
            grip.touch(self.gloves.read_by_driver())
        targets = grip.command(told, slip, load, self._closed[tick], 1.0 / RATE, acting=acting)
        if self._flexes[tick]:
            targets = np.asarray(targets) + commands.flexion[tick]
        self._write(tick, targets)
        if slip is not None and arms is not None:
            arms.lift(tick)

    def _write(self, tick: int, targets: Rows) -> None:
        """Command targets within the joints' ranges; the wrist's where an arm moves it."""
        ctrl, arms = self.ctrl[tick], self.arms
        if isinstance(targets, np.ndarray):
            np.minimum(np.maximum(targets, LOWER), UPPER, out=ctrl)
            if arms is not None:
                ctrl[:, WRIST_COLUMNS] = arms.wrist[tick]
            return
        within = [
            low if q < low else high if q > high else q
            for q, low, high in zip(targets[0], _LOWER, _UPPER, strict=True)
        ]
        if arms is not None:
            within[WRIST_COLUMNS] = arms.wrist_of_first(tick)
        ctrl[0] = within

    def _carrying(self, tick: int) -> tuple[list[float], list[float]]:
        """Return how fast objects move in the palms [m/s], and loads beside those expected.

        At the start of the action it is not known where they were before; they count as at rest.
        """
        now, first = self._carries, tick * len(self._carries)
        before, self._held = self._held if tick > self.commands.action else now, now
        slip = [
            RATE * math.sqrt((x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c))
            for (x, y, z, *_), (a, b, c, *_) in zip(now, before, strict=True)
        ]
        weights = self._weights[first : first + len(now)]
        return slip, [each[-1] / weight for each, weight in zip(now, weights, strict=True)]

    def _tell(self, tick: int) -> Array:
        """Return where the hand is to go (n_runs, 22) [rad], and put the forearm there."""
        commands, driver = self.commands, self.driver
        if tick < self.last:
            time, reading = float(commands.times[tick]), self.gloves.read_by_driver()
            told, self._reference = driver.step(time, 1.0 / RATE, self._reference, reading)
            self._told = told if told.ndim > 1 else np.broadcast_to(told, reading.shape)
            if self.arms is None:
                self._carry(tick, self._told)
            return self._told
        if tick == self.last:
            self._way = driver.destination - self._told
            if self.arms is None:
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


def _columns(places: Index) -> slice:
    """Return a slice for places that follow each other, with which arrays give views."""
    first, n = int(places[0]), len(places)
    assert np.array_equal(places, first + np.arange(n)), "joints are apart in MuJoCo's arrays"
    return slice(first, first + n)


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
        where = slice(runs[0], runs[-1] + 1)
        job, hand = jobs[runs[0]], jobs[runs[0]].scene.hand
        together = Commands.together([commands[i] for i in runs])
        n, qpos = len(together.times), simulations.qpos[where]
        ctrl, *mocap = (samples[name][:n, where] for name in COMMANDS)
        gloves = LateGloves(
            job.glove,
            together.disturbance,
            together.lost,
            round(job.scene.conditions.latency * RATE),
            qpos,
            samples["qpos"][:, where],
            hand.qpos_index,
        )
        group = Group(
            job.driver,
            Wrist(hand.model),
            together,
            gloves,
            _grip_of([jobs[i] for i in runs], together.closing),
            int(np.searchsorted(together.times, job.driver.reach, side="right")),
            simulations.sensors,
            simulations.sensordata[where],
            ctrl[:, :, _columns(hand.ctrl_index)],
            *mocap,
            arms=_arms_of(job.scene, [commands[i] for i in runs], qpos, ctrl),
        )
        groups.append(group)
    return groups


def _arms_of(
    scene: Scene, commands: Sequence[Commands], qpos: Array, ctrl: Array
) -> CarryingArms | None:
    """Return the arms that carry the hands of some runs; None where there are none."""
    postures = [each.reach for each in commands if each.reach is not None]
    if scene.arm is None:
        return None
    at, ctrl = qpos[:, _columns(scene.arm_qpos)], ctrl[:, :, _columns(scene.arm_ctrl)]
    return CarryingArms(postures, 1.0 / RATE, scene.arm.geometry, at, ctrl)


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

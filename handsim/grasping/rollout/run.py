"""Run one grasp or several in contact physics, from the glove's readings to records.

A hundred times a second glove and fingertips are read, the driver turns the reading into joint
targets, the grip layer makes them hold with a force, and the forearm is put where the palm's path
and the commanded wrist angles need it.

One run and several take the same way; only how MuJoCo steps differs (`_stepping`). Several give
the same bits as each by itself: arrays over runs are only added, multiplied and compared element
by element, and vectors are multiplied with matrices one by one.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.grasping.plan import GraspPlan, Schedule
from handsim.grasping.rollout._stepping import COMMANDS, Device, Simulations, simulations_of
from handsim.grasping.rollout.commands import LOST
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import WRIST_COLUMNS, Wrist
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.jobs import Job, commands_of, groups_of
from handsim.grasping.rollout.record import Rollout, read_by, record_of
from handsim.grasping.rollout.sensing import Touch
from handsim.joints import CONTACT_PARTS
from handsim.silence import silent
from handsim.types import Array, Mask

MAX_SPEED = 500.0
"""Joint or body speed above which a simulation is taken to have diverged [m/s or rad/s]."""
_SURELY_SLOW = 0.9 * MAX_SPEED**2
BAD_NUMBERS = tuple(
    int(kind)
    for kind in (
        mujoco.mjtWarning.mjWARN_BADCTRL,
        mujoco.mjtWarning.mjWARN_BADQPOS,
        mujoco.mjtWarning.mjWARN_BADQVEL,
        mujoco.mjtWarning.mjWARN_BADQACC,
    )
)
"""MuJoCo's warnings of infinite or undefined numbers. After all but the first of them MuJoCo
resets the simulation and goes on."""
CHECKED_EVERY = 50
"""Number of readings between two checks for divergence: a check at every reading would cost 4 % of
the steps."""
KEPT = 800
"""Readings of all runs together whose sensors are looked at together, which costs less than a few
at a time, and some 5 MB."""


@silent()
def simulate(
    scene: Scene,
    plan: GraspPlan,
    driver: Driver,
    glove: DataGlove | None = None,
    schedule: Schedule | None = None,
    brief: bool = False,
) -> Rollout:
    """Run one grasp and judge it.

    Parameters
    ----------
    scene, plan, driver, glove, schedule
        As in `Job`.
    brief
        End the run as soon as the object is lost, as a search may.

    Returns
    -------
    Rollout
        Cut short, with outcome ``unstable``, where the simulation diverges.
    """
    (rollout,) = run_jobs([Job(scene, plan, driver, schedule, glove or DataGlove())], brief=brief)
    assert rollout is not None  # only a batch leaves runs out
    return rollout


def run_jobs(
    jobs: Sequence[Job], *, brief: bool = False, device: Device = "cpu"
) -> list[Rollout | None]:
    """Make runs whose models have one shape.

    Parameters
    ----------
    jobs
        One run steps the model and data of its own scene, several step in a batch. Those with
        equal `command_key` should follow each other.
    brief
        End each run as soon as its object is lost.
    device
        What steps them.

    Returns
    -------
    list of Rollout or None
        None for a run of a batch that had more contacts than its sensors have slots for, or a
        device room for; it has to be made by itself.
    """
    runs = Runs(jobs, device)
    runs.start()
    while runs.tick < runs.end:
        for group in runs.groups:
            group.measure(runs.tick)
            group.command(runs.tick)
        runs.step()
        if brief:
            runs.end_lost(runs.tick - 1)
    return runs.records()


def diverged(qvel: Array, warnings: npt.NDArray[np.int32]) -> Mask:
    """Return whether simulations (...,) have diverged.

    Parameters
    ----------
    qvel : (..., nv) [m/s or rad/s]
    warnings : (..., n_kinds)
        How often MuJoCo gave each of its warnings.
    """
    slow = np.asarray(np.abs(qvel) <= MAX_SPEED).all(axis=-1)
    return np.asarray(~slow | warnings[..., list(BAD_NUMBERS)].any(axis=-1))


def has_diverged(qvel: Array, warnings: npt.NDArray[np.int32]) -> bool:
    """Return the same as `diverged` of one simulation, (nv,) and (n_kinds,); for loops."""
    # The length is seldom as great as one speed may be, and none where one of them is none.
    slow = qvel.dot(qvel) <= _SURELY_SLOW or all(abs(v) <= MAX_SPEED for v in qvel.tolist())
    counts = warnings.tolist()
    return not slow or (any(counts) and any(counts[kind] for kind in BAD_NUMBERS))


class _Recent:
    """What has yet to become samples, (n_rows, n_runs, ...).

    Attributes
    ----------
    sensors
        Values of the sensors at each reading.
    exact_contacts
        How hand and object touch in a run by itself, by row, where sensors have too few slots.
    """

    def __init__(self, simulations: Simulations, end: int) -> None:
        shape = simulations.sensordata.shape
        self.n_rows = min(max(KEPT // len(simulations.qpos), CHECKED_EVERY), end)
        self.sensors = np.empty((self.n_rows, *shape))
        self.exact_contacts: dict[int, Touch] = {}


class Runs:
    """Runs while they are made.

    At each reading, `groups` measure and command before the runs `step` to the next one.

    Attributes
    ----------
    tick
        Number of the reading that they are at.
    ends : (n_runs,)
        How many readings each run has.
    end
        How many readings the longest has.
    samples
        What becomes the records, by name: (n_readings, n_runs, ...).
    recent
        What has yet to become samples.
    """

    def __init__(self, jobs: Sequence[Job], device: Device = "cpu") -> None:
        self.jobs, n = jobs, len(jobs)
        self.tick = self._unchecked = self._unseen = 0
        self.simulations = simulations = simulations_of([job.scene for job in jobs], device)
        self.commands = commands_of(jobs)
        self.ends = np.array([len(commands.times) for commands in self.commands])
        self.end = int(self.ends.max())
        self.unstable, self.lost, self.uncounted = np.zeros((3, n), dtype=bool)
        widths = {name: getattr(simulations, name).shape[1] for name in (*COMMANDS, "qpos")}
        sensors = simulations.sensors
        widths |= {"contact_force": len(CONTACT_PARTS), "poses": sensors.n_poses}
        widths["pressed"] = sensors.n_pressed
        self.samples: dict[str, Array] = {
            name: np.zeros((self.end, n, width)) for name, width in widths.items()
        }
        self.samples |= {name: np.zeros((self.end, n)) for name in ("penetration", "table_force")}
        self.samples["press"] = np.zeros((self.end, n, len(CONTACT_PARTS), 3))
        # Velocities after the last steps too, and how often MuJoCo has warned before each reading.
        self._speeds = np.zeros((self.end + 1, *simulations.qvel.shape))
        self._warned = np.zeros((self.end + 1, *simulations.warnings.shape), dtype=np.int32)
        self.samples["qvel"], self._positions = self._speeds[:-1], self.samples["qpos"]
        self.groups = groups_of(jobs, self.commands, simulations, self.samples)
        self.recent = _Recent(simulations, self.end)
        samples = self.samples
        self._sent = [(samples[name], getattr(simulations, name)) for name in simulations.commanded]
        # Readings at which an object that has not risen is lost.
        self._due = np.zeros((self.end, n), dtype=bool)
        for i, (job, commands) in enumerate(zip(jobs, self.commands, strict=True)):
            self._due[: len(commands.times), i] = commands.due_to_rise(job.scene.task.rule.lift)
        self._any_due: list[bool] = self._due.any(axis=1).tolist()

    def start(self) -> None:
        """Put hands and forearms at the start, at rest, as `HandModel.set_posture` does."""
        simulations, hand = self.simulations, self.jobs[0].scene.hand
        simulations.reset()
        for i, (job, commands) in enumerate(zip(self.jobs, self.commands, strict=True)):
            model, q = job.scene.hand.model, job.plan.q_start.copy()
            qpos, ctrl = simulations.qpos[i], simulations.ctrl[i]
            if commands.reach is None:
                pos, quat = Wrist(model).forearm(commands.palm_pos[0], commands.palm_quat[0], q)
                free = int(model.joint("forearm").qposadr[0])
                qpos[free : free + 3], qpos[free + 3 : free + 7] = pos, quat
            else:
                q[WRIST_COLUMNS] = commands.reach.wrist[0]
                qpos[job.scene.arm_qpos] = ctrl[job.scene.arm_ctrl] = commands.reach.arm[0]
            qpos[hand.qpos_index] = q
            ctrl[hand.ctrl_index] = np.clip(q, *model.actuator_ctrlrange[hand.ctrl_index].T)
        simulations.forward()
        self._height = simulations.sensordata[:, simulations.sensors.height]
        self._first_height = self._height.copy()

    def step(self) -> None:
        """Send what is commanded at this reading, and go on to the next."""
        tick, recent, simulations = self.tick, self.recent, self.simulations
        row = tick - self._unseen
        for rows, values in self._sent:
            values[:] = rows[tick]
        self._positions[tick], recent.sensors[row] = simulations.qpos, simulations.sensordata
        exact = simulations.exact_contacts()
        if exact is not None:
            recent.exact_contacts[row] = exact
        simulations.step_to_next_reading(tick, self.ends)
        self.tick = after = tick + 1
        self._speeds[after], self._warned[after] = simulations.qvel, simulations.warnings
        over = after == self.end
        if over or after - self._unchecked == CHECKED_EVERY:
            self.check(self._unchecked, after)
            self._unchecked = after
        if over or row + 1 == recent.n_rows:
            self.look(self._unseen, after)
            self._unseen = after

    def check(self, start: int, stop: int) -> None:
        """End runs that have diverged after some readings."""
        after = slice(start + 1, stop + 1)
        bad = diverged(self._speeds[after], self._warned[after])
        if bad.any():
            bad &= self._not_ended(start, stop) & ~self.lost
            for i in np.flatnonzero(bad.any(axis=0)):
                self.ends[i], self.unstable[i] = start + int(bad[:, i].argmax()) + 1, True
            self.end = int(self.ends.max())
        full = self.simulations.incomplete()
        if full is not None:
            self.uncounted |= full & (self.ends >= stop)

    def look(self, start: int, stop: int) -> None:
        """Make samples of what the sensors said at some readings."""
        samples, sensors, recent = self.samples, self.simulations.sensors, self.recent
        rows, values = slice(start, stop), recent.sensors[: stop - start]
        touch, crowded = sensors.contacts(values)
        for row, exact in recent.exact_contacts.items():  # of a run by itself
            for each, value in zip(touch, exact, strict=True):
                each[row, 0] = value
            crowded[row, 0] = False
        recent.exact_contacts.clear()
        table_force, table_overlap = sensors.table(values)
        samples["contact_force"][rows], samples["press"][rows] = touch.force, touch.press
        samples["penetration"][rows] = np.maximum(touch.penetration, table_overlap)
        samples["table_force"][rows] = table_force
        samples["pressed"][rows] = sensors.pressed(values)
        samples["poses"][rows] = values[:, :, : sensors.n_poses]
        if crowded.any():
            self.uncounted |= (crowded & self._not_ended(start, stop)).any(axis=0)

    def _not_ended(self, start: int, stop: int) -> Mask:
        """Whether readings (stop - start, n_runs) are of the runs: not after their ends."""
        return np.arange(start, stop)[:, None] < self.ends

    def end_lost(self, tick: int) -> None:
        """End runs whose object stayed behind a palm that was to lift it."""
        if not self._any_due[tick]:
            return
        lost = self._due[tick] & (self._height - self._first_height < LOST)
        if True in lost.tolist():  # faster than lost.any()
            lost &= self.ends > tick
            self.ends[lost], self.lost[lost] = tick + 1, True
            self.end = int(self.ends.max())

    def records(self) -> list[Rollout | None]:
        """Judge the runs and return their records."""
        if self._unchecked < self.tick:
            self.check(self._unchecked, self.tick)
            self._unchecked = self.tick
        if self._unseen < self.tick:
            self.look(self._unseen, self.tick)
            self._unseen = self.tick
        return [None if self.uncounted[i] else self._record(i) for i in range(len(self.jobs))]

    def _record(self, i: int) -> Rollout:
        job, unstable = self.jobs[i], bool(self.unstable[i])
        # Copies, so that one record that is kept does not keep the samples of all runs in memory.
        samples = {name: rows[: self.ends[i], i].copy() for name, rows in self.samples.items()}
        samples |= self.simulations.sensors.poses(samples.pop("poses"))
        qpos = samples["qpos"][:, job.scene.hand.qpos_index]
        reading, arrived = read_by(job.glove, self.commands[i], job.driver, qpos)
        return record_of(
            job.scene,
            self.commands[i],
            job.driver,
            samples,
            reading=reading,
            arrived=arrived,
            unstable=unstable,
        )

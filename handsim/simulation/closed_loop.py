"""Run one grasp in contact physics: glove, driver, squeeze, forearm, and what is recorded of it.

Once every hundredth of a second the glove is read, the driver gives joint targets, the squeeze is
added, and the forearm is put where the palm's path and the commanded wrist angles need it. Once
the reach is over the targets stay what they are, so that all that follows is commanded at once.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.simulation.alignment import Wrist
from handsim.simulation.course import LOST, Course
from handsim.simulation.drivers import Driver
from handsim.simulation.glove import RATE, DataGlove
from handsim.simulation.plan import GraspPlan, Schedule, schedule_for
from handsim.simulation.rollout import Rollout
from handsim.simulation.seen import judged
from handsim.simulation.sensing import SLOTS, Senses, contacts_of
from handsim.simulation.silence import silent
from handsim.simulation.stage import Stage

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

MAX_SPEED = 500.0
"""Joint or body speed above which a simulation is taken to have diverged [m/s or rad/s]."""
BAD_NUMBERS = tuple(
    int(kind)
    for kind in (
        mujoco.mjtWarning.mjWARN_BADCTRL,
        mujoco.mjtWarning.mjWARN_BADQPOS,
        mujoco.mjtWarning.mjWARN_BADQVEL,
        mujoco.mjtWarning.mjWARN_BADQACC,
    )
)
"""MuJoCo's warnings of what is no number; but for the controls it starts again from rest."""
LOOKED_AT = 25
"""Every how many readings it is seen whether the simulation has diverged: a single look at the
velocities between steps cost 4 % of the steps, far more than the look itself takes."""
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
"""Bit of the model's options that keeps sensors from being computed."""


@silent()
def simulate(
    stage: Stage,
    plan: GraspPlan,
    driver: Driver,
    glove: DataGlove | None = None,
    schedule: Schedule | None = None,
    brief: bool = False,
) -> Rollout:
    """Run one grasp and judge it.

    Parameters
    ----------
    stage
        Scene of the task.
    plan
        Where palm and fingers go.
    driver
        What moves the fingers during the reach.
    glove
        How the joints are read; by default 1 degree steps with noise.
    schedule
        Timing; by default that of the task.
    brief
        End the run once the object has been lost, as a search may.

    Returns
    -------
    Rollout
        Cut short, with outcome ``unstable``, where the simulation diverges.
    """
    return run_alone(stage, plan, driver, glove or DataGlove(), schedule, brief=brief)


def run_alone(
    stage: Stage,
    plan: GraspPlan,
    driver: Driver,
    glove: DataGlove,
    schedule: Schedule | None = None,
    *,
    brief: bool = False,
) -> Rollout:
    """Do what `simulate` does, though MuJoCo's warnings are heard."""
    schedule = schedule or schedule_for(stage.task)
    course = Course.of(plan, stage.task, schedule).disturbed(stage.conditions, glove)
    run = _Run(stage, course, driver, glove)
    run.start(plan.q_start)
    model, data = stage.hand.model, stage.hand.data
    substeps = steps_per_reading(model)
    closed = int(np.searchsorted(course.times, driver.reach, side="right"))
    speed, warnings = data.qvel, data.warning.number
    n, stop = len(course.times), None
    for tick in range(n):
        if tick < closed:
            run.command(tick)
        elif tick == closed:
            run.command_rest(tick)
        run.send_and_keep(tick)
        # What the sensors tell is read once a reading, after the last step.
        model.opt.disableflags |= NO_SENSORS
        mujoco.mj_step(model, data, nstep=substeps - 1)
        model.opt.disableflags &= ~NO_SENSORS
        mujoco.mj_step(model, data)
        run.after[tick], run.warned[tick] = speed, warnings
        if (tick + 1) % LOOKED_AT == 0 or tick + 1 == n:
            stop = run.first_diverged(tick)
            if stop is not None:
                break
        if brief and run.lost(tick):
            n = tick + 1
            break
    unstable = stop is not None
    n = n if stop is None else stop + 1
    return judged(stage, course, driver, glove, run.seen(n), unstable=unstable)


def steps_per_reading(model: mujoco.MjModel) -> int:
    """Return how many steps MuJoCo makes between two readings of the glove."""
    return round(1.0 / (RATE * model.opt.timestep))


def diverged(qvel: Array, warnings: npt.NDArray[np.int32]) -> Mask:
    """Return whether states (...,) have left all bounds, by velocities and counts of warnings."""
    slow = np.asarray(np.abs(qvel) <= MAX_SPEED).all(axis=-1)
    return np.asarray(~slow | warnings[..., list(BAD_NUMBERS)].any(axis=-1))


class _Run:
    """One run: what is commanded and what is seen, a row for each reading."""

    def __init__(self, stage: Stage, course: Course, driver: Driver, glove: DataGlove) -> None:
        self.stage, self.course, self.driver, self.glove = stage, course, driver, glove
        self.wrist, self.senses = Wrist(stage.hand.model), Senses(stage.hand.model)
        data, n = stage.hand.data, len(course.times)
        self.data = data
        self.ctrl = np.zeros((n, stage.hand.model.nu))
        self.mocap_pos, self.mocap_quat = np.empty((n, 3)), np.empty((n, 4))
        self.qpos, self.qvel = np.empty((n, len(data.qpos))), np.empty((n, len(data.qvel)))
        self.after = np.empty((n, len(data.qvel)))
        self.warned = np.zeros((n, len(data.warning.number)), dtype=np.int32)
        self.n_looked_at = 0
        view = data.sensordata[self.senses.first :]
        self.sensed = np.empty((n, len(view)))
        self.height, self.counts = view[self.senses.height], self.senses.counts(view)
        self.crowded: dict[int, tuple[Array, float]] = {}
        self.sent = [
            (self.ctrl, data.ctrl),
            (self.mocap_pos, data.mocap_pos[stage.mocap]),
            (self.mocap_quat, data.mocap_quat[stage.mocap]),
        ]
        self.kept = [
            (self.qpos, data.qpos), (self.qvel, data.qvel), (self.sensed, view)
        ]  # fmt: skip

    def start(self, q_start: Array) -> None:
        """Put hand and forearm at the start, at rest."""
        hand, course = self.stage.hand, self.course
        mujoco.mj_resetData(hand.model, hand.data)
        free = hand.data.joint("forearm")
        pose = self.wrist.forearm(course.palm_pos[0], course.palm_quat[0], q_start)
        free.qpos[:3], free.qpos[3:] = pose
        hand.model.opt.disableflags &= ~NO_SENSORS
        hand.set_posture(q_start)
        self.first_height = float(self.height[0])

    def targets(self, tick: int) -> Array:
        """Read the glove and ask the driver, (22,) [rad]."""
        reading = self.glove.reading(self.stage.hand.q, self.course.disturbance[tick])
        return self.driver.targets(float(self.course.times[tick]), reading)

    def command(self, tick: int) -> None:
        """Lay down where actuators and forearm are to go at a reading."""
        course, hand = self.course, self.stage.hand
        ctrl = course.commanded(self.targets(tick), tick)
        self.ctrl[tick, hand.ctrl_index] = ctrl
        self.mocap_pos[tick], self.mocap_quat[tick] = self.wrist.forearm(
            course.palm_pos[tick], course.palm_quat[tick], ctrl
        )

    def command_rest(self, tick: int) -> None:
        """Lay down all that is left, from a reading on: the targets stay what they are."""
        course, hand, rest = self.course, self.stage.hand, slice(tick, None)
        ctrl = course.commanded(self.targets(tick), rest)
        self.ctrl[rest, hand.ctrl_index] = ctrl
        self.mocap_pos[rest], self.mocap_quat[rest] = self.wrist.forearms(
            course.palm_pos[rest], course.palm_quat[rest], ctrl
        )

    def send_and_keep(self, tick: int) -> None:
        """Give the commands to the simulation and keep a sample of everything."""
        for rows, view in self.sent:
            view[:] = rows[tick]
        for rows, view in self.kept:
            rows[tick] = view
        if self.data.ncon > SLOTS and max(self.counts.tolist()) > SLOTS:
            self.crowded[tick] = contacts_of(self.stage.hand.model, self.data)

    def first_diverged(self, tick: int) -> int | None:
        """Return the first reading, after those looked at before, after which the run diverged."""
        new = slice(self.n_looked_at, tick + 1)
        self.n_looked_at = tick + 1
        bad = np.flatnonzero(diverged(self.after[new], self.warned[new]))
        return new.start + int(bad[0]) if bad.size else None

    def lost(self, tick: int) -> bool:
        """Whether the object stays behind a palm that was to lift it."""
        if self.stage.task.rule.lift < LOST or self.course.lift[tick] < 2 * LOST:
            return False
        return bool(self.height[0] - self.first_height < LOST)

    def seen(self, n: int) -> dict[str, Array]:
        """Return the first ``n`` samples, as `judged` wants them."""
        sensed = self.sensed[:n]
        force, depth, _ = self.senses.contacts(sensed)
        for tick, exact in self.crowded.items():
            force[tick], depth[tick] = exact
        return {
            "qpos": self.qpos[:n],
            "qvel": self.qvel[:n],
            "ctrl": self.ctrl[:n],
            "mocap_pos": self.mocap_pos[:n],
            "mocap_quat": self.mocap_quat[:n],
            "contact_force": force,
            "penetration": depth,
            **self.senses.poses(sensed),
        }

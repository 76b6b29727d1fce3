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

from handsim.grasping.plan import GraspPlan, Schedule, schedule_for
from handsim.grasping.rollout.commands import LOST, Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import RATE, DataGlove
from handsim.grasping.rollout.record import Rollout, record_of
from handsim.grasping.rollout.sensing import SLOTS, Senses, contacts_of
from handsim.grasping.silence import silent
from handsim.types import Array, Mask

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
    scene
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
    return run_alone(scene, plan, driver, glove or DataGlove(), schedule, brief=brief)


def run_alone(
    scene: Scene,
    plan: GraspPlan,
    driver: Driver,
    glove: DataGlove,
    schedule: Schedule | None = None,
    *,
    brief: bool = False,
) -> Rollout:
    """Do what `simulate` does, though MuJoCo's warnings are heard."""
    schedule = schedule or schedule_for(scene.task)
    commands = Commands.of(plan, scene.task, schedule).disturbed(scene.conditions, glove)
    run = _Run(scene, commands, driver, glove)
    run.start(plan.q_start)
    model, data = scene.hand.model, scene.hand.data
    substeps = steps_per_reading(model)
    closed = int(np.searchsorted(commands.times, driver.reach, side="right"))
    speed, warnings = data.qvel, data.warning.number
    n, stop = len(commands.times), None
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
    return record_of(scene, commands, driver, glove, run.seen(n), unstable=unstable)


def steps_per_reading(model: mujoco.MjModel) -> int:
    """Return how many steps MuJoCo makes between two readings of the glove."""
    return round(1.0 / (RATE * model.opt.timestep))


def diverged(qvel: Array, warnings: npt.NDArray[np.int32]) -> Mask:
    """Return whether states (...,) have left all bounds, by velocities and counts of warnings."""
    slow = np.asarray(np.abs(qvel) <= MAX_SPEED).all(axis=-1)
    return np.asarray(~slow | warnings[..., list(BAD_NUMBERS)].any(axis=-1))


class _Run:
    """One run: what is commanded and what is seen, a row for each reading."""

    def __init__(self, scene: Scene, commands: Commands, driver: Driver, glove: DataGlove) -> None:
        self.scene, self.commands, self.driver, self.glove = scene, commands, driver, glove
        self.wrist, self.senses = Wrist(scene.hand.model), Senses(scene.hand.model)
        data, n = scene.hand.data, len(commands.times)
        self.data = data
        self.ctrl = np.zeros((n, scene.hand.model.nu))
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
            (self.mocap_pos, data.mocap_pos[scene.mocap]),
            (self.mocap_quat, data.mocap_quat[scene.mocap]),
        ]
        self.kept = [
            (self.qpos, data.qpos), (self.qvel, data.qvel), (self.sensed, view)
        ]  # fmt: skip

    def start(self, q_start: Array) -> None:
        """Put hand and forearm at the start, at rest."""
        hand, commands = self.scene.hand, self.commands
        mujoco.mj_resetData(hand.model, hand.data)
        free = hand.data.joint("forearm")
        pose = self.wrist.forearm(commands.palm_pos[0], commands.palm_quat[0], q_start)
        free.qpos[:3], free.qpos[3:] = pose
        hand.model.opt.disableflags &= ~NO_SENSORS
        hand.set_posture(q_start)
        self.first_height = float(self.height[0])

    def targets(self, tick: int) -> Array:
        """Read the glove and ask the driver, (22,) [rad]."""
        reading = self.glove.reading(self.scene.hand.q, self.commands.disturbance[tick])
        return self.driver.targets(float(self.commands.times[tick]), reading)

    def command(self, tick: int) -> None:
        """Lay down where actuators and forearm are to go at a reading."""
        commands, hand = self.commands, self.scene.hand
        ctrl = commands.commanded(self.targets(tick), tick)
        self.ctrl[tick, hand.ctrl_index] = ctrl
        self.mocap_pos[tick], self.mocap_quat[tick] = self.wrist.forearm(
            commands.palm_pos[tick], commands.palm_quat[tick], ctrl
        )

    def command_rest(self, tick: int) -> None:
        """Lay down all that is left, from a reading on: the targets stay what they are."""
        commands, hand, rest = self.commands, self.scene.hand, slice(tick, None)
        ctrl = commands.commanded(self.targets(tick), rest)
        self.ctrl[rest, hand.ctrl_index] = ctrl
        self.mocap_pos[rest], self.mocap_quat[rest] = self.wrist.forearms(
            commands.palm_pos[rest], commands.palm_quat[rest], ctrl
        )

    def send_and_keep(self, tick: int) -> None:
        """Give the commands to the simulation and keep a sample of everything."""
        for rows, view in self.sent:
            view[:] = rows[tick]
        for rows, view in self.kept:
            rows[tick] = view
        if self.data.ncon > SLOTS and max(self.counts.tolist()) > SLOTS:
            self.crowded[tick] = contacts_of(self.scene.hand.model, self.data)

    def first_diverged(self, tick: int) -> int | None:
        """Return the first reading, after those looked at before, after which the run diverged."""
        new = slice(self.n_looked_at, tick + 1)
        self.n_looked_at = tick + 1
        bad = np.flatnonzero(diverged(self.after[new], self.warned[new]))
        return new.start + int(bad[0]) if bad.size else None

    def lost(self, tick: int) -> bool:
        """Whether the object stays behind a palm that was to lift it."""
        if self.scene.task.rule.lift < LOST or self.commands.lift[tick] < 2 * LOST:
            return False
        return bool(self.height[0] - self.first_height < LOST)

    def seen(self, n: int) -> dict[str, Array]:
        """Return the first ``n`` samples, as `record_of` wants them."""
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

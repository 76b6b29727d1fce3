"""Run one grasp in contact physics: glove, driver, squeeze, forearm, and what is recorded of it.

Once every hundredth of a second the glove is read, the driver gives joint targets, the squeeze is
added, and the forearm is put where the palm's path and the commanded wrist angles need it. Once
the reach is over the targets stay what they are, so that all that follows is commanded at once.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.simulation.alignment import Wrist
from handsim.simulation.contacts import ContactLog
from handsim.simulation.course import LOST, Course
from handsim.simulation.drivers import Driver
from handsim.simulation.glove import RATE, DataGlove
from handsim.simulation.plan import GraspPlan, Schedule, schedule_for
from handsim.simulation.rollout import Rollout
from handsim.simulation.seen import POSES, judged
from handsim.simulation.stage import Stage

Array = npt.NDArray[np.float64]

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


@contextmanager
def silent() -> Iterator[None]:
    """Keep MuJoCo from telling the terminal and a log file what the outcome will tell."""
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(kept)


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
    n, unstable = len(course.times), False
    for tick in range(n):
        if tick < closed:
            run.command(tick)
        elif tick == closed:
            run.command_rest(tick)
        run.send_and_keep(tick)
        mujoco.mj_step(model, data, nstep=substeps)
        # The sum of squares tells at once where no single speed can be too large.
        if not speed @ speed <= MAX_SPEED**2 or warnings.any():
            unstable = diverged(speed, warnings)
        if unstable or (brief and run.lost(tick)):
            n = tick + 1
            break
    return judged(stage, course, driver, glove, run.seen(n), unstable=unstable)


def steps_per_reading(model: mujoco.MjModel) -> int:
    """Return how many steps MuJoCo makes between two readings of the glove."""
    return round(1.0 / (RATE * model.opt.timestep))


def diverged(qvel: Array, warnings: npt.NDArray[np.int32]) -> bool:
    """Whether a state has left all bounds, by its velocities and its warnings' counters."""
    return bool(warnings[list(BAD_NUMBERS)].any() or not (np.abs(qvel) <= MAX_SPEED).all())


class _Run:
    """One run: what is commanded and what is seen, a row for each reading."""

    def __init__(self, stage: Stage, course: Course, driver: Driver, glove: DataGlove) -> None:
        self.stage, self.course, self.driver, self.glove = stage, course, driver, glove
        self.wrist = Wrist(stage.hand.model)
        model, data = stage.hand.model, stage.hand.data
        n = len(course.times)
        self.ctrl = np.zeros((n, model.nu))
        self.mocap_pos, self.mocap_quat = np.empty((n, 3)), np.empty((n, 4))
        self.contacts = ContactLog(data)
        body = {"object": stage.object_body, "palm": stage.palm_body}
        views = {"qpos": data.qpos, "qvel": data.qvel}
        views |= {name: getattr(data, array)[body[of]] for name, (array, of) in POSES.items()}
        self.kept = {name: np.empty((n, *view.shape)) for name, view in views.items()}
        self.pairs = [(self.kept[name], view) for name, view in views.items()]
        self.sent = [
            (self.ctrl, data.ctrl),
            (self.mocap_pos, data.mocap_pos[stage.mocap]),
            (self.mocap_quat, data.mocap_quat[stage.mocap]),
        ]

    def start(self, q_start: Array) -> None:
        """Put hand and forearm at the start, at rest."""
        hand, course = self.stage.hand, self.course
        mujoco.mj_resetData(hand.model, hand.data)
        free = hand.data.joint("forearm")
        pose = self.wrist.forearm(course.palm_pos[0], course.palm_quat[0], q_start)
        free.qpos[:3], free.qpos[3:] = pose
        hand.set_posture(q_start)

    def command(self, tick: int) -> None:
        """Read the glove and lay down where actuators and forearm are to go."""
        course, hand = self.course, self.stage.hand
        reading = self.glove.reading(hand.q, course.disturbance[tick])
        targets = self.driver.targets(float(course.times[tick]), reading)
        ctrl = course.commanded(targets, tick)
        self.ctrl[tick, hand.ctrl_index] = ctrl
        self.mocap_pos[tick], self.mocap_quat[tick] = self.wrist.forearm(
            course.palm_pos[tick], course.palm_quat[tick], ctrl
        )

    def command_rest(self, tick: int) -> None:
        """Lay down all that is left, from a reading on: the targets stay what they are."""
        course, hand, rest = self.course, self.stage.hand, slice(tick, None)
        reading = self.glove.reading(hand.q, course.disturbance[tick])
        targets = self.driver.targets(float(course.times[tick]), reading)
        ctrl = course.commanded(targets, rest)
        self.ctrl[rest, hand.ctrl_index] = ctrl
        self.mocap_pos[rest], self.mocap_quat[rest] = self.wrist.forearms(
            course.palm_pos[rest], course.palm_quat[rest], ctrl
        )

    def send_and_keep(self, tick: int) -> None:
        """Give the commands to the simulation and keep a sample of everything."""
        for rows, view in self.sent:
            view[:] = rows[tick]
        for rows, view in self.pairs:
            rows[tick] = view
        self.contacts.keep()

    def lost(self, tick: int) -> bool:
        """Whether the object stays behind a palm that was to lift it."""
        if self.stage.task.rule.lift < LOST or self.course.lift[tick] < 2 * LOST:
            return False
        rise = self.stage.hand.data.xipos[self.stage.object_body, 2] - self.kept["object_pos"][0, 2]
        return bool(rise < LOST)

    def seen(self, n: int) -> dict[str, Array]:
        """Return the first ``n`` samples, as `judged` wants them."""
        stage = self.stage
        commands = {
            "ctrl": self.ctrl, "mocap_pos": self.mocap_pos, "mocap_quat": self.mocap_quat,
        }  # fmt: skip
        samples = {name: rows[:n] for name, rows in (self.kept | commands).items()}
        force, depth = self.contacts.totals(stage.part_of_geom, stage.of_object)
        return samples | {"contact_force": force, "penetration": depth}

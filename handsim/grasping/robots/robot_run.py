"""Run one grasp of a robot hand in contact physics.

A hundred times a second its fingertips are read, its targets are moved so that it holds with a
force, in its own coordinates, and its base is put on the palm's path.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections import deque

import mujoco
import numpy as np

from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.robots.base_path import BasePath
from handsim.grasping.robots.robot_grip import RobotGrip
from handsim.grasping.robots.robot_mount import LAGS
from handsim.grasping.robots.robot_movement import RobotMovement
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.grasping.rollout.commands import LOST, Commands
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.glove import RATE, steps_per_reading
from handsim.grasping.rollout.record import Rollout, record_of
from handsim.grasping.rollout.run import diverged
from handsim.grasping.rollout.sensing import SLOTS, Touch, contacts_of
from handsim.silence import silent
from handsim.tasks.grip_rules import MAX_PUSH
from handsim.types import Array

ARRIVED = float(np.deg2rad(15.0))
"""A robot has arrived whose coordinates are, in the root mean square, no farther from what it was
told [rad]; contact included."""

FAR = 4.0
"""A run that may be brief ends where the object was pushed this many times as far as it may be."""
_STATES = ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat")


@silent()
def simulate_robot(
    scene: RobotScene,
    plan: GraspPlan,
    driver: Driver,
    commands: Commands,
    movement: RobotMovement,
    *,
    brief: bool = False,
) -> Rollout:
    """Run one grasp and judge it by the rules of a person's.

    Parameters
    ----------
    scene
    plan
        Its palm is where the robot's palm is to be in the object's frame.
    driver, commands
        What moved the person's hand, and what is known before the run (`Commands.disturbed`), with
        the path of the robot's palm.
    movement
        Mapped to the robot.
    brief
        End the run as soon as the object is lost.

    Returns
    -------
    Rollout
        Its ``reading`` is the person's hand that the robot follows.
    """
    run = _Run(scene, commands, movement, plan.grip)
    n = run.make(brief)
    arrival = min(commands.arrival, n - 1)
    off = run.states["qpos"][arrival, scene.qpos_index] - movement.told[arrival]
    return record_of(
        scene,
        commands,
        driver,
        run.samples(n),
        reading=movement.postures[:n],
        arrived=bool(np.sqrt(np.mean(off**2)) < ARRIVED),
        unstable=run.unstable,
    )


class _Run:
    """A run while it is made.

    Attributes
    ----------
    states
        MuJoCo's arrays by name, and what the sensors see (``seen``), with a row for each reading.
    exact
        How hand and object touch at readings at which sensors have too few slots.
    unstable
        Whether the simulation diverged after the last reading.
    """

    def __init__(
        self, scene: RobotScene, commands: Commands, movement: RobotMovement, grip: float
    ) -> None:
        data = scene.data
        self._scene, self._commands = scene, commands
        self._sensors = scene.sensors
        self._values = data.sensordata[None, self._sensors.first :]
        self._live = {name: getattr(data, name).reshape(-1) for name in _STATES}
        self._live["seen"] = self._values[0]
        n = len(commands.times)
        self.states = {name: np.zeros((n, len(live))) for name, live in self._live.items()}
        self.exact: dict[int, Touch] = {}
        self.unstable = False
        servos = RobotServos.at(scene.robot, movement.told[-1])
        self._grip = RobotGrip(
            movement.closing, grip, servos, np.asarray((movement.flexion == 0.0).all(axis=0))
        )
        self._told = movement.told
        speed = np.gradient(self._told, 1.0 / RATE, axis=0)
        self._added = movement.flexion + servos.lead * speed
        latency = round(scene.conditions.latency * RATE)
        self._forces: deque[list[float]] = deque(maxlen=latency + 1)
        self._held = np.zeros(3)
        self._path = BasePath.of(commands, steps_per_reading(scene.model))
        self._ahead = (LAGS * self._path.velocity)[..., : len(scene.mount_ctrl)]

    def make(self, brief: bool) -> int:
        """Make the run and return how many readings it has."""
        model, data, sensors = self._scene.model, self._scene.data, self._sensors
        commands = self._commands
        self._scene.pose(Pose(commands.palm_pos[0], commands.palm_quat[0]), self._told[0])
        n = len(commands.times)
        for tick in range(n):
            self._command(tick)
            for name, live in self._live.items():
                self.states[name][tick] = live
            if data.ncon > SLOTS and sensors.n_contacts(self._values).max() > SLOTS:
                self.exact[tick] = contacts_of(model, data)
            self._advance(tick)
            self.unstable = bool(diverged(data.qvel, data.warning.number))
            if self.unstable or (brief and self._is_over(tick)):
                return tick + 1
        return n

    def _command(self, tick: int) -> None:
        """Read the fingertips and command hand and base."""
        scene, commands, grip = self._scene, self._commands, self._grip
        data, robot = scene.data, scene.robot
        (forces,) = self._sensors.finger_forces(self._values)
        self._forces.append(forces)
        grip.feel(self._forces[0])
        if tick >= commands.action:
            grip.keep(data.qpos[scene.qpos_index], 1.0 / RATE)
            before, self._held = self._held, self._sensors.held(self._values)[0]
            if tick > commands.action and commands.lifted:
                slip = RATE * float(np.linalg.norm(self._held - before))
                load = float(self._sensors.carried(self._values)[0] / commands.weight[tick])
                grip.tighten(slip, load, 1.0 / RATE)
        x = grip.targets(self._told[tick], float(commands.closed[tick]), 1.0 / RATE)
        x = np.clip(x + self._added[tick], robot.lower, robot.upper)
        data.ctrl[scene.ctrl_index] = robot.commands(x)
        data.mocap_pos[0], data.mocap_quat[0] = commands.palm_pos[tick], commands.palm_quat[tick]

    def _advance(self, tick: int) -> None:
        """Simulate until the next reading."""
        data, path = self._scene.data, self._path
        steps = zip(path.pos[tick], path.quat[tick], self._ahead[tick], strict=True)
        for pos, quat, ahead in steps:
            data.mocap_pos[0], data.mocap_quat[0] = pos, quat
            data.ctrl[self._scene.mount_ctrl] = ahead
            mujoco.mj_step(self._scene.model, data)

    def _is_over(self, tick: int) -> bool:
        """Whether the object is lost, or was pushed far before the hand had closed."""
        commands, now, first = self._commands, self._values[0], self.states["seen"][0]
        risen = now[self._sensors.height] - first[self._sensors.height]
        due = commands.lift[tick] >= 2 * LOST and self._scene.task.rule.lift >= LOST
        far = float(np.linalg.norm(now[:3] - first[:3])) > FAR * MAX_PUSH
        return bool((due and risen < LOST) or (tick == commands.action and far))

    def samples(self, n: int) -> dict[str, Array]:
        """Return what `record_of` takes, of n readings."""
        samples, sensors = {name: rows[:n] for name, rows in self.states.items()}, self._sensors
        seen = samples.pop("seen")
        touch, _ = sensors.contacts(seen)
        for row, exact in self.exact.items():
            for kept, value in zip(touch, exact, strict=True):
                kept[row] = value
        table_force, table_overlap = sensors.table(seen)
        return samples | {
            "contact_force": touch.force,
            "press": touch.press,
            "penetration": np.maximum(touch.penetration, table_overlap),
            "table_force": table_force,
            "pressed": sensors.pressed(seen),
            **sensors.poses(seen[:, : sensors.n_poses]),
        }

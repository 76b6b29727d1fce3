"""Run one grasp of a robot hand in contact physics.

A hundred times a second its fingertips are read, the grip layer turns what it is told into targets
that hold with a force, in the robot's own coordinates, and its base is put on the palm's path.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections import deque
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.plan import GraspPlan
from handsim.grasping.robots.robot_grip import RobotGrip
from handsim.grasping.robots.robot_movement import RobotMovement
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.grasping.rollout._stepping import steps_per_reading
from handsim.grasping.rollout.commands import LOST, Commands
from handsim.grasping.rollout.drivers import Driver
from handsim.grasping.rollout.glove import RATE
from handsim.grasping.rollout.record import Rollout, record_of
from handsim.grasping.rollout.run import diverged
from handsim.grasping.rollout.sensing import SLOTS, Sensors, contacts_of
from handsim.silence import silent
from handsim.tasks.grip_rules import MAX_PUSH
from handsim.types import Array, Mask

ARRIVED = float(np.deg2rad(15.0))
"""A robot has arrived whose coordinates are, in the root mean square, no farther from what it was
told [rad]; contact included."""

FAR = 4.0
"""A run that may be brief ends where the object was pushed this many times as far as it may be."""


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
        What moved the person's hand, and what is known before the run (`Commands.disturbed`).
    movement
        Mapped to the robot.
    brief
        End the run as soon as the object is lost.

    Returns
    -------
    Rollout
        Its ``reading`` is the person's hand that the robot follows.
    """
    turn = Rotation.from_quat(commands.palm_quat, scalar_first=True)
    commands = replace(commands, palm_pos=commands.palm_pos + turn.apply(movement.shift))
    run = _Run(scene, plan, commands, movement)
    n = run.make(brief)
    arrival = min(commands.arrival, n - 1)
    off = run.samples["qpos"][arrival][scene.qpos_index] - movement.told[movement.row[arrival]]
    return record_of(
        scene,
        commands,
        driver,
        {name: values[:n] for name, values in run.samples.items()},
        reading=movement.postures[:n],
        arrived=bool(np.sqrt(np.mean(off**2)) < ARRIVED),
        unstable=run.unstable,
    )


@dataclass
class _Run:
    """A run while it is made; samples have a row for each reading."""

    scene: RobotScene
    plan: GraspPlan
    commands: Commands
    movement: RobotMovement
    unstable: bool = False
    samples: dict[str, Array] = field(default_factory=dict[str, Array])
    _first: Array = field(default_factory=lambda: np.zeros(3))

    def make(self, brief: bool) -> int:
        """Make the run and return how many readings it has."""
        scene, commands, movement = self.scene, self.commands, self.movement
        model, data, robot = scene.model, scene.data, scene.robot
        sensors, n = Sensors(model), len(commands.times)
        values = data.sensordata[None, sensors.first :]
        seen = np.empty((n, values.shape[1]))
        states = ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat")
        shape = {name: np.asarray(getattr(data, name)).reshape(-1).shape for name in states}
        self.samples = {name: np.zeros((n, *shape[name])) for name in states}
        exact: dict[int, tuple[Array, ...]] = {}
        servos = RobotServos.at(robot, movement.told[-1])
        flexed = movement.flexion.any(axis=0)
        grip = RobotGrip(movement.closing, self.plan.grip, servos, ~flexed)
        whole = movement.told[movement.row]
        added = movement.flexion + servos.lead * np.gradient(whole, 1.0 / RATE, axis=0)
        self._start()
        forces: deque[list[list[float]]] = deque(
            maxlen=round(scene.conditions.latency * RATE) + 1
        )
        self._first, held = values[0, :3].copy(), np.zeros(3)
        due = commands.due_to_rise(scene.task.rule.lift)
        tick = 0
        for tick in range(n):
            forces.append(sensors.finger_forces(values))
            grip.feel(forces[0][0])
            if tick >= commands.action:
                grip.keep(data.qpos[scene.qpos_index], 1.0 / RATE)
                before, held = held, sensors.held(values)[0]
                if tick > commands.action and commands.lifted:
                    load = float(sensors.carried(values)[0] / commands.weight[tick])
                    grip.tighten(RATE * float(np.linalg.norm(held - before)), load, 1.0 / RATE)
            x = grip.targets(whole[tick], float(commands.closed[tick]), 1.0 / RATE)
            x = np.clip(x + added[tick], robot.lower, robot.upper)
            data.ctrl[scene.ctrl_index] = robot.commands(x)
            data.mocap_pos[0], data.mocap_quat[0] = (
                commands.palm_pos[tick],
                commands.palm_quat[tick],
            )
            for name in states:
                self.samples[name][tick] = np.asarray(getattr(data, name)).reshape(-1)
            seen[tick] = values[0]
            if data.ncon > SLOTS and sensors.n_contacts(values).max() > SLOTS:
                exact[tick] = contacts_of(model, data)
            mujoco.mj_step(model, data, nstep=steps_per_reading(model))
            if diverged(data.qvel, data.warning.number):
                self.unstable = True
                break
            if brief and self._is_over(tick, values[0], sensors, due):
                break
        self._read(sensors, seen[: tick + 1], exact)
        return tick + 1

    def _is_over(self, tick: int, values: Array, sensors: Sensors, due: Mask) -> bool:
        """Whether the object is lost, or was pushed far before the hand had closed."""
        if due[tick]:
            return bool(values[sensors.height] - self._first[sensors.height] < LOST)
        pushed = float(np.linalg.norm(values[:3] - self._first))
        return tick == self.commands.action and pushed > FAR * MAX_PUSH

    def _start(self) -> None:
        """Put the robot where its movement begins, at rest."""
        scene, commands = self.scene, self.commands
        model, data = scene.model, scene.data
        mujoco.mj_resetData(model, data)
        x = self.movement.told[0]
        data.qpos[scene.joint_index] = scene.robot.joint_positions(x)
        data.ctrl[scene.ctrl_index] = scene.robot.commands(x)
        free = int(model.joint("forearm").qposadr[0])
        data.qpos[free : free + 3] = commands.palm_pos[0]
        data.qpos[free + 3 : free + 7] = commands.palm_quat[0]
        data.mocap_pos[0], data.mocap_quat[0] = commands.palm_pos[0], commands.palm_quat[0]
        mujoco.mj_forward(model, data)

    def _read(self, sensors: Sensors, seen: Array, exact: dict[int, tuple[Array, ...]]) -> None:
        """Make samples of what the sensors saw."""
        n = len(seen)
        touch, _ = sensors.contacts(seen)
        for row, values in exact.items():
            for kept, value in zip(touch, values, strict=True):
                kept[row] = value
        table_force, table_overlap = sensors.table(seen)
        self.samples = {name: values[:n] for name, values in self.samples.items()}
        self.samples |= {
            "contact_force": touch.force,
            "press": touch.press,
            "penetration": np.maximum(touch.penetration, table_overlap),
            "table_force": table_force,
            "pressed": sensors.pressed(seen),
            **sensors.poses(seen[:, : sensors.n_poses]),
        }

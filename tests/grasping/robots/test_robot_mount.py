"""A mount of limited force: it gives way as springs do, presses no harder than its limit, and holds
what a free base holds."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import Pose, Schedule
from handsim.grasping.robots import robot_mount
from handsim.grasping.robots.base_path import BasePath
from handsim.grasping.robots.robot_grasper import key_of_robot
from handsim.grasping.robots.robot_mount import (
    INERTIA,
    LAG,
    LAGS,
    MASS,
    MOST_FORCE,
    MOST_TORQUE,
    STIFFNESS,
    TURN_LAG,
    TURN_STIFFNESS,
)
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout_file import read_rollout, write_rollout
from handsim.physics import GRAVITY, TIMESTEP
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")
MOUNTED, FREE = Conditions(base="mounted"), Conditions(base="free")
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
HIGH = Pose(np.array([0.0, 0.0, 0.4]), LEVEL)
STEPS = 5


@pytest.fixture(scope="module")
def mounted(robot) -> RobotScene:
    return RobotScene.build(TASK, MOUNTED, robot)


def at_rest(scene: RobotScene, target: Pose, seconds: float = 1.5) -> Pose:
    """Return where the base comes to rest that is told to go to a pose from `HIGH`."""
    scene.pose(HIGH, scene.robot.reference)
    data = scene.data
    data.mocap_pos[0], data.mocap_quat[0] = target.pos, target.quat
    mujoco.mj_step(scene.model, data, nstep=round(seconds / TIMESTEP))
    body = data.body("forearm")
    return Pose(body.xpos.copy(), body.xquat.copy())


def test_it_carries_the_whole_hand_as_a_spring_does(mounted, robot) -> None:
    weight = GRAVITY * robot.model.body_mass.sum()
    sunk = HIGH.pos - at_rest(mounted, HIGH).pos
    np.testing.assert_allclose(sunk, [0.0, 0.0, weight / STIFFNESS], atol=2e-6)
    assert sunk[2] > 5e-5


def test_the_fingers_do_not_hang_from_their_servos(mounted, robot) -> None:
    at_rest(mounted, HIGH)
    np.testing.assert_allclose(mounted.data.qpos[mounted.qpos_index], robot.reference, atol=2e-3)


def test_it_turns_by_a_torque_as_a_spring_does_and_not_beyond_its_limit(mounted) -> None:
    data = mounted.data
    for torque, expected in ((6.0, 6.0 / TURN_STIFFNESS), (2.0 * MOST_TORQUE, np.inf)):
        mounted.pose(HIGH, mounted.robot.reference)
        data.xfrc_applied[mounted.model.body("forearm").id, 5] = torque
        mujoco.mj_step(mounted.model, data, nstep=100)
        turned = Rotation.from_quat(data.body("forearm").xquat, scalar_first=True).magnitude()
        if np.isfinite(expected):
            assert turned == pytest.approx(expected, rel=0.05)
        else:  # what is beyond the limit turns it freely
            gained = (torque - MOST_TORQUE) * 0.2 / (1.3 * INERTIA)
            assert np.linalg.norm(data.joint("forearm").qvel[3:]) > 0.5 * gained


def test_it_presses_on_the_table_no_harder_than_its_limit(mounted, robot) -> None:
    """The free base presses without any."""
    low = Pose(np.array([-0.1, 0.3, -0.02]), LEVEL)
    pressed = {}
    for scene in (mounted, RobotScene.build(TASK, FREE, robot)):
        at_rest(scene, low)
        values = scene.data.sensordata[scene.sensors.first :]
        pressed[scene.conditions.base] = float(scene.sensors.table(values)[0])
    weight = GRAVITY * robot.model.body_mass.sum()
    assert pressed["mounted"] == pytest.approx(MOST_FORCE + weight, abs=2.0)
    assert pressed["free"] > 10 * MOST_FORCE


def commands_along(velocity: np.ndarray, turning: np.ndarray, n: int = 60) -> Commands:
    """Commands of a palm that moves and turns evenly [m/s, rad/s]."""
    times = np.arange(n) / 100
    nothing = np.zeros(n)
    tilted = Rotation.from_euler("xyz", [0.4, -0.7, 1.1])
    turns = Rotation.from_rotvec(times[:, None] * turning) * tilted
    return Commands(
        Schedule((), 0.0), times, HIGH.pos + times[:, None] * velocity,
        turns.as_quat(scalar_first=True), np.zeros(22), nothing, np.zeros((n, 22)), 0, 0, True,
        nothing, np.zeros((n, 3)), nothing, np.zeros((n, 22)), np.zeros(n, bool),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("velocity", "turning"), [([0.3, -0.2, 0.1], [0.0] * 3), ([0.0] * 3, [0.5, 1.0, -0.7])]
)
def test_it_follows_an_even_movement_without_lagging(mounted, velocity, turning) -> None:
    commands = commands_along(np.array(velocity), np.array(turning))
    path, data = BasePath.of(commands, STEPS), mounted.data
    mounted.pose(Pose(commands.palm_pos[0], commands.palm_quat[0]), mounted.robot.reference)
    off, turned = [], []
    for tick in range(len(commands.times) - 1):
        for pos, quat, v in zip(path.pos[tick], path.quat[tick], path.velocity[tick], strict=True):
            data.mocap_pos[0], data.mocap_quat[0] = pos, quat
            data.ctrl[mounted.mount_ctrl] = LAGS * v
            mujoco.mj_step(mounted.model, data)
        there = Rotation.from_quat(data.body("forearm").xquat, scalar_first=True)
        wanted = Rotation.from_quat(commands.palm_quat[tick + 1], scalar_first=True)
        off.append(np.linalg.norm(data.body("forearm").xpos - commands.palm_pos[tick + 1]))
        turned.append((there.inv() * wanted).magnitude())
    late = slice(len(off) // 2, None)
    speed = float(np.linalg.norm(velocity))
    assert max(off[late]) < 0.15 * speed * LAG + 4e-4
    assert max(turned[late]) < 0.15 * float(np.linalg.norm(turning)) * TURN_LAG + 2e-4


def test_between_readings_it_is_told_every_step_and_at_the_end_to_stay() -> None:
    commands = commands_along(np.array([0.5, 0.0, 0.0]), np.zeros(3))
    path = BasePath.of(commands, STEPS)
    assert path.pos.shape == (60, STEPS, 3) and path.quat.shape == (60, STEPS, 4)
    np.testing.assert_allclose(path.pos[:-1, -1], commands.palm_pos[1:], atol=1e-12)
    np.testing.assert_allclose(np.diff(path.pos[3, :, 0]), 0.5 * TIMESTEP, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(path.velocity[:-1, :, :3], axis=2), 0.5)
    np.testing.assert_allclose(path.pos[-1], np.tile(commands.palm_pos[-1], (STEPS, 1)))
    np.testing.assert_allclose(path.velocity[-1], 0.0, atol=1e-9)


def test_a_hand_that_is_too_heavy_is_refused(robot, monkeypatch) -> None:
    monkeypatch.setattr(robot_mount, "PAYLOAD", 0.1)
    with pytest.raises(InputError, match=r"kg, more than the 0.1 kg .* give --base free"):
        RobotScene.build(TASK, MOUNTED, robot)


@pytest.mark.ci
def test_a_mounted_hand_raises_the_cube_and_its_rollout_is_read_again(
    grasps, mounted, plan, tmp_path
) -> None:
    held = grasps.run(mounted, plan)
    assert held.outcome.success, held.outcome
    assert held.conditions.base == "mounted"
    write_rollout(held, tmp_path / "run.npz")
    again = read_rollout(tmp_path / "run.npz")
    assert again.conditions.base == "mounted"
    assert again.model().body("forearm").mass[0] == pytest.approx(MASS)
    assert again.model().actuator("mount_x").forcerange.tolist() == [-MOST_FORCE, MOST_FORCE]


def test_its_plans_are_others_than_those_of_a_free_base(mounted, scene) -> None:
    assert {"hand", "physics"} <= set(key_of_robot(mounted).differs_in(key_of_robot(scene)))


def test_it_carries_no_person(robot) -> None:
    with pytest.raises(InputError, match="robot hands alone"):
        Scene.build(TASK, replace(MOUNTED, seed=1))

"""Beside a robot hand stands the person's hand that it follows, turned as the robot is."""

from dataclasses import fields, replace
from typing import Any

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.robots.robot_scene import PREFIX, RobotScene
from handsim.grasping.rollout.record import Phase, Rollout
from handsim.hand.export import write_hand
from handsim.joints import FINGERS, JOINT_NAMES, N_JOINTS
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND
from handsim.viewing.film.clips import render_clips, render_sheet
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.person_clip import person_clip
from handsim.viewing.film.rollout_clips import rollout_clip

N = 3
QUATS = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5], [0.6, 0.0, 0.8, 0.0]])
"""Of the robot's base."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Rollout:
    """The own hand as a robot, in the posture of the person that it follows, wrist apart."""
    file = write_hand(MEDIAN_HAND, tmp_path_factory.mktemp("robot") / "hand")
    robot = RobotHand(file, "palm", {finger: f"{finger}_pad" for finger in FINGERS})
    conditions = Conditions(base="free")
    scene = RobotScene.build(task_by_name("cube-raise"), conditions, robot)
    model = scene.model
    reading = 0.3 * np.random.default_rng(0).random((N, N_JOINTS))
    qpos = np.tile(model.qpos0, (N, 1))
    base = model.joint("forearm").qposadr[0]
    qpos[:, base : base + 7] = np.column_stack([np.tile([0.0, 0.0, 0.3], (N, 1)), QUATS])
    for name in robot.joint_names:
        at = model.joint(PREFIX + name).qposadr[0]
        qpos[:, at] = reading[:, JOINT_NAMES.index(name)]
    values: dict[str, Any] = {each.name: np.zeros((N, 1)) for each in fields(Rollout)}
    values |= {
        "task": "cube-raise",
        "driver": "controller",
        "model_xml": scene.xml(),
        "assets": {},
        "time": 2.0 + np.arange(N) / 10,
        "qpos": qpos,
        "qvel": np.zeros((N, model.nv)),
        "reading": reading,
        "contact_force": np.zeros((N, 6)),
        "phases": (Phase("reach", 2.0),),
        "conditions": conditions,
        "outcome": Outcome(True, None, 0.1, 0.0, 0.0, 2.0, 5, 0.0),
        "versions": {},
    }
    return Rollout(**values)


def axes(model: mujoco.MjModel, qpos: np.ndarray, names: list[str]) -> np.ndarray:
    """Axes of bodies in the world, (n, 3, 3)."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return np.array([data.body(name).xmat.reshape(3, 3) for name in names])


def test_palm_and_fingers_are_turned_as_the_robots(run: Rollout) -> None:
    model = run.model()
    clip = person_clip(run, model)
    assert clip is not None
    np.testing.assert_allclose(clip.time, [0.0, 0.1, 0.2])
    mine = ["palm", *(f"{finger}_distal" for finger in FINGERS)]
    robots = ["palm", *(f"{finger}_{PREFIX}{finger}_distal" for finger in FINGERS)]
    for person, robot in zip(clip.qpos, run.qpos, strict=True):
        np.testing.assert_allclose(
            axes(clip.model, person, mine), axes(model, robot, robots), atol=1e-6
        )


def test_it_is_seen_from_where_the_robot_is_and_stays_in_the_middle(run: Rollout) -> None:
    model = run.model()
    clip = person_clip(run, model)
    assert clip is not None
    data = mujoco.MjData(clip.model)
    for qpos in clip.qpos:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(clip.model, data)
        np.testing.assert_allclose(data.body("middle_proximal").xpos, 0.0, atol=1e-9)
    quat = clip.model.camera("view").quat
    np.testing.assert_allclose(quat, model.camera("view").quat)
    back = np.empty(3)
    mujoco.mju_rotVecQuat(back, np.array([0.0, 0.0, 1.0]), quat)
    place = clip.model.camera("view").pos
    np.testing.assert_allclose(place / np.linalg.norm(place), back, atol=1e-9)


def test_where_nobody_is_followed_none_is_shown(run: Rollout, ball: mujoco.MjModel) -> None:
    assert person_clip(run, ball) is None
    assert rollout_clip(run, measurements=False).companion is None


def test_films_have_it_as_their_inset_and_sheets_as_their_last_row(
    rendering: str, run: Rollout
) -> None:
    clip = rollout_clip(run)
    view, small = View("view", 320, 240, 10), View("view", 80, 60)
    frame = next(iter(render_clips([clip], view)))
    other = next(iter(render_clips([replace(clip, companion=None)], view)))
    differs = (frame != other).any(axis=2)
    assert differs[150:, 215:].mean() > 0.3
    assert frame[165:170, 300:312].min() > 205  # its plain background
    assert not differs[:140].any()
    assert not differs[:, :200].any()
    alone = next(iter(render_clips([clip], View("top", 320, 240, 10))))
    top = next(iter(render_clips([replace(clip, companion=None)], View("top", 320, 240, 10))))
    np.testing.assert_array_equal(alone, top)
    sheet = render_sheet(clip, small, n=2, columns=2)
    without = render_sheet(replace(clip, companion=None), small, n=2, columns=2)
    assert len(sheet) - len(without) == 60 + 2
    np.testing.assert_array_equal(sheet[: len(without)], without)
    assert np.ptp(sheet[len(without) + 2 :], axis=(0, 1)).min() > 60

"""The need of a planned grasp, from the task alone."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from handsim.grasping.gripping.need import LEAST
from handsim.grasping.planning.expected_need import (
    FINGER_SPACING,
    _pressing,
    centre_of_mass,
    expected_need,
)
from handsim.hand.mjcf import FRICTION
from handsim.objects.mjcf import OBJECTS
from handsim.physics import GRAVITY
from handsim.tasks.scene import build_scene
from handsim.tasks.table_one import TASKS, task_by_name

JAR = task_by_name("jar-move")
ROUNDED = 1 / np.cos(np.pi / 8)
"""How much too large a need comes out at most."""


@pytest.mark.parametrize("name", OBJECTS)
def test_the_centre_of_mass_is_that_of_the_model(name):
    """As MuJoCo has it, to a millimetre: it makes meshes convex where they are not."""
    model = build_scene(name, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = data.body("object")
    found = body.xmat.reshape(3, 3).T @ (data.subtree_com[model.body("object").id] - body.xpos)
    np.testing.assert_allclose(centre_of_mass(OBJECTS[name]), found, atol=1.5e-3)


def at_the_centre(task):
    """The task with its grasp about the centre of mass, by one finger and with no turning."""
    centre = tuple(centre_of_mass(task.object).tolist())
    grasp = replace(task.grasp, point=centre, fingers=("index",))
    return replace(task, grasp=grasp, steps=task.steps[:1])


@pytest.mark.parametrize("friction", [0.4, 0.8])
def test_two_sides_about_the_centre_of_mass_share_the_weight(friction):
    task = at_the_centre(JAR)
    exact = task.object.mass * GRAVITY / (2 * friction)
    assert exact * (1 - 1e-6) <= expected_need(task, friction) <= exact * ROUNDED


def test_light_things_need_a_newton():
    assert expected_need(at_the_centre(task_by_name("pen-move"))) == LEAST


def test_a_grasp_beside_the_centre_needs_more():
    """A hammer by its handle, some centimetres from its head: much more than its weight asks."""
    hammer = task_by_name("hammer-use")
    weight = hammer.object.mass * GRAVITY / (2 * FRICTION[0])
    assert expected_need(at_the_centre(hammer)) < 1.1 * max(weight, LEAST)
    away = replace(hammer.grasp, point=(hammer.grasp.point[0] - 0.06, *hammer.grasp.point[1:]))
    assert expected_need(replace(hammer, grasp=away)) > expected_need(hammer)


def test_the_turn_of_the_action_counts():
    """A book that is turned on its edge hangs otherwise than it stood."""
    needs = [(expected_need(task), expected_need(replace(task, steps=()))) for task in TASKS[::2]]
    assert all(whole >= still - 1e-9 for whole, still in needs)
    assert any(whole > 1.2 * still for whole, still in needs)


def test_thumb_and_fingers_press_from_both_sides_of_the_grasp():
    contacts = _pressing(JAR, 0.6)
    grasp = JAR.grasp
    assert len(contacts.points) == 5
    axis = np.array(grasp.opposition)
    sides = (contacts.points - grasp.point) @ axis
    np.testing.assert_allclose(sides, np.array([-1, 1, 1, 1, 1]) * grasp.width / 2)
    np.testing.assert_allclose(contacts.normals @ axis, [1, -1, -1, -1, -1])
    gaps = np.linalg.norm(np.diff(contacts.points[1:], axis=0), axis=1)
    np.testing.assert_allclose(gaps, FINGER_SPACING)
    middle = contacts.points[1:].mean(axis=0) - grasp.point
    np.testing.assert_allclose(middle, grasp.width / 2 * axis, atol=1e-12)
    np.testing.assert_allclose(contacts.friction, 0.6)
    np.testing.assert_allclose(contacts.torsion, FRICTION[1] * 0.6 / FRICTION[0])


def test_left_hands_need_as_much():
    for task in TASKS:
        if "unscrew" not in task.name and "click" not in task.name:
            mirrored = expected_need(task.for_side("left"))
            assert mirrored == pytest.approx(expected_need(task), rel=0.09), task.name

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import UnknownNameError
from handsim.objects.mjcf import OBJECTS
from handsim.tasks.scene import build_scene, hand_axes
from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASK_NAMES, TASKS, Task, task_by_name
from handsim.tasks.task import Pressed
from handsim.types import Side

NAMES = (
    "tall-glass-drink tall-glass-side-move tall-glass-top-move tall-glass-side-rotate mouse-slide "
    "mouse-left-click mouse-right-click cup-drink cup-side-move cup-top-move cup-side-rotate "
    "hammer-use ashtray-move cube-raise pen-write pen-move jar-move jar-unscrew "
    "screwdriver-operate book-read phone-view scissors-move scissors-use stapler-use"
)
"""Table I, No. 1 to 24."""

ALL = (*TASKS, PHONE_TODAY_VIEW)
every_task = pytest.mark.parametrize("task", ALL, ids=[task.name for task in ALL])
PLACED = [task for task in ALL if task.yaw_deg % 30.0]
"""Tasks whose objects lie turned as a person's arm would have them."""
COLLISION = np.array([0, 0, 0, 1, 0, 0], np.uint8)


def test_the_table_is_complete_and_in_order() -> None:
    assert tuple(NAMES.split()) == TASK_NAMES
    assert [task.number for task in TASKS] == list(range(1, 25))
    assert len({task.object_name for task in TASKS}) == 13


@every_task
def test_data_are_in_range(task: Task) -> None:
    grasp = task.grasp
    assert task.object_name in OBJECTS
    for vector in (grasp.opposition, grasp.approach, grasp.pointing or (1.0, 0.0, 0.0)):
        assert np.linalg.norm(vector) == pytest.approx(1.0, abs=1e-3)
    assert np.dot(grasp.opposition, grasp.approach) == pytest.approx(0.0, abs=1e-9)
    assert 0.005 < grasp.width <= 0.10
    assert 0.0 < grasp.point[2] < 0.15
    assert grasp.fingers
    assert "thumb" not in grasp.fingers
    assert task.steps
    for step in task.steps:
        assert 0.2 <= step.seconds <= 2.0
        assert np.linalg.norm(step.axis) == pytest.approx(1.0)
        assert any(step.shift) or step.angle_deg
    assert task.rule.lift >= 0
    assert task.rule.slip > 0


@every_task
def test_the_grasp_lies_midway_between_surfaces_its_width_apart(task: Task) -> None:
    """Seen along the opposition axis, the object's surfaces lie half the width to either side."""
    if task.grasp.kind == "loops":
        pytest.skip("the pads stand inside two loops; see the next test")
    model = build_scene(task, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    frame = data.body("object")
    turn = frame.xmat.reshape(3, 3)
    point, axis = frame.xpos + turn @ task.grasp.point, turn @ task.grasp.opposition
    for towards in (axis, -axis):
        start, hit = point + 0.2 * towards, np.zeros(1, np.int32)
        depth = 0.2 - mujoco.mj_ray(model, data, start, -towards, COLLISION, 1, -1, hit)
        assert depth == pytest.approx(task.grasp.width / 2, abs=5e-4)


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_pads_that_use_the_scissors_stand_in_its_loops(side: Side) -> None:
    """Both pads are free of the object, and pushed together they meet the loops' inner walls."""
    task = task_by_name("scissors-use").for_side(side)
    model = build_scene(task, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    turn = data.body("object").xmat.reshape(3, 3)
    middle = data.body("object").xpos + turn @ task.grasp.point
    axis = turn @ task.grasp.opposition
    hit = np.zeros(1, np.int32)
    bodies = []
    for towards in (-axis, axis):  # thumb, fingers
        pad = middle + towards * (task.grasp.width / 2 + 0.008)
        above = pad + np.array([0.0, 0.0, 0.1])
        down = np.array([0.0, 0.0, -1.0])
        mujoco.mj_ray(model, data, above, down, COLLISION, 1, -1, hit)
        assert hit[0] == -1  # the loop is open where the pad goes down
        gap = mujoco.mj_ray(model, data, pad, -towards, COLLISION, 1, -1, hit)
        assert 0.0 < gap < 0.012
        bodies.append(model.body(model.geom(hit[0]).bodyid[0]).name)
    assert bodies == ["blade", "object"]


@every_task
def test_rules_speak_of_what_the_object_has_and_the_action_can_do(task: Task) -> None:
    rule = task.rule
    hinges = {link.hinge.name: link.hinge for link in OBJECTS[task.object_name].links}
    turns = [abs(step.angle_deg) for step in task.steps if not step.flex]
    if rule.kind == "joint":
        assert rule.joint is not None
        start = dict(task.start_deg).get(rule.joint, 0.0)
        low, high = hinges[rule.joint].range_deg
        assert low < rule.angle_deg < high
        assert rule.angle_deg != start
    else:
        assert rule.joint is None
    if rule.kind == "turn":
        assert max(turns) > rule.angle_deg
    if rule.kind in ("slide", "trace"):
        assert max(np.linalg.norm(step.shift) for step in task.steps) >= rule.distance > 0
    if rule.kind in ("carry", "turn"):
        assert sum(step.shift[2] for step in task.steps) > rule.lift
        assert rule.hold == 3.0


def test_the_written_line_touches_the_paper() -> None:
    """Lifted, tilted and lowered, the pen's tip comes to within 1.5 mm above the table."""
    task = task_by_name("pen-write")
    turn = Rotation.from_euler("z", task.yaw_deg, degrees=True)
    tip = turn.apply([0.070 - task.grasp.point[0], 0.0, 0.0])
    height = task.grasp.point[2]
    for step in task.steps:
        height += step.shift[2]
        tip = Rotation.from_rotvec(np.deg2rad(step.angle_deg) * np.array(step.axis)).apply(tip)
    assert 0.0 <= height + tip[2] < 1.5e-3


def test_what_is_written_is_drawn_away_from_where_the_pen_points_back() -> None:
    """A pen is drawn, not pushed: its line goes where its tip points."""
    task = task_by_name("pen-write")
    front = Rotation.from_euler("z", task.yaw_deg, degrees=True).apply([1.0, 0.0, 0.0])
    line = max((np.array(step.shift) * [1, 1, 0] for step in task.steps), key=np.linalg.norm)
    assert abs(np.degrees(np.arccos(front @ line / np.linalg.norm(line)))) < 1.0


@every_task
def test_whatever_is_placed_otherwise_is_worked_otherwise_as_well(task: Task) -> None:
    """Seen from the object, axes and ways are along or across it, to a degree, or vertical."""
    back = Rotation.from_euler("z", -task.yaw_deg, degrees=True)
    for step in task.steps:
        axis = back.apply(step.axis)
        if step.angle_deg and not step.flex and abs(axis[2]) < 0.5 and task in PLACED:
            assert np.abs(axis).max() == pytest.approx(1.0, abs=2e-4)


@every_task
def test_everything_is_held_for_a_second_at_least_so_that_it_is_shaken(task: Task) -> None:
    assert task.rule.hold >= 1.0
    assert task.rule.lifted == (task.rule.kind in ("carry", "turn", "trace"))


def test_what_is_pressed_is_pressed_by_the_finger_that_is_named() -> None:
    pressed = {task.name: task.rule.pressed for task in ALL if task.rule.pressed}
    assert pressed == {
        "mouse-left-click": (Pressed(("index",), "left_button"),),
        "mouse-right-click": (Pressed(("middle",), "right_button"),),
        "scissors-use": (Pressed(("thumb",), "blade"), Pressed(("index", "middle"), "object")),
    }
    bodies = {link.hinge.name for task in ALL for link in OBJECTS[task.object_name].links}
    for task in ALL:
        assert {each.body for each in task.rule.pressed} <= {*bodies, "object"}


def test_only_hammer_and_scissors_are_mirrored_for_a_left_hand() -> None:
    """They are what lies otherwise than its mirror image: see the tests of the scene."""
    left = [task.for_side("left") for task in ALL]
    assert {each.object_name for each in left if each.mirrored} == {"hammer", "scissors"}
    for task, mirrored in zip(ALL, left, strict=True):
        assert (mirrored.object is task.object) == (not mirrored.mirrored)
    (hinge,) = (link.hinge for link in task_by_name("scissors-use").for_side("left").object.links)
    assert hinge.axis == (0.0, 0.0, 1.0)


def test_a_left_hand_presses_with_the_finger_that_lies_on_the_button() -> None:
    """Buttons are not mirrored; scissors are, and their blade is the thumb's in either hand."""
    left = {task.name: task.for_side("left").rule.pressed for task in ALL}
    assert left["mouse-left-click"] == (Pressed(("middle",), "left_button"),)
    assert left["mouse-right-click"] == (Pressed(("index",), "right_button"),)
    assert left["scissors-use"] == task_by_name("scissors-use").rule.pressed


@every_task
def test_the_left_hand_gets_the_mirror_image(task: Task) -> None:
    left = task.for_side("left")
    assert task.for_side("right") is task
    assert left.for_side("left") == task
    flip = np.diag([1.0, -1.0, 1.0])
    # Frames mirror as M R M: x and z columns mirror, the y column is reversed as well.
    np.testing.assert_allclose(hand_axes(left.grasp), flip @ hand_axes(task.grasp) @ flip)
    assert left.yaw_deg == -task.yaw_deg


def test_a_mirrored_click_uses_the_finger_over_that_button() -> None:
    right, left = (task_by_name("mouse-left-click").for_side(side) for side in ("right", "left"))
    assert right.rule.joint == left.rule.joint == "left_button"
    assert right.steps[0].flex == ("index",)
    assert left.steps[0].flex == ("middle",)


def test_a_mirrored_turn_mirrors_as_an_axial_vector() -> None:
    step = task_by_name("tall-glass-side-rotate").for_side("left").steps[1]
    assert step.axis == (0.0, 0.0, -1.0)
    drink = task_by_name("tall-glass-drink")
    assert drink.for_side("left").steps[1].axis == drink.steps[1].axis


@every_task
def test_tasks_are_values(task: Task) -> None:
    assert hash(task) == hash(replace(task))
    assert task == replace(task)


def test_tasks_are_found_by_name_and_misspelt_ones_answered() -> None:
    assert task_by_name("hammer-use").number == 12
    assert task_by_name("phone-today-view").object_name == "phone-today"
    with pytest.raises(UnknownNameError, match="cube-raise"):
        task_by_name("cube-rise")


def test_a_left_hand_unscrews_in_the_direction_of_the_thread():
    task = task_by_name("jar-unscrew")
    (right,), (left,) = task.steps, task.for_side("left").steps
    assert left.axis == right.axis
    (spun,) = [step for step in task_by_name("cup-side-rotate").steps if step.angle_deg]
    (mirrored,) = [
        step for step in task_by_name("cup-side-rotate").for_side("left").steps if step.angle_deg
    ]
    assert mirrored.axis == tuple(-part for part in spun.axis)

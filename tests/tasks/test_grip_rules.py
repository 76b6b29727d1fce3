"""What every grasp has to show, at its limits and a little beside them."""

from dataclasses import replace

import numpy as np
import pytest
from made_traces import (
    ACTION,
    HOLD,
    INDEX,
    PALM,
    THUMB,
    at,
    carried,
    hinged,
    moved,
    pinching,
    pressing,
)
from scipy.spatial.transform import Rotation

from handsim.tasks import grip_rules
from handsim.tasks.grip_rules import (
    MAX_PUSH,
    Shown,
    broken,
    finger_force,
    held_forces,
    opposed,
    opposed_share,
    pushed,
    table_force,
    working,
)
from handsim.tasks.rules import GraspTraces, judge
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.tasks.task import PassRule, Task

MOVE, CLICK = task_by_name("tall-glass-side-move"), task_by_name("mouse-left-click")
CARRY = PassRule("carry")
JOINT = PassRule("joint", joint="lid", angle_deg=40.0)
N = 520


def reason_of(traces: GraspTraces, task: Task) -> tuple[str, str] | None:
    return broken(traces, task, Shown.by(traces, task))


def reason(traces: GraspTraces, rule: PassRule = CARRY) -> str | None:
    found = reason_of(traces, replace(MOVE, rule=rule))
    return found and found[0]


def test_a_pinch_that_pushes_and_leans_on_nothing_breaks_no_rule():
    assert reason_of(carried(), MOVE) is None
    assert judge(carried(), MOVE).success


def test_the_limits_are_those_that_were_written_down_first():
    assert grip_rules.MAX_PUSH == 0.010
    assert grip_rules.MAX_PUSH_TURN_DEG == 10.0
    assert grip_rules.MAX_PENETRATION == 0.002
    assert grip_rules.MAX_FORCE == 60.0
    assert grip_rules.MAX_MARGIN == 4.0
    assert {task.rule.table_force for task in TASKS} == {15.0, 30.0}
    resting = {task.name for task in TASKS if task.rule.table_force == 30.0}
    assert resting == {"mouse-slide", "mouse-left-click", "mouse-right-click", "pen-write"}


@pytest.mark.parametrize("row", [0, 150, 519])
def test_hand_and_object_or_table_overlap_by_two_millimetres_at_most(row):
    traces = carried()
    assert reason(replace(traces, penetration=at(row, 0.002))) is None
    deep = replace(traces, penetration=at(row, np.nextafter(0.002, 1)))
    assert reason(deep) == "penetrated"
    assert judge(deep, MOVE).reason == "penetrated"
    assert "2.5 mm, more than 2" in reason_of(replace(traces, penetration=at(row, 0.0025)), MOVE)[1]


def displaced(distance: float, rows: slice) -> GraspTraces:
    """An object that is moved at some samples."""
    traces = carried(height=0.0)
    pos = np.zeros((N, 3))
    pos[rows, 0] = distance
    return replace(traces, object_pos=pos)


@pytest.mark.parametrize("rows", [slice(50, None), slice(20, 30), slice(ACTION, None)])
def test_an_object_is_pushed_by_a_centimetre_at_most_before_the_action(rows):
    """Also for a moment, and until the action's first sample."""
    traces = displaced(MAX_PUSH, rows)
    assert pushed(traces)[0] == MAX_PUSH
    assert reason(traces) is None
    assert reason(displaced(np.nextafter(MAX_PUSH, 1), rows)) == "pushed"


def test_what_moves_in_the_action_is_not_pushed():
    assert pushed(displaced(0.05, slice(ACTION + 1, None))) == (0.0, 0.0)
    assert pushed(carried()) == (0.0, 0.0)
    upwards = replace(carried(), object_pos=np.outer(np.arange(N) > 50, [0, 0, 0.011]))
    assert reason(upwards) == "pushed"


@pytest.mark.parametrize(("degrees", "expected"), [(9.999, None), (10.001, "pushed")])
@pytest.mark.parametrize("with_palm", [False, True])
def test_an_object_is_turned_by_10_deg_at_most_before_the_action(degrees, expected, with_palm):
    """A palm that turns as well does not make it better."""
    traces = carried()
    quat = Rotation.from_rotvec(np.outer(np.arange(N) > 50, [0, 0, np.deg2rad(degrees)])).as_quat(
        scalar_first=True
    )
    traces = replace(traces, object_quat=quat, symmetry=None)
    if with_palm:
        traces = replace(traces, palm_quat=quat)
    assert pushed(traces)[1] == pytest.approx(degrees)
    assert reason(traces) == expected
    assert reason(replace(traces, symmetry="z")) is None  # it looks as before


@pytest.mark.parametrize(("rule", "most"), [(CARRY, 15.0), (CLICK.rule, 30.0)])
def test_a_hand_leans_on_the_table_by_its_rules_limit_at_most(rule, most):
    traces = replace(carried(), table_force=np.full(N, most))
    assert table_force(traces) == pytest.approx(most, rel=1e-12)
    assert reason(replace(traces, table_force=np.full(N, most - 1e-6)), rule) is None
    assert reason(replace(traces, table_force=np.full(N, most + 1e-6)), rule) == "leaned"


@pytest.mark.parametrize("start", [0, 95, 510])
def test_forces_on_the_table_are_averaged_over_a_tenth_of_a_second(start):
    """A knock of 10 ms counts a tenth; what lasts for 100 ms counts whole."""
    traces = carried()
    assert reason(replace(traces, table_force=at(start, 149.0))) is None
    assert reason(replace(traces, table_force=at(start, 151.0))) == "leaned"
    lasting = slice(start, start + 10)
    assert table_force(replace(traces, table_force=at(lasting, 14.0))) == pytest.approx(14.0)


@pytest.mark.parametrize("finger", range(5))
def test_no_finger_presses_with_more_than_60_newton(finger):
    traces = hinged(0, 1.2)

    def with_force(force: float) -> GraspTraces:
        forces = traces.force.copy()
        forces[20:30, finger] = force
        return replace(traces, force=forces)

    assert finger_force(with_force(59.999)) == pytest.approx(59.999)
    assert reason(with_force(59.999), JOINT) is None
    assert reason(with_force(60.001), JOINT) == "crushed"


def test_the_palm_may_press_with_more():
    traces = hinged(0, 1.2)
    forces = traces.force.copy()
    forces[:, PALM] = 90.0
    assert reason(replace(traces, force=forces), JOINT) is None


@pytest.mark.parametrize("part", [THUMB, INDEX, PALM])
def test_what_is_lifted_is_held_with_four_times_the_need_at_most(part):
    """In the mean over the hold."""
    traces = replace(carried(), need=2.0)

    def held_with(force: float) -> GraspTraces:
        forces = traces.force.copy()
        forces[HOLD : HOLD + 160, part], forces[HOLD + 160 :, part] = force - 2.0, force + 2.0
        return replace(traces, force=forces)

    assert held_forces(held_with(8.0))[part] == pytest.approx(8.0)
    assert reason(held_with(7.999)) is None
    assert reason(held_with(8.001)) == "crushed"
    assert reason(held_with(8.001), JOINT) is None  # nothing is lifted
    assert "4.5 times the 2.0 N needed" in reason_of(held_with(9.0), MOVE)[1]


def test_forces_before_the_hold_are_no_margin():
    traces = carried()
    forces = traces.force.copy()
    forces[:HOLD] = 50.0
    assert reason(replace(traces, force=forces)) is None


def at_angle(degrees: float, thumb: float = 3.0, rest: float = 3.0) -> GraspTraces:
    """What thumb and the rest of the hand, finger and palm, press at an angle to each other."""
    press = np.zeros((N, 6, 3))
    press[:, THUMB] = [0.0, 0.0, thumb]
    angle = np.deg2rad(degrees)
    press[:, [INDEX, PALM]] = 0.5 * rest * np.array([np.sin(angle), 0.0, np.cos(angle)])
    return pressing(carried(), press)


@pytest.mark.parametrize(
    ("degrees", "is_opposed"), [(180, True), (121, True), (119, False), (90, False), (0, False)]
)
def test_thumb_and_the_rest_press_against_each_other_at_120_deg_or_more(degrees, is_opposed):
    traces = at_angle(degrees)
    assert opposed(traces).all() == is_opposed == opposed(traces).any()
    assert reason(traces) == (None if is_opposed else "not opposed")


@pytest.mark.parametrize(
    ("thumb", "rest", "is_opposed"),
    [(0.2, 3.0, True), (0.199, 3.0, False), (3.0, 0.201, True), (3.0, 0.199, False)],
)
def test_both_sides_press_with_a_fifth_of_a_newton(thumb, rest, is_opposed):
    assert opposed(at_angle(180.0, thumb, rest)).all() == is_opposed


def test_fingers_that_press_against_each_other_do_not_oppose_the_thumb():
    press = pinching(N)
    press[:, INDEX, 1], press[:, INDEX + 1, 1], press[:, INDEX + 2] = 3.0, -3.0, 0.0
    press[:, THUMB] = 0.0
    assert not opposed(pressing(carried(), press)).any()


def test_a_finger_that_clicks_is_no_side_of_the_grip():
    """Thumb and ring finger hold the mouse, and what the index presses is the click."""
    press = np.zeros((N, 6, 3))
    press[:, THUMB], press[:, INDEX + 2] = [1.2, 0.0, 0.0], [-1.2, 0.0, 0.0]
    press[:, INDEX] = [1.0, -4.0, -4.0]
    clicking = pressing(hinged(0.0, 3.0), press)
    assert working(CLICK) == [INDEX]
    assert working(task_by_name("mouse-right-click")) == [INDEX + 1]
    assert not opposed(clicking).any()
    assert opposed(clicking, working(CLICK)).all()
    assert judge(clicking, CLICK).opposed == 1.0
    assert reason_of(clicking, CLICK) is None
    press[:, INDEX + 2] = 0.0
    assert judge(pressing(hinged(0.0, 3.0), press), CLICK).reason == "not opposed"


def test_fingers_that_hold_what_they_work_do_count():
    """Scissors are held by their loops."""
    assert [task.name for task in TASKS if working(task)] == [
        "mouse-left-click",
        "mouse-right-click",
    ]


@pytest.mark.parametrize(
    ("rows", "share", "expected"),
    [
        (slice(ACTION, ACTION + 5), 0.95, None),
        (slice(ACTION, ACTION + 6), 0.94, "not opposed"),
        (slice(HOLD, HOLD + 16), 0.95, None),
        (slice(HOLD, HOLD + 17), 1 - 17 / 320, "not opposed"),
        (slice(0, ACTION), 1.0, None),  # the hand has yet to close
    ],
)
def test_a_hand_is_opposed_for_most_of_action_and_hold_each(rows, share, expected):
    """Of 100 samples of the action 5 may lack, of 320 of the hold 16."""
    press = pinching(N)
    press[rows, THUMB] = 0.0
    traces = pressing(carried(), press)
    assert opposed_share(traces) == pytest.approx(share)
    assert reason(traces) == expected


def test_a_run_that_ended_before_its_action_was_opposed_in_none_of_it():
    traces = carried()
    over = replace(traces, action_start=9.0, hold_start=10.0)
    assert opposed_share(over) == 0.0


def test_pushing_hands_and_flat_hands_are_not_opposed():
    """Whatever else they do as asked."""
    slide = task_by_name("mouse-slide")
    press = np.zeros((N, 6, 3))
    press[:, PALM, 2] = -5.0
    assert judge(pressing(moved(slide, 0.08), press), slide).reason == "not opposed"
    assert judge(pressing(hinged(0, 1.2), press), CLICK).reason == "not opposed"


def test_of_several_broken_rules_the_first_is_told():
    traces = displaced(0.02, slice(50, None))
    traces = replace(traces, penetration=np.full(N, 0.003), table_force=np.full(N, 99.0))
    traces = pressing(traces, 100.0 * np.ones((N, 6, 3)))
    told = []
    for mend in (
        {"penetration": np.zeros(N)},
        {"object_pos": np.zeros((N, 3))},
        {"table_force": np.zeros(N)},
        {"force": np.full((N, 6), 50.0)},
        {"press": pinching(N)},
        {"need": 20.0},
    ):
        told.append(reason(traces))
        traces = replace(traces, **mend)
    assert told == ["penetrated", "pushed", "leaned", "crushed", "not opposed", "crushed"]
    assert reason(traces) is None

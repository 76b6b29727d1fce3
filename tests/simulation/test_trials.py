from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.hand.tasks import task_by_name
from handsim.simulation.trials import GraspTraces, judge, wilson_interval

MOVE = task_by_name("tall-glass-side-move")
CUBE = task_by_name("cube-raise")
DRINK = task_by_name("tall-glass-drink")
RATE = 100.0
LIFT_TIME, LIFT_DURATION, HEIGHT = 1.0, 1.0, 0.12


def carried(hold: float = 3.2, height: float = HEIGHT) -> GraspTraces:
    """A palm that rests, lifts an object by ``height``, and holds it, without any slip."""
    time = np.arange(0.0, LIFT_TIME + LIFT_DURATION + hold, 1 / RATE)
    up = height * np.clip((time - LIFT_TIME) / LIFT_DURATION, 0, 1)
    lift = np.outer(up, [0, 0, 1.0])
    still = np.tile([1.0, 0, 0, 0], (len(time), 1))
    return GraspTraces(
        time=time,
        object_pos=lift + [0.1, 0, 0.07],
        object_quat=still,
        palm_pos=lift + [0.0, 0.05, 0.08],
        palm_quat=still,
        touching=np.full(len(time), 4),
        penetration=np.full(len(time), 5e-4),
        action_start=LIFT_TIME,
        symmetry="z",
    )


def turned(traces: GraspTraces, axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """Quaternions of a turn that grows with the lift and stays."""
    part = np.clip((traces.time - LIFT_TIME) / LIFT_DURATION, 0, 1)
    angles = np.deg2rad(degrees) * part
    return Rotation.from_rotvec(np.outer(angles, axis)).as_quat(scalar_first=True)


def test_a_perfect_carry_succeeds_with_exact_figures():
    outcome = judge(carried(), MOVE)
    assert outcome.success
    assert outcome.reason is None
    assert outcome.lift_m == pytest.approx(HEIGHT)
    assert outcome.peak_slip_m == pytest.approx(0.0, abs=1e-12)
    assert outcome.hold_s >= 3.0
    assert outcome.contacts == 4


def test_too_short_a_hold_fails():
    assert judge(carried(hold=2.0), MOVE).reason == "slipped"


def test_too_low_a_lift_fails():
    assert not judge(carried(height=0.09), MOVE).success
    assert judge(carried(height=0.015), MOVE).reason == "missed"


def test_peak_slip_counts_even_where_the_end_looks_good():
    traces = carried()
    pos = traces.object_pos.copy()
    pos[250:260] += [0.03, 0, 0]
    outcome = judge(replace(traces, object_pos=pos), MOVE)
    assert not outcome.success
    assert outcome.peak_slip_m == pytest.approx(0.03)
    assert outcome.reason == "slipped"


def test_displacement_before_the_lift_is_no_slip():
    traces = carried()
    pos = traces.object_pos.copy()
    pos[:50] -= [0.01, 0, 0]
    assert judge(replace(traces, object_pos=pos), MOVE).peak_slip_m == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("task", "succeeds"), [(MOVE, True), (CUBE, False)])
def test_turns_about_the_axis_of_symmetry_are_free(task, succeeds):
    traces = carried()
    quat = turned(traces, (0, 0, 1), 90)
    symmetry = "z" if task is MOVE else None
    outcome = judge(replace(traces, object_quat=quat, symmetry=symmetry), task)
    assert outcome.success is succeeds
    assert outcome.peak_tilt_deg == pytest.approx(0 if succeeds else 90, abs=1e-6)


def test_tilt_counts_from_the_first_pose():
    traces = carried()
    quat = traces.object_quat.copy()
    quat[20:] = Rotation.from_euler("x", 40, degrees=True).as_quat(scalar_first=True)
    outcome = judge(replace(traces, object_quat=quat), MOVE)
    assert outcome.reason == "tilted"
    assert outcome.peak_tilt_deg == pytest.approx(40)


@pytest.mark.parametrize(("degrees", "succeeds"), [(45, True), (20, False)])
def test_turning_tasks_need_the_turn_and_forgive_it_as_tilt(degrees, succeeds):
    traces = carried()
    axis = next(step.axis for step in DRINK.steps if step.angle_deg)
    quat = turned(traces, axis, degrees)
    palm = Rotation.from_quat(quat, scalar_first=True)
    centre = traces.palm_pos + palm.apply(np.array([0.1, -0.05, -0.01]))
    traces = replace(traces, object_quat=quat, palm_quat=quat, object_pos=centre)
    outcome = judge(traces, DRINK)
    assert outcome.peak_slip_m == pytest.approx(0.0, abs=1e-9)
    assert outcome.success is succeeds
    assert succeeds or f"{degrees} deg" in outcome.detail


def test_other_failures_have_their_reasons():
    traces = carried(height=0.0)
    assert judge(traces, MOVE).reason == "missed"
    assert judge(replace(traces, arrived=False), MOVE).reason == "not arrived"
    assert judge(replace(traces, unstable_at=0.5), MOVE).reason == "unstable"
    deep = np.full(len(traces.time), 0.012)
    assert judge(replace(carried(), penetration=deep), MOVE).reason == "penetrated"


def test_letting_go_ends_the_hold():
    traces = carried()
    touching = traces.touching.copy()
    touching[300:] = 0
    assert not judge(replace(traces, touching=touching), MOVE).success


SLIDE = task_by_name("mouse-slide")
CLICK = task_by_name("mouse-left-click")
SCISSORS = task_by_name("scissors-use")
WRITE = task_by_name("pen-write")


def moved(distance: float, up: float = 0.0) -> GraspTraces:
    """Palm and object displaced together along the table in the action."""
    traces = carried(height=0.0)
    part = np.clip((traces.time - LIFT_TIME) / LIFT_DURATION, 0, 1)
    shift = np.outer(part, [distance, 0, up])
    return replace(traces, object_pos=traces.object_pos + shift, palm_pos=traces.palm_pos + shift)


def test_sliding_asks_for_distance_on_the_table():
    assert judge(moved(0.08), SLIDE).success
    short = judge(moved(0.05), SLIDE)
    assert short.reason == "slipped"
    assert "50 of 60 mm" in short.detail
    assert judge(moved(0.08, up=0.02), SLIDE).reason == "slipped"  # lifted instead


def test_a_hand_that_slides_off_has_not_slid_the_object():
    traces = moved(0.08)
    stays = np.tile(traces.object_pos[0], (len(traces.time), 1))
    outcome = judge(replace(traces, object_pos=stays), SLIDE)
    assert outcome.reason == "slipped"
    assert outcome.peak_slip_m == pytest.approx(0.08)


def hinged(start_deg: float, end_deg: float, from_time: float = LIFT_TIME) -> GraspTraces:
    """An object that stands where it is while its hinge turns."""
    traces = carried(height=0.0)
    part = np.clip((traces.time - from_time) / 0.3, 0, 1)
    return replace(traces, hinge=np.deg2rad(start_deg + part * (end_deg - start_deg)))


@pytest.mark.parametrize(
    ("task", "start", "end", "succeeds"),
    [
        (CLICK, 0, 1.2, True),
        (CLICK, 0, 0.9, False),
        (SCISSORS, 30, 8, True),
        (SCISSORS, 30, 12, False),
    ],
)
def test_hinges_must_pass_their_angle_from_the_side_they_start_on(task, start, end, succeeds):
    outcome = judge(hinged(start, end), task)
    assert outcome.success is succeeds
    assert outcome.reason == (None if succeeds else "missed")


def test_a_button_that_is_pressed_before_the_action_is_no_click():
    outcome = judge(hinged(0, 1.2, from_time=0.3), CLICK)
    assert outcome.reason == "missed"
    assert "before the action" in outcome.detail


def test_an_object_worked_where_it_stands_must_stay_there():
    traces = hinged(0, 1.2)
    away = traces.object_pos + np.outer(np.linspace(0, 1, len(traces.time)), [0.03, 0, 0])
    follow = replace(traces, object_pos=away, palm_pos=away)
    assert judge(follow, CLICK).reason == "slipped"


def drawn(distance: float, height: float = 0.001, lift: float = HEIGHT) -> GraspTraces:
    """A carried object whose front end moves along the table in the hold."""
    traces = carried(height=lift)
    part = np.clip((traces.time - 2.0) / 1.0, 0, 1)
    front = np.column_stack([0 * part, -distance * part, height + 0 * part])
    front[traces.time < 2.0, 2] = 0.05
    return replace(traces, front_pos=front)


def test_tracing_asks_for_a_line_on_the_table():
    assert judge(drawn(0.055), WRITE).success
    assert judge(drawn(0.045), WRITE).reason == "slipped"
    assert judge(drawn(0.055, height=0.004), WRITE).reason == "slipped"
    assert judge(drawn(0.055, lift=0.04), WRITE).reason == "slipped"  # dragged, not lifted


def test_a_line_with_a_gap_counts_for_its_longer_part():
    traces = drawn(0.09)
    assert traces.front_pos is not None
    front = traces.front_pos.copy()
    middle = int(np.searchsorted(-front[:, 1], 0.045))
    front[middle : middle + 2, 2] = 0.02
    outcome = judge(replace(traces, front_pos=front), WRITE)
    assert outcome.reason == "slipped"
    assert "mm" in outcome.detail


def test_wilson_interval_against_published_values():
    # Newcombe (1998), Stat. Med. 17:857-872, Table I, method 3: 81 of 263 and 0 of 20.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson_interval(0, 0) == (0.0, 1.0)

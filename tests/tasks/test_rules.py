from dataclasses import replace

import numpy as np
import pytest
from made_traces import (
    ACTION,
    HEIGHT,
    HOLD,
    LIFT_TIME,
    RATE,
    acting,
    asked,
    at,
    carried,
    drawn,
    hinged,
    moved,
    pinching,
    pressing,
    turned,
)
from scipy.spatial.transform import Rotation

from handsim.grasping.judging.rates import wilson_interval
from handsim.joints import CONTACT_PARTS
from handsim.tasks.rules import GraspTraces, Outcome, judge
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import PassRule, Step, Task

MOVE = task_by_name("tall-glass-side-move")
CUBE = task_by_name("cube-raise")
DRINK = task_by_name("tall-glass-drink")
SLIDE = task_by_name("mouse-slide")
CLICK = task_by_name("mouse-left-click")
SCISSORS = task_by_name("scissors-use")
WRITE = task_by_name("pen-write")


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
    press = traces.press.copy()
    press[300:] = 0
    outcome = judge(pressing(traces, press), MOVE)
    assert (outcome.reason, outcome.contacts) == ("slipped", 0)
    assert outcome.hold_s == pytest.approx(1.15)


def test_sliding_asks_for_distance_on_the_table():
    assert judge(moved(SLIDE, 0.08), SLIDE).success
    short = judge(moved(SLIDE, 0.05), SLIDE)
    assert short.reason == "slipped"
    assert "50 of 60 mm" in short.detail
    assert judge(moved(SLIDE, 0.08, up=0.02), SLIDE).reason == "slipped"  # lifted instead


def test_a_hand_that_slides_off_has_not_slid_the_object():
    traces = moved(SLIDE, 0.08)
    stays = np.tile(traces.object_pos[0], (len(traces.time), 1))
    outcome = judge(replace(traces, object_pos=stays), SLIDE)
    assert outcome.reason == "slipped"
    assert outcome.peak_slip_m == pytest.approx(0.08)


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
    outcome = judge(hinged(start, end, n_pressed=len(task.rule.pressed)), task)
    assert outcome.success is succeeds
    assert outcome.reason == (None if succeeds else "missed")


def test_a_button_that_is_pressed_before_the_action_is_no_click():
    outcome = judge(hinged(0, 1.2, from_time=0.3), CLICK)
    assert outcome.reason == "missed"
    assert "before the action" in outcome.detail


def test_an_object_worked_where_it_stands_must_stay_there():
    traces = hinged(0, 1.2)
    way = np.outer(acting(traces), [1.0, 0, 0])

    def away(distance: float) -> GraspTraces:
        pos = traces.object_pos + distance * way
        return replace(traces, object_pos=pos, palm_pos=pos)

    assert shown(away(0.0099), CLICK) == (True, None)
    outcome = judge(away(0.0102), CLICK)
    assert (outcome.reason, outcome.peak_slip_m) == ("slipped", pytest.approx(0.0102, rel=0.02))


def test_tracing_asks_for_a_line_on_the_table():
    assert judge(drawn(WRITE, 0.055), WRITE).success
    assert judge(drawn(WRITE, 0.045), WRITE).reason == "slipped"
    assert judge(drawn(WRITE, 0.055, height=0.004), WRITE).reason == "slipped"
    assert judge(drawn(WRITE, 0.055, lift=0.04), WRITE).reason == "slipped"  # dragged, not lifted


def test_a_line_with_a_gap_counts_for_its_longer_part():
    traces = drawn(WRITE, 0.09)
    assert traces.front_pos is not None
    front = traces.front_pos.copy()
    middle = int(np.searchsorted(front @ asked(WRITE), 0.045))
    front[middle : middle + 2, 2] = 0.02
    outcome = judge(replace(traces, front_pos=front), WRITE)
    assert outcome.reason == "slipped"
    assert "mm" in outcome.detail


def test_wilson_interval_against_published_values():
    # Newcombe (1998), Stat. Med. 17:857-872, Table I, method 3: 81 of 263 and 0 of 20.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson_interval(0, 0) == (0.0, 1.0)
    assert wilson_interval(20, 20) == pytest.approx((0.8389, 1.0), abs=5e-5)


def ruled(task: Task, **values: float) -> Task:
    """The task with some of its rule's limits changed."""
    return replace(task, rule=replace(task.rule, **values))


def shown(traces: GraspTraces, task: Task) -> tuple[bool, str | None]:
    outcome = judge(traces, task)
    return outcome.success, outcome.reason


def held_for(*stretches: int) -> GraspTraces:
    """A carry that is touched during stretches of so many samples after the lift, apart by one."""
    traces = carried(hold=(sum(stretches) + 2 * len(stretches) - 1) / RATE)
    press, first = pinching(len(traces.time)), 200
    for n in stretches:
        press[first - 1] = 0.0
        first += n + 2
    press[first - 1 :] = 0.0
    return pressing(traces, press)


@pytest.mark.parametrize(("samples", "succeeds"), [(300, True), (299, True), (298, False)])
def test_the_time_held_may_lack_one_sample(samples, succeeds):
    outcome = judge(held_for(samples), MOVE)
    assert outcome.hold_s == pytest.approx(samples / RATE)
    assert (outcome.success, outcome.reason) == (succeeds, None if succeeds else "slipped")


def test_the_longest_stretch_counts_and_a_gap_ends_it():
    assert judge(held_for(300, 50), MOVE).success
    assert judge(held_for(300, 50), MOVE).hold_s == pytest.approx(3.0)
    assert judge(held_for(50, 300), MOVE).success
    assert judge(held_for(200, 200), MOVE).reason == "slipped"


def test_what_sinks_below_the_height_is_not_held_there():
    traces = carried()
    sunk = np.where(traces.time > 2.2, 0.03, 0.0)[:, None] * [0, 0, 1.0]
    low = replace(traces, object_pos=traces.object_pos - sunk, palm_pos=traces.palm_pos - sunk)
    outcome = judge(low, MOVE)
    assert outcome.lift_m == pytest.approx(HEIGHT)
    assert outcome.reason == "slipped"
    assert outcome.hold_s < 0.5


def test_what_is_set_down_after_its_time_was_held():
    traces = carried(hold=4.0)
    down = np.where(traces.time > 5.2, HEIGHT, 0.0)[:, None] * [0, 0, 1.0]
    lowered = replace(traces, object_pos=traces.object_pos - down, palm_pos=traces.palm_pos - down)
    outcome = judge(lowered, MOVE)
    assert outcome.success
    assert outcome.lift_m == pytest.approx(HEIGHT)


def test_height_is_that_over_the_first_pose():
    """What falls over before the action has to make up for it."""
    traces = carried()
    fallen = np.where(traces.time > 0.5, 0.03, 0.0)[:, None] * [0, 0, 1.0]
    outcome = judge(replace(traces, object_pos=traces.object_pos - fallen), MOVE)
    assert outcome.lift_m == pytest.approx(HEIGHT - 0.03)
    assert not outcome.success


def test_exactly_the_height_is_enough():
    traces = carried()
    lift = judge(traces, MOVE).lift_m
    assert judge(traces, ruled(MOVE, lift=lift)).success
    assert not judge(traces, ruled(MOVE, lift=np.nextafter(lift, 1))).success
    flat = moved(SLIDE, 0.08)
    outcome = judge(flat, ruled(SLIDE, lift=0.0))
    assert outcome.success
    assert outcome.hold_s == pytest.approx(flat.time[-1] - LIFT_TIME)


def test_a_fifth_of_the_height_is_a_grasp_that_slipped():
    assert judge(carried(height=0.019), MOVE).reason == "missed"
    assert judge(carried(height=0.021), MOVE).reason == "slipped"


def slipped(distance: float, start: int, stop: int) -> GraspTraces:
    traces = carried()
    pos = traces.object_pos.copy()
    pos[start:stop, 0] += distance
    return replace(traces, object_pos=pos)


def tilted(degrees: float, start: int, stop: int) -> GraspTraces:
    traces = carried()
    quat = traces.object_quat.copy()
    quat[start:stop] = Rotation.from_euler("x", degrees, degrees=True).as_quat(scalar_first=True)
    return replace(traces, object_quat=quat)


def test_exactly_the_limit_of_slip_or_tilt_is_too_much():
    """For a moment of the lift, or from then on."""
    for stop in (130, 600):
        off = slipped(0.015, 120, stop)
        slip = judge(off, MOVE).peak_slip_m
        assert shown(off, ruled(MOVE, slip=slip)) == (False, "slipped")
        assert judge(off, ruled(MOVE, slip=np.nextafter(slip, 1))).success
        askew = tilted(20.0, 120, stop)
        tilt = judge(askew, MOVE).peak_tilt_deg
        assert tilt == pytest.approx(20.0)
        assert shown(askew, ruled(MOVE, tilt_deg=tilt)) == (False, "tilted")
        assert judge(askew, ruled(MOVE, tilt_deg=np.nextafter(tilt, 90))).success


@pytest.mark.parametrize("symmetry", [None, "x", "z"])
def test_tilts_before_and_in_the_action_add_up(symmetry):
    traces = carried()
    angle = 20.0 * (traces.time > 0.5) + 20.0 * (traces.time > 1.5)
    quat = Rotation.from_rotvec(np.outer(np.deg2rad(angle), [0, 1, 0])).as_quat(scalar_first=True)
    outcome = judge(replace(traces, object_quat=quat, symmetry=symmetry), MOVE)
    assert outcome.peak_tilt_deg == pytest.approx(40.0)
    assert outcome.reason == "tilted"


def test_peaks_before_a_whole_hold_count():
    """Each fails for a tenth of a second of the lift, three whole seconds before the end."""
    assert shown(slipped(0.021, 120, 130), MOVE) == (False, "slipped")
    assert shown(slipped(0.019, 120, 130), MOVE) == (True, None)
    assert shown(tilted(31.0, 120, 130), MOVE) == (False, "tilted")
    assert shown(tilted(29.0, 120, 130), MOVE) == (True, None)
    assert judge(tilted(31.0, 120, 130), MOVE).hold_s >= 3.0


def test_the_time_held_is_that_within_all_limits():
    """From sample 300 of 520 on something is wrong; the height is reached at sample 184."""
    assert judge(slipped(0.03, 300, 520), MOVE).hold_s == pytest.approx(1.15)
    assert judge(tilted(40.0, 300, 520), MOVE).hold_s == pytest.approx(1.15)


def test_an_object_that_moves_and_tilts_slipped():
    both = replace(slipped(0.03, 250, 600), object_quat=tilted(40.0, 250, 600).object_quat)
    assert judge(both, MOVE).reason == "slipped"


def test_contacts_are_those_at_the_end():
    traces = carried()
    assert judge(traces, MOVE).contacts == 4
    press = traces.press.copy()
    press[-1, 2:] = 0.0
    assert judge(pressing(traces, press), MOVE).contacts == 2


def test_a_hand_that_was_late_and_held_has_held():
    assert judge(replace(carried(), arrived=False), MOVE).success


def test_divergence_beats_all_and_tells_its_step():
    outcome = judge(replace(carried(), unstable_at=5.19), MOVE)
    expected = Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0)
    assert replace(outcome, detail="") == expected
    assert "step 519" in outcome.detail


def test_a_palm_that_turns_on_its_way_tilts_nothing():
    traces = carried()
    angle = np.deg2rad(60) * np.clip(1 - traces.time / 0.9, 0, 1)
    quat = Rotation.from_rotvec(np.outer(angle, [1, 0, 0])).as_quat(scalar_first=True)
    outcome = judge(replace(traces, palm_quat=quat), MOVE)
    assert outcome.success
    assert outcome.peak_tilt_deg == pytest.approx(0.0, abs=1e-9)


def test_a_palm_that_turns_out_of_its_object_lets_it_tilt():
    traces = carried()
    outcome = judge(replace(traces, palm_quat=turned(traces, (1, 0, 0), 40)), MOVE)
    assert outcome.peak_tilt_deg == pytest.approx(40)
    assert not outcome.success


@pytest.mark.parametrize(("axis", "degrees"), [((1, 0, 0), 0), ((0, 1, 0), 50), ((0, 0, 1), 50)])
def test_things_that_are_round_about_x_may_roll_about_it_alone(axis, degrees):
    traces = carried()
    rolled = replace(traces, object_quat=turned(traces, axis, 50), symmetry="x")
    assert judge(rolled, MOVE).peak_tilt_deg == pytest.approx(degrees, abs=1e-6)


def together(degrees: float, axis: tuple[float, float, float], before: float = 0.0) -> GraspTraces:
    """An object that turns with the palm about itself: ``before`` the action, and in it."""
    traces = carried()
    angle = before * np.clip(traces.time / 0.5, 0, 1) + degrees * acting(traces)
    quat = Rotation.from_rotvec(np.deg2rad(np.outer(angle, axis))).as_quat(scalar_first=True)
    palm = Rotation.from_quat(quat, scalar_first=True)
    centre = traces.palm_pos + palm.apply(np.array([0.1, -0.05, -0.01]))
    return replace(traces, object_quat=quat, palm_quat=quat, object_pos=centre)


SPIN = task_by_name("tall-glass-side-rotate")


def test_turns_count_in_their_direction_and_in_the_action_alone():
    assert shown(together(46, (0, 0, 1)), SPIN) == (True, None)
    assert shown(together(44, (0, 0, 1)), SPIN) == (False, "slipped")
    assert judge(together(45.0 / 2, (0, 0, 1)), SPIN).done == pytest.approx(0.5)
    assert shown(together(-60, (0, 0, 1)), SPIN) == (False, "slipped")
    assert shown(together(30, (0, 0, 1), before=30), SPIN) == (False, "slipped")
    # The hand knocks it round before the action: as seen from the action it was turned then.
    assert shown(together(0, (0, 0, 1), before=-60), SPIN) == (False, "slipped")


def test_turns_are_about_the_worlds_axes():
    traces = together(40, (0, -1, 0))
    yaw = Rotation.from_euler("z", 90, degrees=True)
    quat = Rotation.from_quat(traces.object_quat, scalar_first=True) * yaw
    assert judge(replace(traces, object_quat=quat.as_quat(scalar_first=True)), DRINK).success


def test_fingers_that_flex_turn_nothing():
    press = Step(0.3, flex=("index",), angle_deg=12.0)
    task = replace(DRINK, steps=(press, *DRINK.steps))
    assert judge(together(40, (0, -1, 0)), task).success
    assert judge(together(40, (0, 0, 1)), task).reason == "slipped"


def test_exactly_the_way_is_enough():
    traces = moved(SLIDE, 0.08)
    way = float(np.linalg.norm((traces.object_pos[-1] - traces.object_pos[0])[:2]))
    assert judge(traces, ruled(SLIDE, distance=way)).success
    assert not judge(traces, ruled(SLIDE, distance=np.nextafter(way, 1))).success
    pressed = hinged(0, 1.2)
    assert pressed.hinge is not None
    angle = float(np.rad2deg(pressed.hinge.max()))
    assert judge(pressed, ruled(CLICK, angle_deg=angle)).success
    assert not judge(pressed, ruled(CLICK, angle_deg=np.nextafter(angle, 2))).success


def test_slides_are_measured_along_the_table_and_in_the_action():
    assert judge(moved(SLIDE, 0.0595, up=0.0095), SLIDE).reason == "slipped"
    traces = moved(SLIDE, 0.04)
    pushed = traces.object_pos - np.where(traces.time < 0.5, 0.03, 0.0)[:, None] * [1.0, 0, 0]
    outcome = judge(replace(traces, object_pos=pushed), SLIDE)
    assert outcome.reason == "slipped"
    assert outcome.done == pytest.approx(0.04 / 0.06)


def test_buttons_count_in_the_action_alone():
    traces = hinged(0, 0)
    before = np.where((traces.time > 0.3) & (traces.time < 0.6), np.deg2rad(1.2), 0.0)
    assert judge(replace(traces, hinge=before), CLICK).reason == "missed"
    again = before + np.where(abs(traces.time - 1.7) < 0.2, np.deg2rad(1.2), 0.0)
    outcome = judge(replace(traces, hinge=again), CLICK)
    assert (outcome.success, outcome.done) == (True, 1.0)
    lifted = np.where(traces.time > 0.3, np.deg2rad(-0.4), 0.0)
    assert judge(replace(traces, hinge=lifted), CLICK).done == 0.0
    half = judge(hinged(30, 20, n_pressed=2), SCISSORS)
    assert half.done == pytest.approx(0.5)


def test_a_worked_object_stays_and_stands_as_it_was_at_first():
    """Also if the hand pushes it before the action, or turns it together with itself."""
    traces = hinged(0, 1.2)
    pushed = traces.object_pos + np.where(traces.time > 0.5, 0.03, 0.0)[:, None] * [1.0, 0, 0]
    assert judge(replace(traces, object_pos=pushed, palm_pos=pushed), CLICK).reason == "slipped"
    quat = turned(traces, (1, 0, 0), 40)
    assert judge(replace(traces, object_quat=quat, palm_quat=quat), CLICK).reason == "tilted"


def test_a_worked_object_need_not_rise():
    assert judge(hinged(0, 1.2), ruled(CLICK, lift=0.1)).success


@pytest.mark.parametrize(("height", "succeeds"), [(0.0029, True), (0.003, True), (0.0031, False)])
def test_a_front_end_draws_within_three_millimetres(height, succeeds):
    assert judge(drawn(WRITE, 0.055, height=height), WRITE).success is succeeds


def test_a_line_counts_by_its_greatest_extent_in_the_action():
    traces = drawn(WRITE, 0.055)
    assert traces.front_pos is not None
    back = traces.front_pos.copy()
    back[400:] = back[250]
    assert judge(replace(traces, front_pos=back), WRITE).success
    early = traces.front_pos.copy()
    early[:, :2] = 0.0
    early[:90] = np.outer(np.linspace(0, 0.06, 90), asked(WRITE)) + [0, 0, 0.001]
    outcome = judge(replace(traces, front_pos=early), WRITE)
    assert (outcome.reason, outcome.done) == ("slipped", 0.0)


def test_figures_of_a_rule_without_an_action():
    assert PassRule("carry") == MOVE.rule
    assert judge(carried(), MOVE).done == 1.0
    assert judge(carried(height=0.0), MOVE).done == 1.0


def in_hold(traces: GraspTraces, shift: float, turn_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (n, 3) and quaternions (n, 4) of what is moved and turned in the hold alone."""
    part = np.clip((traces.time - 2.0) / 0.5, 0, 1)
    rotation = Rotation.from_rotvec(np.outer(np.deg2rad(turn_deg) * part, [1.0, 0, 0]))
    return np.outer(part, [shift, 0, 0]), rotation.as_quat(scalar_first=True)


def test_a_worked_object_may_follow_a_hand_that_is_shaken_in_the_hold():
    """But it may not slip or tilt in it."""
    traces = hinged(0, 1.2)
    shift, quat = in_hold(traces, 0.03, 0.0)
    follows = replace(traces, object_pos=traces.object_pos + shift)
    with_palm = replace(follows, palm_pos=traces.palm_pos + shift)
    assert shown(with_palm, CLICK) == (True, None)
    outcome = judge(follows, CLICK)
    assert (outcome.reason, outcome.peak_slip_m) == ("slipped", pytest.approx(0.03))
    _, quat = in_hold(traces, 0.0, 11.0)
    assert shown(replace(traces, object_quat=quat, symmetry=None), CLICK) == (False, "tilted")
    with_palm = replace(traces, object_quat=quat, palm_quat=quat, palm_pos=traces.object_pos)
    assert shown(replace(with_palm, symmetry=None), CLICK) == (True, None)


def test_a_worked_object_is_held_for_a_second_afterwards():
    traces = hinged(0, 1.2)
    press = traces.press.copy()
    press[:ACTION] = 0.0
    press[ACTION + 99 :] = 0.0
    assert judge(pressing(traces, press), CLICK).hold_s == pytest.approx(0.98)
    assert shown(pressing(traces, press), CLICK) == (False, "slipped")
    press[: ACTION + 100] = traces.press[: ACTION + 100]
    press[:ACTION] = 0.0
    assert judge(pressing(traces, press), CLICK).reason != "slipped"


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize(("degrees", "reason"), [(13.0, None), (15.0, "astray")])
def test_what_is_slid_stays_beside_its_way_by_at_most_15_mm(sign, degrees, reason):
    """A straight way of 62 mm is then 14 or 16 mm beside."""
    outcome = judge(moved(SLIDE, 0.062, off_deg=sign * degrees), SLIDE)
    assert outcome.reason == reason
    assert outcome.done >= 1.0
    assert reason is None or f"{degrees:.0f} deg" in outcome.detail


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize(("degrees", "reason"), [(19.9, None), (20.1, "astray"), (180, "astray")])
def test_what_is_slid_goes_where_it_is_asked_to_go_within_20_deg(sign, degrees, reason):
    """Over a way so short that it is never far beside."""
    short = ruled(SLIDE, distance=0.04)
    assert judge(moved(SLIDE, 0.041, off_deg=sign * degrees), short).reason == reason


def test_what_leaves_its_way_in_between_went_astray():
    traces = moved(SLIDE, 0.08)
    arc = np.sin(np.pi * acting(traces))[:, None] * asked(SLIDE, 90.0)

    def bowed(metres: float) -> GraspTraces:
        pos = traces.object_pos + metres * arc
        return replace(traces, object_pos=pos, palm_pos=traces.palm_pos + metres * arc)

    assert judge(bowed(0.0149), SLIDE).success
    assert judge(bowed(0.0151), SLIDE).reason == "astray"
    assert judge(bowed(-0.0151), SLIDE).reason == "astray"


def test_too_short_a_way_astray_is_too_short():
    assert judge(moved(SLIDE, 0.05, off_deg=90.0), SLIDE).reason == "slipped"
    assert judge(drawn(WRITE, 0.045, off_deg=90.0), WRITE).reason == "slipped"


def test_what_moves_in_the_hold_was_not_slid_in_the_action():
    traces = moved(SLIDE, 0.05)
    more = np.outer(np.clip((traces.time - 2.0) / 0.5, 0, 1), 0.03 * asked(SLIDE))
    both = replace(traces, object_pos=traces.object_pos + more, palm_pos=traces.palm_pos + more)
    assert judge(both, SLIDE).done == pytest.approx(0.05 / 0.06)


@pytest.mark.parametrize(("degrees", "reason"), [(14.0, None), (17.0, "astray"), (90, "astray")])
def test_lines_are_drawn_where_they_are_asked_for(degrees, reason):
    """55 mm are then 13 or 16 mm beside it."""
    outcome = judge(drawn(WRITE, 0.055, off_deg=degrees), WRITE)
    assert outcome.reason == reason
    assert reason is None or "beside the way" in outcome.detail


def test_of_several_lines_the_longest_is_looked_at():
    traces = drawn(WRITE, 0.11)
    assert traces.front_pos is not None
    front = traces.front_pos.copy()
    first = int(np.searchsorted(front @ asked(WRITE), 0.030))
    front[first : first + 2, 2] = 0.02  # 3 cm, and then 8
    assert judge(replace(traces, front_pos=front), WRITE).success
    askew = front.copy()
    askew[: first + 1, :2] = askew[: first + 1, :2] @ [[0, 1], [-1, 0]]  # the short one
    assert judge(replace(traces, front_pos=askew), WRITE).success


def test_lines_of_a_left_hand_go_the_other_way():
    left = WRITE.for_side("left")
    assert judge(drawn(left, 0.055), left).success
    assert judge(drawn(WRITE, 0.055), left).reason == "astray"


@pytest.mark.parametrize(
    ("force", "reason", "done"), [(0.2, None, 1.0), (0.199, "astray", 0.995), (0.0, "astray", 0.0)]
)
def test_a_button_is_pressed_by_the_finger_that_the_task_names(force, reason, done):
    """With the weight of 20 g at least, when the hinge passes its angle: here at sample 125."""
    traces = hinged(0, 1.2)
    row = int((np.rad2deg(traces.hinge) >= 1.0).argmax())
    pressed = replace(traces, pressed=at(row, force)[:, None])
    outcome = judge(pressed, CLICK)
    assert (outcome.reason, outcome.done) == (reason, pytest.approx(done))
    assert reason is None or outcome.detail == "left_button moved, but no index pressed left_button"
    late = replace(traces, pressed=at(slice(row + 1, None), 5.0)[:, None])
    assert judge(late, CLICK).reason == "astray"


def test_scissors_are_pressed_in_both_loops():
    traces = hinged(30, 8, n_pressed=2)
    assert judge(traces, SCISSORS).success
    for column, words in ((0, "no thumb pressed blade"), (1, "no index or middle pressed object")):
        pressed = traces.pressed.copy()
        pressed[:, column] = 0.1
        outcome = judge(replace(traces, pressed=pressed), SCISSORS)
        assert outcome.reason == "astray"
        assert words in outcome.detail


def test_a_hinge_that_never_passed_was_missed_whatever_pressed():
    traces = hinged(0, 0.9)
    assert judge(replace(traces, pressed=0 * traces.pressed), CLICK).reason == "missed"


def test_the_action_comes_before_the_rules_of_every_grasp():
    """And slip before both: a grasp that let go is not told that it leaned."""
    leaning = replace(carried(), table_force=np.full(520, 99.0))
    assert judge(leaning, MOVE).reason == "leaned"
    assert judge(replace(leaning, object_pos=slipped(0.03, 250, 600).object_pos), MOVE).reason == (
        "slipped"
    )
    half = replace(together(20, (0, 0, 1)), table_force=np.full(520, 99.0))
    assert judge(half, SPIN).detail == "it was turned by 20 deg of 45 deg"


def test_an_outcome_says_what_every_grasp_is_judged_by():
    traces = carried()
    press = traces.press.copy()
    press[HOLD:, 0, 1], press[HOLD + 160 :, 0, 1] = 2.0, 4.0
    table = at(slice(50, 70), 8.0)
    given = replace(pressing(traces, press), table_force=table, need=1.5, strain=0.7)
    outcome = judge(given, MOVE)
    assert outcome.success
    assert tuple(outcome.forces_n) == CONTACT_PARTS
    assert list(outcome.forces_n.values()) == pytest.approx([3.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    assert (outcome.need_n, outcome.margin) == (1.5, pytest.approx(2.0))
    assert (outcome.table_force_n, outcome.strain) == (pytest.approx(8.0), 0.7)
    assert (outcome.pushed_m, outcome.pushed_deg, outcome.opposed) == (0.0, 0.0, 1.0)


def test_what_a_run_without_a_hold_says():
    """One that was ended before: there is nothing to take means of."""
    traces = carried(hold=0.1)
    brief = replace(traces, hold_start=traces.time[-1] + 0.5)
    outcome = judge(brief, MOVE)
    assert not outcome.success
    assert set(outcome.forces_n.values()) == {0.0}
    assert outcome.margin == 0.0
    assert outcome.opposed == 1.0


def test_height_is_asked_for_even_where_no_time_is():
    dragged = drawn(WRITE, 0.055, lift=0.04)
    assert judge(dragged, ruled(WRITE, hold=0.0)).reason == "slipped"
    assert judge(drawn(WRITE, 0.055), ruled(WRITE, hold=0.0)).success
    assert judge(moved(SLIDE, 0.08, up=0.02), ruled(SLIDE, hold=0.0)).reason == "slipped"
    assert judge(moved(SLIDE, 0.08), ruled(SLIDE, hold=0.0)).success


def test_the_way_asked_for_is_the_longest_along_the_table():
    """What is done before and afterwards is no line."""
    aside = Step(0.5, shift=(0.02, 0.02, 0.1))
    for steps in ((aside, *WRITE.steps), (*WRITE.steps, aside)):
        assert judge(drawn(WRITE, 0.055), replace(WRITE, steps=steps)).success


def test_an_outcome_tells_the_deepest_overlap():
    outcome = judge(replace(carried(), penetration=at(260, 0.0019)), MOVE)
    assert outcome.success
    assert outcome.penetration_m == 0.0019

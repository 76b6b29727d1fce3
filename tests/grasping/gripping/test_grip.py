"""The grip layer by itself: what it commands, for forces that are made up."""

import numpy as np
import pytest

from handsim.grasping.gripping import grip as grip_module
from handsim.grasping.gripping.grip import (
    BEYOND,
    FOLLOWS,
    GRIP,
    IDLE,
    LIGHT,
    MOST,
    SEEKING,
    SETTLING,
    SLIDES,
    SLIP_DOUBLES,
    SMOOTHING,
    SOUGHT,
    SURPRISE,
    TOUCH,
    GripLayer,
    shares_of,
)
from handsim.grasping.gripping.squeeze import squeeze_offset
from handsim.hand.strength import FINGERTIP_FORCE, SATURATION
from handsim.joints import FINGERS, JOINT_INDEX, JOINTS

DT = 0.01
PER_RADIAN = FINGERTIP_FORCE / SATURATION
"""What fingers press in these tests, of as much as they go beyond where they touched [N/rad]."""
GRASPING = ("index", "middle")
CLOSING = squeeze_offset(1.0, GRASPING)
OF = np.array([-1 if j.finger is None else FINGERS.index(j.finger) for j in JOINTS])
AT = np.full(22, 0.3)
NONE = np.zeros((1, 5))
THUMB, INDEX, RING = (FINGERS.index(name) for name in ("thumb", "index", "ring"))


def layer(grip: float | tuple[float, ...] = 4.0, flexed=()) -> GripLayer:
    return GripLayer(
        CLOSING,
        shares_of(GRASPING),
        np.array([finger in flexed for finger in FINGERS]),
        np.atleast_1d(np.array(grip)),
    )


def given(
    each: GripLayer, forces, *, told=AT, q=AT, slip=None, load=None, closed=0.0, acting=False
):
    forces = np.atleast_2d(forces)
    n = len(forces)
    felt = [None if v is None else np.broadcast_to(v, (n,)).tolist() for v in (slip, load)]
    if each.feel(forces.tolist()):
        each.touch(np.broadcast_to(q, (n, 22)))
    told = np.broadcast_to(told, (n, 22))
    return np.array(each.command(told, *felt, closed, DT, acting=acting))


def pressing(each: GripLayer, n: int, fingers=(0, 1, 2), stiffness=1.0, **values) -> np.ndarray:
    """Command n times fingers that touch something stiff; return their last forces (5,) [N]."""
    forces = np.zeros(5)
    forces[list(fingers)] = 0.5
    for _ in range(n):
        given(each, forces, **values)
        forces = np.where(each.touched[0], stiffness * PER_RADIAN * each.press[0], 0.0)
    return forces


def test_thumb_and_opposing_fingers_share_the_grip():
    assert shares_of(("index", "middle")).tolist() == [1.0, 0.5, 0.5, 0.0, 0.0]
    assert shares_of(FINGERS).tolist() == [1.0, 0.25, 0.25, 0.25, 0.25]
    assert shares_of(("thumb", "little")).tolist() == [1.0, 0.0, 0.0, 0.0, 1.0]
    assert shares_of(()).tolist() == [1.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("closed", [0.0, 0.4])
def test_fingers_that_touch_nothing_go_where_they_are_told(closed):
    told = np.linspace(0.1, 0.5, 22)
    q = given(layer(), NONE, told=told, q=told - 0.2, closed=closed)
    np.testing.assert_allclose(q[0], told + closed * CLOSING, rtol=0, atol=1e-15)


def test_forces_before_the_hand_has_closed_are_those_of_a_touch():
    assert (LIGHT, IDLE) == (1.0, 0.5)


def test_the_wrist_is_no_part_of_a_thumb_that_touches():
    each = layer()
    forces = np.zeros(5)
    forces[THUMB] = 1.0
    q = given(each, forces, told=AT + 0.5)[0]
    np.testing.assert_array_equal(q[OF == -1], (AT + 0.5)[OF == -1])
    assert np.abs(q[OF == THUMB] - 0.3).max() < 0.1


def test_a_finger_stays_where_it_touched():
    """Above 0.3 N, whatever it is told afterwards; the other fingers and the wrist go on."""
    assert TOUCH == 0.3
    each = layer()
    forces = np.zeros(5)
    forces[INDEX] = TOUCH
    given(each, forces)
    assert not each.touched.any()
    forces[INDEX] = 0.31
    given(each, forces)
    assert np.flatnonzero(each.touched[0]).tolist() == [INDEX]
    for _ in range(3):
        q = given(each, NONE, told=AT + 1.0, q=AT + 0.05)[0]
    of_index = OF == INDEX
    np.testing.assert_array_equal(q[~of_index], (AT + 1.0)[~of_index])
    np.testing.assert_array_equal(each.at[0, of_index], 0.3)
    assert np.abs(q[of_index] - 0.3).max() < 0.1


def test_a_finger_presses_along_the_way_that_it_was_going():
    """As far as its press says at the joint that has the longest way, all others in proportion."""
    each = layer()
    forces = np.zeros(5)
    forces[INDEX] = 1.0
    way = np.zeros(22)
    way[[JOINT_INDEX["index_mcp"], JOINT_INDEX["index_pip"]]] = 0.4, -0.2
    q = given(each, forces, told=AT + way - CLOSING)[0]
    step = DT / (SETTLING * PER_RADIAN) * (0.5 * LIGHT - SMOOTHING * 1.0)
    assert each.press[0, INDEX] == pytest.approx(step)
    moved = (q - AT)[OF == INDEX]
    expected = step / 0.4 * way[OF == INDEX]
    np.testing.assert_allclose(moved, expected, rtol=1e-9, atol=1e-15)


def test_a_way_that_is_no_way_moves_nothing_much():
    """Told to stay where it is, a finger does not go to its end to press."""
    each = layer()
    pressing(each, 200, told=AT - CLOSING, closed=1.0, stiffness=0.0)
    q = given(each, NONE, told=AT - CLOSING + 1e-6, closed=1.0)[0]
    assert np.abs(q - AT)[OF == INDEX].max() < 1e-4


@pytest.mark.parametrize("grip", [1.0, 4.0, 12.0])
def test_forces_settle_to_their_shares_of_the_grip(grip):
    forces = pressing(layer(grip), 60, closed=1.0)
    np.testing.assert_allclose(forces, [grip, grip / 2, grip / 2, 0, 0], rtol=0.01)


@pytest.mark.parametrize("stiffness", [0.5, 2.0])
def test_forces_settle_on_what_is_softer_or_stiffer(stiffness):
    forces = pressing(layer(), 120, closed=1.0, stiffness=stiffness)
    np.testing.assert_allclose(forces[:3], [4.0, 2.0, 2.0], rtol=0.02)


def test_a_force_has_most_of_its_share_after_a_tenth_of_a_second():
    each = layer()
    forces = [pressing(layer(), n, closed=1.0)[THUMB] for n in (1, 4, 10, 15)]
    assert forces == sorted(forces)
    assert forces[0] < 1.0
    assert 4.0 * 0.4 < forces[1] < 4.0 * 0.8
    assert 4.0 * 0.85 < forces[2] < 4.0 * 1.15
    assert each.force.shape == (1, 5)


def test_fingers_touch_lightly_until_the_hand_has_closed():
    for closed, thumb in ((0.0, LIGHT), (1 / 3, LIGHT + 0.5 * (4 - LIGHT)), (0.7, 4.0)):
        forces = pressing(layer(), 80, closed=closed)
        assert forces[THUMB] == pytest.approx(thumb, rel=0.01)


def test_what_yields_easily_is_touched_no_harder_than_it_is_gripped():
    """Scissors are gripped with less than fingers touch other things with."""
    grip = 0.4
    assert grip < IDLE < LIGHT
    for closed in (0.0, 1.0):
        forces = pressing(layer(grip), 120, fingers=(0, 1, RING), closed=closed)
        assert forces[THUMB] == pytest.approx(grip, rel=0.01)
        assert forces[RING] == pytest.approx(grip, rel=0.02)


def test_fingers_that_the_grasp_does_not_use_hardly_press():
    forces = pressing(layer(12.0), 80, fingers=(0, 1, RING), closed=1.0)
    assert forces[RING] == pytest.approx(IDLE, rel=0.02)


def test_a_finger_that_met_nothing_seeks_on_and_gives_up():
    each = layer()
    q = [given(each, NONE, closed=1.0)[0] for _ in range(70)]
    for i, row in enumerate(q):
        sought = min((i + 1) * SEEKING * DT, SOUGHT)
        np.testing.assert_allclose(row, AT + (1.0 + sought) * CLOSING, atol=1e-12)
    assert SOUGHT == 2.0
    np.testing.assert_array_equal(q[-1], q[-2])
    each = layer()
    for _ in range(70):
        q = given(each, NONE, closed=0.99)
    np.testing.assert_allclose(q[0], AT + 0.99 * CLOSING)


def carrying(each: GripLayer, n: int, load: float = 1.0, slip: float = 0.0) -> np.ndarray:
    """Command a closed grip n times in the action; return what it presses (3,) [N]."""
    for _ in range(n):
        given(each, PER_RADIAN * each.press, closed=1.0, slip=slip, load=load, acting=True)
    return PER_RADIAN * each.press[0, :3]


def test_what_weighs_what_it_was_to_weigh_is_held_as_before():
    """Up to 15 % more: the same bits as where no load is felt."""
    assert SURPRISE == 1.15
    generator = np.random.default_rng(0)
    felt = [(None, None), (0.0, 1.0), (0.0, 0.3), (SLIDES, SURPRISE)]
    layers = [layer() for _ in felt]
    for _ in range(60):
        forces = generator.uniform(0.2, 6.0, 5)
        first, *others = [
            given(each, forces, closed=1.0, slip=slip, load=load, acting=True)
            for each, (slip, load) in zip(layers, felt, strict=True)
        ]
        for targets in others:
            np.testing.assert_array_equal(targets, first)


@pytest.mark.parametrize(
    ("load", "factor"), [(1.15, 1.0), (1.725, 1.5), (2.0, 2 / 1.15), (3.45, 3.0), (9.0, 3.0)]
)
def test_what_weighs_more_is_gripped_harder_by_all_and_no_less_when_put_down(load, factor):
    """As the load beyond 1.15 of what was to be carried, three times at most."""
    assert MOST == 3.0
    each = layer()
    pressing(each, 80, closed=1.0)
    # The thumb takes part while the load grows.
    for part in np.linspace(1.0, load, 60):
        carrying(each, 1, part)
    for now in (load, 1.0, 0.0):
        forces = carrying(each, 60, now)
        np.testing.assert_allclose(forces[1:], factor * np.array([2.0, 2.0]), rtol=0.01)
        assert forces[0] == pytest.approx(factor * 4.0, rel=0.06)


@pytest.mark.parametrize(
    ("slip", "seconds", "factor"),
    [(0.02, 1.0, 1.0), (0.03, 1.0, 1.0), (0.06, 0.1, 2.0), (0.06, 0.15, 2.5), (0.045, 0.1, 1.5),
     (0.06, 1.0, 3.0)],
)  # fmt: skip
def test_what_slides_is_gripped_harder_by_all(slip, seconds, factor):
    """By as much again for 3 mm that it slides beyond 3 cm/s, and no less when it has stopped."""
    assert (SLIDES, SLIP_DOUBLES) == (0.03, 0.003)
    each = layer()
    pressing(each, 80, closed=1.0)
    carrying(each, round(seconds / DT), slip=slip)
    forces = carrying(each, 60)
    np.testing.assert_allclose(forces, factor * np.array([4.0, 2.0, 2.0]), rtol=0.02)


def test_what_slides_though_it_is_gripped_for_its_load_is_gripped_harder_still():
    """From 1.5 times on, by a twentieth at each of ten further readings."""
    each = layer()
    pressing(each, 80, closed=1.0)
    carrying(each, 11, load=1.725, slip=0.045)
    np.testing.assert_allclose(carrying(each, 60), [8.0, 4.0, 4.0], rtol=0.01)


def test_the_load_and_the_sliding_of_each_run_are_its_own():
    each = layer((4.0, 4.0, 4.0))
    for _ in range(80):
        given(each, np.maximum(PER_RADIAN * each.press, 0.5), closed=1.0)
    for _ in range(20):
        given(
            each, PER_RADIAN * each.press, closed=1.0, acting=True,
            slip=np.array([0.0, 0.0, 0.045]), load=np.array([1.0, 1.725, 1.0]),
        )  # fmt: skip
    for _ in range(60):
        given(each, PER_RADIAN * each.press, closed=1.0, slip=0.0, load=1.0, acting=True)
    forces = PER_RADIAN * each.press[:, INDEX]
    np.testing.assert_allclose(forces, [2.0, 3.0, 4.0], rtol=0.02)


def test_what_touches_nothing_does_not_tighten_though_others_hold():
    """What slides past an open hand, or rests on its palm, is not gripped yet."""
    together, alone = layer((4.0, 4.0)), layer()
    for tick in range(60):
        forces = np.array([[2.0] * 5, [2.0 if tick > 20 else 0.0] * 5])
        felt, open_ = {"closed": 1.0, "acting": True}, tick < 20
        slip, load = (0.05, 2.0) if open_ else (0.0, 1.0)
        both = given(together, forces, slip=slip, load=load, **felt)
        one = given(alone, forces[1], slip=0.0, load=1.0, **felt)
        np.testing.assert_array_equal(both[1], one[0])
    assert together._runs[0]._tighter > 1.5


def test_in_the_action_the_thumb_supports_what_fingers_press():
    """Its own force is corrected before, and not in the action, whatever is felt."""
    each = layer()
    pressing(each, 80, closed=1.0)
    before = each.press.copy()
    for forces in (9.0, 0.0):
        given(each, np.full(5, forces), closed=1.0, acting=True)
        given(each, np.full(5, forces), closed=1.0, slip=SLIDES, load=SURPRISE, acting=True)
        assert each.press[0, THUMB] == before[0, THUMB]
        assert each.press[0, INDEX] < before[0, INDEX]


@pytest.mark.parametrize("felt", [{"load": 1.4, "slip": 0.0}, {"load": 1.0, "slip": 0.033}])
def test_the_thumb_takes_part_for_a_moment_when_the_grip_has_tightened(felt):
    """For 0.15 s, 15 readings; then it holds still."""
    assert FOLLOWS == 0.15
    each = layer()
    pressing(each, 80, closed=1.0)
    for _ in range(2):  # as often as it tightens
        thumb = [each.press[0, THUMB]]
        for tick in range(40):
            now = felt if tick == 0 else {"load": 1.0, "slip": 0.0}
            given(each, np.zeros(5), closed=1.0, acting=True, **now)
            thumb.append(each.press[0, THUMB])
        moves = np.diff(thumb) > 0
        assert moves.tolist() == [True] * 15 + [False] * 25
        felt = {name: 1.2 * value for name, value in felt.items()}


def test_fingers_that_the_action_flexes_press_as_far_as_it_says():
    each = layer(flexed=("index",))
    forces = pressing(each, 80, closed=1.0)
    assert forces[INDEX] == pytest.approx(2.0, rel=0.02)  # held with a force before
    before = each.press.copy()
    for _ in range(5):
        given(each, np.zeros(5), closed=1.0, acting=True)
    assert each.press[0, INDEX] == before[0, INDEX]
    assert each.press[0, INDEX + 1] > before[0, INDEX + 1]


def test_fingers_go_no_farther_than_30_degrees_to_press():
    assert np.rad2deg(BEYOND) == pytest.approx(30.0)
    each = layer(60.0)
    for _ in range(400):
        given(each, [0.5, 0.5, 0.0, 0.0, 0.0], closed=1.0)
    assert each.press[0].tolist() == [BEYOND, BEYOND, 0, 0, 0]
    for _ in range(400):
        given(each, [500.0, 500.0, 0.0, 0.0, 0.0], closed=1.0)
    assert each.press[0].tolist() == [-BEYOND, -BEYOND, 0, 0, 0]


def test_runs_together_get_the_bits_of_each_alone():
    generator = np.random.default_rng(0)
    grips = (2.0, 4.0, 9.0)
    together, alone = layer(grips), [layer(grip) for grip in grips]
    for tick in range(60):
        told, q = generator.uniform(0, 1, (2, 3, 22))
        forces = generator.uniform(0, 8, (3, 5)) * (generator.uniform(size=(3, 5)) < 0.1 * tick)
        closed, acting = min(tick / 30, 1.0), tick > 40
        slip = generator.uniform(0, 0.05, 3) if acting else None
        load = generator.uniform(0.5, 1.5, 3) if acting else None
        named = {"closed": closed, "acting": acting}
        all_targets = given(together, forces, told=told, q=q, slip=slip, load=load, **named)
        for i, each in enumerate(alone):
            felt = [None if v is None else v[i] for v in (slip, load)]
            rows = {"told": told[i], "q": q[i], "slip": felt[0], "load": felt[1]}
            targets = given(each, forces[i], **rows, **named)
            np.testing.assert_array_equal(all_targets[[i]], targets)
    assert together.touched.all()
    assert not np.array_equal(all_targets[0], all_targets[1])


def test_whatever_the_layer_is_made_of_is_told_to_plans():
    numbers = ("TOUCH", "LIGHT", "IDLE", "SMOOTHING", "SETTLING", "BEYOND", "SEEKING", "SOUGHT",
               "SHORT", "SURPRISE", "SLIDES", "SLIP_DOUBLES", "MOST", "FOLLOWS")  # fmt: skip
    assert tuple(getattr(grip_module, name) for name in numbers) == GRIP

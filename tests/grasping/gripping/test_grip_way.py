"""What the grip layer keeps from one reading to the next gives the bits of what is made anew."""

from itertools import pairwise

import numpy as np
import pytest

from handsim.grasping.gripping.grip import TOUCH, GripLayer

from .test_grip import AT, CLOSING, DT, INDEX, NONE, RING, THUMB, layer


def commanded(each: GripLayer, told: np.ndarray, forces: np.ndarray, q: np.ndarray, tick: int):
    """The targets of a reading, at which the hand closes and, from the tenth on, acts."""
    if each.feel(forces.tolist()):
        each.touch(q)
    felt = ([0.04] * len(told), [1.3] * len(told)) if tick >= 10 else (None, None)
    return np.array(each.command(told, *felt, min(tick / 8, 1.0), DT, acting=tick >= 10))


def test_the_same_array_again_gives_the_bits_of_a_copy():
    """While fingers touch one by one, also after a target of other values was told in between."""
    generator = np.random.default_rng(0)
    same, copies, forgetful = (layer((2.0, 7.0)) for _ in range(3))
    told, other = generator.uniform(0.2, 1.0, (2, 2, 22))
    begins = np.array([[3, 5, 5, 9, 14], [4, 5, 12, 30, 30]])
    moved = []
    for tick in range(25):
        forces = generator.uniform(0.4, 5.0, (2, 5)) * (tick >= begins)
        q = generator.uniform(0.0, 1.0, (2, 22))
        now = other if tick in (7, 18) else told
        kept = commanded(same, now, forces, q, tick)
        made_anew = commanded(copies, now.copy(), forces, q, tick)
        np.testing.assert_array_equal(kept, made_anew)
        forgetful._told = None
        np.testing.assert_array_equal(kept, commanded(forgetful, now, forces, q, tick))
        moved.append(kept)
    assert same.touched.tolist() == [[True] * 5, [True, True, True, False, False]]
    np.testing.assert_array_equal(same.at, copies.at)
    assert all((a != b).any() for a, b in pairwise(moved[3:]))


def test_a_finger_that_touches_while_the_target_stays_begins_its_way_there():
    each, told = layer(), np.full((1, 22), 0.8)
    forces = np.where(np.arange(5) == INDEX, 1.0, 0.0)[None]
    commanded(each, told, forces, AT[None], 0)
    commanded(each, told, forces, AT[None], 1)
    forces[0, THUMB] = 1.0
    at = np.full((1, 22), 0.5)
    targets = commanded(each, told, forces, at, 2)
    way = told + CLOSING - each.at
    of_thumb = each.at[0] == 0.5
    assert of_thumb.sum() == 4
    longest = np.abs(way[0, of_thumb]).max()
    expected = 0.5 + each.press[0, THUMB] / longest * way[0, of_thumb]
    np.testing.assert_allclose(targets[0, of_thumb], expected, rtol=1e-14)


def test_whether_a_finger_has_touched_now_is_told_once():
    """In any of the runs, and only where its force is above that of a touch."""
    each = layer((4.0, 4.0))
    forces = np.zeros((2, 5))
    assert not each.feel(forces.tolist())
    forces[1, RING] = TOUCH
    assert not each.feel(forces.tolist())
    forces[1, RING] = np.nextafter(TOUCH, 1.0)
    assert each.feel(forces.tolist())
    each.touch(np.tile(AT, (2, 1)))
    assert np.argwhere(each.touched).tolist() == [[1, RING]]
    assert not each.feel(forces.tolist())
    assert not each.feel(np.zeros((2, 5)).tolist())
    assert not each.feel(forces.tolist())  # it has touched before
    forces[0, RING] = 1.0
    assert each.feel(forces.tolist())


def test_forces_are_running_means_of_all_that_is_felt():
    each, expected = layer(), 0.0
    for tick in range(6):
        each.feel(NONE + tick)
        expected += 0.4 * (tick - expected)
    np.testing.assert_allclose(each.force, np.full((1, 5), expected), rtol=1e-12)


@pytest.mark.parametrize("forces", [[[0.0] * 5], [[0.0] * 5] * 3])
def test_what_is_felt_is_felt_by_each_run(forces):
    with pytest.raises(ValueError, match="zip"):
        layer((4.0, 4.0)).feel(forces)

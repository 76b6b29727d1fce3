"""Short gaps are bridged, long ones left."""

import numpy as np
import pytest

from handsim.recordings.gaps import bridge

TIME = np.arange(40) / 100


def with_gap(first: int, n: int) -> np.ndarray:
    values = np.column_stack([TIME**2, 1 - TIME])
    values[first : first + n, 1] = np.nan
    return values


def test_a_short_gap_is_bridged_between_its_neighbours() -> None:
    filled, bridged = bridge(TIME, with_gap(10, 4), 0.05)
    np.testing.assert_allclose(filled[:, 1], 1 - TIME, atol=1e-12)
    assert bridged.sum() == 4 and bridged[10:14, 1].all()
    np.testing.assert_array_equal(filled[:, 0], TIME**2)


@pytest.mark.parametrize(("longest", "left"), [(0.049, 4), (0.05, 0)])
def test_the_limit_counts_from_value_to_value(longest: float, left: int) -> None:
    assert np.isnan(bridge(TIME, with_gap(10, 4), longest)[0]).sum() == left


def test_ends_take_the_nearest_value_if_it_is_near() -> None:
    filled, _ = bridge(TIME, with_gap(0, 3), 0.03)
    np.testing.assert_allclose(filled[:3, 1], 1 - TIME[3])
    assert np.isnan(bridge(TIME, with_gap(0, 3), 0.02)[0]).sum() == 3
    filled, _ = bridge(TIME, with_gap(37, 3), 0.03)
    np.testing.assert_allclose(filled[37:, 1], 1 - TIME[36])
    assert np.isnan(bridge(TIME, with_gap(37, 3), 0.02)[0]).sum() == 3


def test_nothing_leaves_what_lies_between_the_neighbours() -> None:
    steep = np.where(TIME < 0.2, 0.0, 1.0)[:, None]
    steep[15:25] = np.nan
    filled, _ = bridge(TIME, steep, 1.0)
    assert (filled >= 0).all() and (filled <= 1).all()


def test_a_column_without_values_stays_empty() -> None:
    filled, bridged = bridge(TIME, np.full((40, 1), np.nan), 1.0)
    assert np.isnan(filled).all() and not bridged.any()


def test_two_values_are_enough_for_a_straight_line() -> None:
    values = np.full((40, 1), np.nan)
    values[[0, -1], 0] = 0.0, 1.0
    np.testing.assert_allclose(bridge(TIME, values, 1.0)[0][:, 0], TIME / TIME[-1], atol=1e-12)


def test_a_step_beside_a_gap_does_not_swing_into_it() -> None:
    step = np.where(np.arange(40) < 21, 0.0, 1.0)[:, None]
    step[22:27] = np.nan
    np.testing.assert_allclose(bridge(TIME, step, 1.0)[0][21:], 1.0, atol=1e-12)

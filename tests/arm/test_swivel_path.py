import numpy as np
import pytest

from handsim.arm._swivel_path import smooth_swivel

SWIVELS = np.deg2rad(np.arange(0.0, 61.0, 4.0))
ROWS = np.linspace(0, 180, 10).astype(np.int64)


def wanted(degrees: np.ndarray) -> np.ndarray:
    """Costs that are least at an angle for each knot, steep enough to overrule its neighbours."""
    return (50.0 * (SWIVELS - np.deg2rad(degrees)[:, None])) ** 2


def test_between_the_angles_of_the_grid_a_parabola_finds_the_least() -> None:
    found = smooth_swivel(wanted(np.full(10, 21.3)), SWIVELS, ROWS, 181)
    assert np.rad2deg(found) == pytest.approx(np.full(181, 21.3), abs=0.05)


def test_what_jumps_from_knot_to_knot_is_evened_out() -> None:
    zigzag = np.where(np.arange(10) % 2, 28.0, 24.0)
    found = np.rad2deg(smooth_swivel(wanted(zigzag), SWIVELS, ROWS, 181))[30:150]
    assert found == pytest.approx(np.full(120, 26.0), abs=0.2)


def test_a_bend_has_no_kink_and_overshoots_nothing() -> None:
    bend = np.where(np.arange(10) < 5, 10.0, 10.0 + 6.0 * (np.arange(10) - 4))
    found = np.rad2deg(smooth_swivel(wanted(bend), SWIVELS, ROWS, 181))
    assert (np.diff(found) > -1e-9).all()
    assert np.abs(np.diff(found, 2)).max() < 0.04  # with kinks 0.07


def test_a_dip_that_costs_more_to_go_to_is_passed_by() -> None:
    """At 8 deg it is 0.5 or 4 less than at 40; there and back costs 1.3."""
    cost = 0.01 * wanted(np.full(10, 40.0))
    there = np.abs(SWIVELS - np.deg2rad(8.0)) < 1e-9
    for less, taken in ((0.5, False), (4.0, True)):
        dip = cost.copy()
        dip[5, there] = -less
        assert (np.rad2deg(smooth_swivel(dip, SWIVELS, ROWS, 181)).min() < 30) == taken


def test_one_time_has_one_swivel() -> None:
    found = smooth_swivel(wanted(np.array([30.0])), SWIVELS, np.array([0]), 1)
    assert np.rad2deg(found) == pytest.approx([30.0], abs=0.05)

"""Smooth curves through points."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from handsim.learning.guide.curve import Curve

RNG = np.random.default_rng(3)
POINTS = np.cumsum(RNG.normal(size=(12, 3)), axis=0)
CURVE = Curve(POINTS)


def test_it_is_the_uniform_cubic_b_spline_of_its_points_and_their_mirror_images() -> None:
    s = np.linspace(0.0, 1.0, 200)
    ends = [2 * POINTS[0] - POINTS[1], *POINTS, 2 * POINTS[-1] - POINTS[-2]]
    spline = BSpline(np.arange(-3, 15) / 11.0, np.array(ends), 3)
    np.testing.assert_allclose(CURVE.at(s), spline(s), atol=1e-12)
    np.testing.assert_allclose(CURVE.slope(s), spline(s, 1), atol=1e-10)
    np.testing.assert_allclose(CURVE.at(np.array([0.0, 1.0])), POINTS[[0, -1]], atol=1e-14)


def test_it_goes_straight_on_beyond_its_ends() -> None:
    s = np.array([-0.5, 1.25])
    ends = np.array([0.0, 1.0])
    beyond = CURVE.at(ends) + (s - ends)[:, None] * CURVE.slope(ends)
    np.testing.assert_allclose(CURVE.at(s), beyond, atol=1e-12)
    np.testing.assert_allclose(CURVE.slope(s), CURVE.slope(ends))


def test_centres_hold_where_the_straight_continuation_would_be_at_the_end() -> None:
    s = np.linspace(-1.0, 1.0, 4001)
    continued = CURVE.at(s) + (1 - s)[:, None] * CURVE.slope(s)
    centres = CURVE.centres()
    assert (continued <= centres.max(axis=0) + 1e-12).all()
    assert (continued >= centres.min(axis=0) - 1e-12).all()
    cell = Curve(POINTS[:2])  # one cubic: the ends are on the curve
    at_ends = cell.at(np.array([0.0, 1.0])) + np.array([[1.0], [0.0]]) * cell.slope(np.array([0.0]))
    np.testing.assert_allclose(cell.centres()[[0, 3]], at_ends, atol=1e-12)


def test_centres_are_the_coefficients_of_that_on_each_cell() -> None:
    """On a cell it is the sum of the four by Bernstein's polynomials."""
    u = np.linspace(0.0, 1.0, 9)
    weights = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3], axis=1)
    for cell, four in enumerate(CURVE.centres().reshape(4, CURVE.n_cells, 3).swapaxes(0, 1)):
        s = (cell + u) / CURVE.n_cells
        continued = CURVE.at(s) + (1 - s)[:, None] * CURVE.slope(s)
        np.testing.assert_allclose(weights @ four, continued, atol=1e-12)


def test_it_ends_at_its_points_to_the_bit() -> None:
    for points in (POINTS, POINTS[1:] / 3.0, POINTS[:2] / 7.0):
        np.testing.assert_array_equal(Curve(points).at(np.array([0.0, 1.0])), points[[0, -1]])


def test_points_that_rise_make_a_curve_that_rises() -> None:
    rising = Curve(np.array([0.0, 0.0, 0.7, 0.7, 1.0])[:, None])
    values = rising.at(np.linspace(0.0, 1.0, 500))[:, 0]
    assert (np.diff(values) >= -1e-15).all() and values[-1] == pytest.approx(1.0)


def test_single_parameters_give_what_many_give() -> None:
    for s in (0.0, 0.013, 0.5, 0.97, 1.0):
        point, slope = CURVE.jet(s)
        np.testing.assert_allclose(point, CURVE.at(np.array([s]))[0], atol=1e-13)
        np.testing.assert_allclose(slope, CURVE.slope(np.array([s]))[0], atol=1e-12)
    for beyond, end in ((-0.2, 0.0), (1.2, 1.0)):  # rounding, which is taken for the end
        np.testing.assert_array_equal(CURVE.jet(beyond), CURVE.jet(end))


def test_a_curve_of_one_number_gives_the_same_bits_as_one_of_vectors() -> None:
    rising = Curve(np.array([0.0, 0.1, 0.7, 0.8, 1.0])[:, None])
    for s in (-0.1, 0.0, 0.013, 0.5, 0.97, 1.0, 1.1):
        value, slope = rising.jet(s)
        assert (value[0], slope[0]) == rising.scalar_jet(s)

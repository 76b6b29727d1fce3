"""The penalty on second differences and its gradient."""

import numpy as np
import pytest

from handsim.learning.fit.smoothness import second_differences


def test_second_differences_vanish_on_planes_only() -> None:
    i, j = np.meshgrid(np.arange(5.0), np.arange(6.0), indexing="ij")
    value, slope = second_differences(2 + 3 * i - j)
    assert value == pytest.approx(0, abs=1e-9) and np.abs(slope).max() < 1e-9
    assert second_differences(i**2)[0] == pytest.approx(4 * 3 * 6)  # (2)^2 at 3 places in 6 rows
    assert second_differences(j**2)[0] == pytest.approx(4 * 4 * 5)


@pytest.mark.parametrize("shape", [(2,), (3, 2), (4, 5, 6), (3, 3, 4, 2)])
def test_value_and_slope_are_those_along_each_dimension(shape: tuple[int, ...]) -> None:
    c = np.random.default_rng(1).normal(size=shape)
    wanted, by_c = 0.0, np.zeros(shape)
    for axis in range(len(shape)):
        bend = np.diff(c, 2, axis=axis)
        wanted += np.sum(bend**2)
        matrix = np.diff(np.eye(shape[axis]), 2, axis=0)  # (m - 2, m)
        by_c += np.moveaxis(2 * np.moveaxis(bend, axis, -1) @ matrix, -1, axis)
    value, slope = second_differences(c)
    assert value == pytest.approx(wanted, rel=1e-13)
    np.testing.assert_allclose(slope, by_c, atol=1e-12)


@pytest.mark.parametrize("shape", [(9,), (5, 6), (4, 5, 6)])
def test_the_slope_of_second_differences_is_whole(shape: tuple[int, ...]) -> None:
    """Of a quadratic form c' S c the slope along c is twice its value."""
    rng = np.random.default_rng(0)
    c, other = rng.normal(size=shape), rng.normal(size=shape)
    value, slope = second_differences(c)
    assert np.sum(slope * c) == pytest.approx(2 * value)
    step = 1e-6
    ahead, behind = second_differences(c + step * other), second_differences(c - step * other)
    assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(np.sum(slope * other), rel=1e-7)

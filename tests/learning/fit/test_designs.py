"""Splines at fixed points as a linear function of the coefficients."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from handsim.learning.fit import designs
from handsim.learning.fit.designs import JetDesign
from handsim.navigation.bspline import TensorBasis, TensorBSpline

SHAPES = [(7,), (6, 8), (5, 7, 6), (4, 5, 4, 5), (4, 4, 4, 4, 5)]


def setting(shape: tuple[int, ...], n_points: int = 300):
    rng = np.random.default_rng(len(shape))
    n = len(shape)
    basis = TensorBasis.uniform(-np.ones(n), np.ones(n), shape)
    points = rng.uniform(-1.1, 1.1, (n_points, n))  # some outside: taken at the nearest point
    return rng, basis, points


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_jets_are_those_of_the_spline(shape: tuple[int, ...]) -> None:
    rng, basis, points = setting(shape)
    c = rng.normal(size=basis.n_coefficients)
    value, gradient, _ = TensorBSpline(basis, c).jets(points, 1)
    values, slopes = JetDesign(basis, points)(c)
    np.testing.assert_allclose(values, value, atol=1e-13)
    np.testing.assert_allclose(slopes.T, gradient, atol=1e-11)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_pulled_back_is_the_transpose(shape: tuple[int, ...]) -> None:
    rng, basis, points = setting(shape)
    design = JetDesign(basis, points)
    c = rng.normal(size=basis.n_coefficients)
    by_value, by_gradient = rng.normal(size=len(points)), rng.normal(size=(len(shape), len(points)))
    value, slopes = design(c)
    for a, b in ((by_value, by_gradient), (by_value, None), (None, by_gradient)):
        there = (0 if a is None else a @ value) + (0 if b is None else np.sum(b * slopes))
        assert design.pulled_back(a, b) @ c == pytest.approx(there, abs=1e-9)


def test_designs_share_room_and_keep_places_without_a_difference(monkeypatch) -> None:
    """Answers are their own: another design's, and a second call, do not overwrite them."""
    rng, basis, points = setting((5, 7, 6), 3000)
    one, other = JetDesign(basis, points), JetDesign(basis, points[::2] ** 3)
    c, by_gradient = rng.normal(size=basis.n_coefficients), rng.normal(size=(3, 3000))
    jets, back = one(c), one.pulled_back(None, by_gradient)
    kept = [each.copy() for each in (*jets, back)]
    other(2 * c)
    other.pulled_back(rng.normal(size=1500), by_gradient[:, ::2])
    one(-c)
    monkeypatch.setattr(designs, "_KEPT", 0)
    again = JetDesign(basis, points)
    for made in ((*jets, back), (*again(c), again.pulled_back(None, by_gradient))):
        for found, wanted in zip(made, kept, strict=True):
            np.testing.assert_array_equal(found, wanted)
    assert again._where is None


def test_threads_do_not_share_room() -> None:
    rng, basis, points = setting((5, 7, 6), 3000)
    designs_made = [JetDesign(basis, points + 0.01 * i) for i in range(4)]
    c = rng.normal(size=basis.n_coefficients)
    wanted = [design(c)[1] for design in designs_made]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            found = list(pool.map(lambda design: design(c)[1], designs_made))
            np.testing.assert_array_equal(found, wanted)


def test_some_points_and_many_points() -> None:
    rng, basis, points = setting((5, 7, 6), 5000)  # more than are worked on at once
    design = JetDesign(basis, points)
    c = rng.normal(size=basis.n_coefficients)
    which = np.array([4321, 7, 7, 0])
    values, slopes = design(c)
    some_values, some_slopes = design.taken(which)(c)
    np.testing.assert_array_equal(some_values, values[which])
    np.testing.assert_array_equal(some_slopes, slopes[:, which])
    one = np.zeros((3, 5000))
    one[:, which[:1]] = 1.0
    np.testing.assert_allclose(
        design.pulled_back(None, one), design.taken(which[:1]).pulled_back(None, np.ones((3, 1)))
    )
    nothing = design.taken(np.array([], dtype=int))
    assert not nothing.pulled_back(None, np.ones((3, 0))).any()

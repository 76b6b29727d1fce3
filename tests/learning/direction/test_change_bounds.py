"""How far the descent quantity can move, and that points passed over would not have counted."""

import numpy as np
import pytest

from handsim.learning.direction import descent as descent_module
from handsim.learning.direction.change_bounds import ChangeBounds
from handsim.learning.direction.descent import DescentCondition, box_corners
from handsim.learning.fit.designs import JetDesign
from handsim.navigation.bspline import TensorBasis


def setting(shape: tuple[int, ...], seed: int = 0):
    """A basis with unequal knots, points in it, and destinations about its middle."""
    rng = np.random.default_rng(seed)
    knots = tuple(np.cumsum(rng.uniform(0.2, 0.6, m + 4)) for m in shape)
    basis = TensorBasis(knots)
    low, high = basis.lower, basis.upper
    points = low + (high - low) * rng.random((400, len(shape)))
    goals = box_corners(low + (high - low) * rng.uniform(0.3, 0.7, (2, len(shape))))
    return rng, basis, points, goals


def quantities(basis: TensorBasis, points: np.ndarray, goals: np.ndarray, c: np.ndarray):
    """(z - z_goal) . grad chi, (m, N)."""
    slopes = JetDesign(basis, points)(c)[1].T
    return np.sum((points[None] - goals[:, None]) * slopes, axis=2)


@pytest.mark.parametrize("shape", [(9,), (7, 6), (5, 7, 6)])
def test_no_change_moves_the_quantity_farther_and_some_nearly_as_far(shape) -> None:
    rng, basis, points, goals = setting(shape)
    bounds = ChangeBounds(basis, JetDesign(basis, points), points, goals)
    nearest = 0.0
    for size in (1e-3, 1.0):
        for kind in range(2 * len(shape) + 2):
            change = size * rng.normal(size=shape)
            if kind < len(shape):  # a ramp: its slope is the same everywhere
                change = size * np.moveaxis(np.ones(shape), kind, -1) * np.arange(shape[kind])
                change = np.moveaxis(change, -1, kind)
            elif kind < 2 * len(shape):
                change[rng.random(shape) < 0.9] = 0.0
            moved = np.abs(quantities(basis, points, goals, change.ravel())).max(axis=0)
            most = bounds(change.ravel())
            assert (moved <= most * (1 + 1e-12)).all()
            nearest = max(nearest, float((moved / np.maximum(most, 1e-12)).max()))
    assert nearest > 0.8


def test_the_same_change_everywhere_moves_nothing() -> None:
    _, basis, points, goals = setting((5, 7, 6))
    bounds = ChangeBounds(basis, JetDesign(basis, points), points, goals)
    np.testing.assert_array_equal(bounds(np.full(basis.n_coefficients, 3.0)), 0.0)


def test_points_passed_over_would_not_have_counted(monkeypatch) -> None:
    """The penalty and its gradient are those of all points, to the bit, along a walk."""
    rng, basis, points, goals = setting((5, 7, 6))
    for limit in (0.2, 2.0):
        quick = DescentCondition(basis, goals, points, limit, 10.0)
        looked_at = []
        laid = quick._excess

        def counted(c, design, at, laid=laid, looked_at=looked_at):
            looked_at.append(design.n_points)
            return laid(c, design, at)

        monkeypatch.setattr(quick, "_excess", counted)
        c = rng.normal(size=basis.n_coefficients)
        c *= 1.2 * limit / quantities(basis, points, goals, c).max()  # a few are above
        walk, found = [], []
        for i in range(40):
            walk.append(c)
            found.append(quick(c))
            if i == 20:
                quick.tighten(c)
            c = c + 0.002 * limit * rng.normal(size=len(c))
        assert min(looked_at) < 0.25 * 400  # most are passed over
        monkeypatch.setattr(descent_module, "_FEW", -1.0)  # look at all
        whole = DescentCondition(basis, goals, points, limit, 10.0)
        for i, (c, (value, slope)) in enumerate(zip(walk, found, strict=True)):
            wanted, by_c = whole(c)
            assert value == wanted
            np.testing.assert_array_equal(slope, by_c)
            if i == 20:
                whole.tighten(c)
        assert any(value > 0 for value, _ in found)
        monkeypatch.undo()

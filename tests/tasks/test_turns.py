"""Turns one after the other, against SciPy's product."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.tasks.turns import composed

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(("outer", "inner"), [(5, 5), (5, 1), (1, 5)])
def test_turns_follow_each_other_as_in_a_product(outer, inner):
    a, b = (Rotation.from_quat(RNG.normal(size=(n, 4))) for n in (outer, inner))
    found = composed(a, b)
    np.testing.assert_allclose(found.as_quat(), (a * b).as_quat(), rtol=0, atol=1e-15)
    way = [0.3, -1.0, 2.0]
    np.testing.assert_allclose(found.apply(way), a.apply(b.apply(way)), atol=1e-14)


def test_one_turn_may_be_one_and_not_a_row_of_one():
    several, one = Rotation.from_quat(RNG.normal(size=(4, 4))), Rotation.from_euler("x", 0.4)
    for a, b in ((several, one), (one, several)):
        np.testing.assert_allclose(composed(a, b).as_quat(), (a * b).as_quat(), atol=1e-15)
    assert composed(one, one).as_quat().shape == (4,)


def test_turns_of_many_stay_turns():
    """Errors of rounding do not grow: quaternions keep their length."""
    turn = step = Rotation.from_euler("xyz", RNG.uniform(-1, 1, (20, 3)))
    for _ in range(300):
        turn = composed(step, turn)
    length = np.linalg.norm(turn.as_quat(), axis=1)
    np.testing.assert_allclose(length, 1.0, rtol=0, atol=4e-16)

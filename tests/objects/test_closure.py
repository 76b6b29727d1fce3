"""Force closure of proposals under uncertainty."""

import numpy as np
import pytest

from handsim.joints import FINGERS
from handsim.objects.closure import Disturbances, disturbances, firmness
from handsim.objects.convex_solid import ConvexSolid
from handsim.objects.grasp import Grasp

from .shapes import box

CENTRE = np.array([0.0, 0.0, 0.03])
SOLID = ConvexSolid.of_hulls([box(0.20, 0.04, 0.06, (0, 0, 0.03)).vertices])


def across(x: float = 0.0, n: int = 4, z: float = 0.03) -> Grasp:
    """From above across the short side of a block of 200 x 40 x 60 mm."""
    return Grasp("top", (x, 0.0, z), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), 0.04, FINGERS[1 : 1 + n])


def firm(grasp: Grasp, mass: float = 0.2, drawn: Disturbances | None = None) -> float:
    return float(firmness(SOLID, [grasp], CENTRE, mass, drawn or disturbances())[0])


def one(friction: float, shift: tuple = (0.0, 0.0, 0.0), turn: float = 0.0) -> Disturbances:
    return Disturbances(np.array([shift]), np.array([turn]), np.array([friction]), np.array([1.0]))


def test_a_block_is_held_at_its_middle_and_not_at_its_end_by_two_fingers() -> None:
    assert firm(across()) > 0.9
    assert firm(across(0.09, n=2), mass=0.6) < 0.3
    assert firm(across(0.05, n=2)) < firm(across(0.05, n=4))


def test_the_weight_that_friction_bears_is_that_of_statics() -> None:
    """Thumb and fingers press with N each: 2 mu N bears the weight and a push from above."""
    limit = 2 * 0.5 * (15.0 + 2 * 8.0) / 9.81 / 1.4
    # A pyramid of six edges reaches cos(30 deg) of the cone where it reaches least.
    assert firm(across(), 0.85 * limit, one(0.5)) > 0.0
    assert firm(across(), 1.03 * limit, one(0.5)) == 0.0


def test_a_finger_that_misses_bears_nothing() -> None:
    assert firm(across(), drawn=one(0.6)) > 0.9
    assert firm(across(), drawn=one(0.6, shift=(0.0, -0.035, 0.0))) == 0.0  # above the block
    beyond = across(0.135, n=2)  # one of two fingers on the block, and not the thumb
    assert firm(beyond, drawn=one(0.8)) == 0.0


def test_a_finger_does_not_reach_what_lies_deeper_than_it_gives_way() -> None:
    """Beyond the middle the block is 30 mm thinner on the fingers' side."""
    clouds = [box(0.10, 0.04, 0.06, (0, 0, 0.03)).vertices for _ in range(2)]
    clouds[0][:, 0] -= 0.05
    clouds[1][:, 0] += 0.05
    clouds[1][clouds[1][:, 1] > 0, 1] -= 0.03
    solid = ConvexSolid.of_hulls(clouds)
    held = [firmness(solid, [across(x, n=2)], CENTRE, 0.1, one(0.8))[0] for x in (-0.02, 0.02)]
    assert held[0] > 0.5 and held[1] == 0.0


def test_slippery_skin_does_not_hold_on_slanted_faces() -> None:
    wedge = box(0.10, 0.04, 0.06, (0, 0, 0.03)).vertices.copy()
    top = wedge[:, 2] > 0.03
    wedge[top, 1] *= 0.3  # sides at 25 deg to the upright, narrower above
    solid = ConvexSolid.of_hulls([wedge])
    grasp = Grasp("top", (0, 0, 0.03), (0, 1, 0), (0, 0, -1), 0.026, FINGERS[1:])
    held = [firmness(solid, [grasp], CENTRE, 0.1, one(mu))[0] for mu in (0.2, 0.8)]
    assert held[0] == 0.0 and held[1] > 0.5


def test_samples_are_the_same_for_the_same_seed_and_cover_the_range() -> None:
    one, other = disturbances(), disturbances()
    np.testing.assert_array_equal(one.shift, other.shift)
    assert (one.shift[0] == 0).all() and one.friction[0] == pytest.approx(0.55)
    assert one.friction[1:].min() < 0.4 and one.friction[1:].max() > 0.7
    assert (disturbances(seed=1).shift[1:] != one.shift[1:]).all()

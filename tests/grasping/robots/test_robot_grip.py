"""The squeeze of a robot hand on a spring, and what it keeps where it was."""

import numpy as np
import pytest

from handsim.grasping.gripping.grip import LIGHT, MOST, SURPRISE
from handsim.grasping.robots.robot_grip import FASTEST, MOST_CLOSED, MOST_KEPT, RobotGrip
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.joints import FINGERS

DT, STIFF = 0.01, 6.0
"""[s], and force of the servos for one unit of the squeeze [N]."""
CLOSING = np.array([0.3, 0.4, 0.0])
JACOBIAN = np.zeros((len(FINGERS), 3, 3))
JACOBIAN[0, 0] = [0.1, 0.0, 0.0]  # only the first coordinate moves the thumb


def servos(lag: float = 0.02) -> RobotServos:
    stiffness = np.diag([STIFF * 0.03 / 0.09, 1.0, 1.0])  # 0.3 of it by 0.03 m is 6 N
    return RobotServos(stiffness, JACOBIAN, np.full(3, lag), np.ones(3, dtype=bool))


def grip(force: float = 3.0, kept=(True, True, True), lag: float = 0.02) -> RobotGrip:
    return RobotGrip(CLOSING, force, servos(lag), np.array(kept))


def squeezed(hand: RobotGrip, seconds: float, contact: float, squeeze: float = 1.0) -> float:
    """Close on a spring that is met after ``contact`` units; return its force at the end."""
    force = 0.0
    for _ in range(round(seconds / DT)):
        hand.feel([force, 0.6 * force, 0.4 * force, 0.0, 0.0])
        hand.targets(np.zeros(3), squeeze, DT)
        force = STIFF * max(hand.closed - contact, 0.0)
    return force


def test_the_reckoned_stiffness_is_that_of_the_thumb():
    assert grip()._stiffness == pytest.approx(STIFF)


def test_until_the_squeeze_it_goes_where_it_is_told():
    hand, told = grip(), np.array([0.1, 0.2, 0.3])
    np.testing.assert_array_equal(hand.targets(told, 0.0, DT), told)
    assert hand.closed == 0.0


def test_it_closes_along_one_direction_until_the_force_is_there():
    hand = grip()
    assert squeezed(hand, 2.0, contact=0.8) == pytest.approx(3.0, rel=1e-3)
    np.testing.assert_allclose(hand.targets(np.ones(3), 1.0, DT), 1.0 + hand.closed * CLOSING)


def test_before_contact_it_closes_no_faster_and_no_farther_than_it_may():
    hand = grip(force=60.0)
    hand.targets(np.zeros(3), 1.0, DT)
    assert hand.closed == pytest.approx(FASTEST * DT)
    squeezed(hand, 5.0, contact=100.0)
    assert hand.closed == MOST_CLOSED


def test_at_the_start_of_the_squeeze_it_presses_lightly():
    assert squeezed(grip(), 2.0, contact=0.5, squeeze=1e-6) == pytest.approx(LIGHT, rel=1e-2)


def test_what_counts_is_the_lesser_of_thumb_and_fingers():
    hand = grip()
    for _ in range(200):
        hand.feel([9.0, 0.0, 0.5, 0.25, 0.25])
    assert hand._force == pytest.approx(1.0)
    for _ in range(200):
        hand.feel([0.7, 4.0, 4.0, 0.0, 0.0])
    assert hand._force == pytest.approx(0.7)


def test_a_load_beyond_what_was_to_be_carried_tightens_in_proportion():
    hand = grip()
    hand.tighten(0.0, 2.0, DT)
    assert squeezed(hand, 2.0, contact=0.5) == pytest.approx(3.0 * 2.0 / SURPRISE, rel=1e-3)
    hand.tighten(0.0, 100.0, DT)
    assert squeezed(hand, 3.0, contact=0.5) == pytest.approx(3.0 * MOST, rel=1e-2)
    hand.tighten(0.0, 0.0, DT)  # and it stays so
    assert squeezed(hand, 1.0, contact=0.5) == pytest.approx(3.0 * MOST, rel=1e-2)


def test_sliding_tightens_swaying_does_not():
    hand = grip()
    hand.tighten(0.08, 0.0, DT)
    assert hand._tighter == 1.0
    hand.tighten(0.12, 0.0, DT)
    assert hand._tighter == pytest.approx(1.0 + DT * 0.03 / 0.003)


def test_slow_servos_are_corrected_slowly():
    assert grip(lag=0.02)._settling == 0.05
    assert grip(lag=0.3)._settling == pytest.approx(0.3)


def test_what_gives_way_aside_is_put_back_what_closes_is_not():
    hand, along = grip(), CLOSING / np.linalg.norm(CLOSING)
    aside = np.array([along[1], -along[0], 0.0])
    hand.keep(np.zeros(3), DT)
    hand.keep(0.1 * aside + 0.2 * along, DT)
    np.testing.assert_allclose(hand._offset, -DT / 0.05 * 0.1 * aside, atol=1e-12)
    for _ in range(1000):
        hand.keep(np.array([0.0, 0.0, -0.5]), DT)
    assert hand._offset[2] == MOST_KEPT


def test_coordinates_that_the_action_moves_are_not_kept():
    hand = grip(kept=(True, True, False))
    hand.keep(np.zeros(3), DT)
    hand.keep(np.array([0.0, 0.0, 0.4]), DT)
    assert hand._offset[2] == 0.0

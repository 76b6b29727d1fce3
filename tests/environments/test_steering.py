"""What a driver gives for the actions of a policy."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from handsim.environments.asked import grasped
from handsim.environments.entries import SPEED
from handsim.environments.steering import VelocityDriver
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.joints import N_JOINTS, clip_to_range
from handsim.reproducible import total

DT = 0.01


@pytest.fixture
def known():
    return grasped("pen-write", Conditions())


@pytest.fixture
def driver(known) -> VelocityDriver:
    schedule = schedule_for(known.task)
    return VelocityDriver(known.controller, known.plan, np.full(N_JOINTS, 0.03), schedule)


def test_a_point_is_drawn_once_for_each_reading(known, driver):
    """Asked for what is seen and again for what is commanded, and for others in between."""
    rng, reference = np.random.default_rng(0), driver.start(1)
    readings = [known.plan.q_start + rng.normal(0.0, 0.1, (1, N_JOINTS)) for _ in range(2)]
    first = driver.point(0.1, reference, readings[0])
    assert driver.point(0.1, reference, readings[0]) is first
    for other, by in ((reference, readings[1]), (reference + 0.1, readings[1])):
        again = driver.point(0.1, other, by)
        assert not np.array_equal(again, first)
        np.testing.assert_allclose(again, other + 0.02 * (driver.coordinates(by) - other))
        first = again


def test_the_reach_goes_on_by_the_velocity_from_what_is_drawn(known, driver):
    driver.give(np.array([[0.1, -0.2, 0.3]]))
    reference, readings = driver.start(1), known.plan.q_start[None] + 0.05
    targets, following = driver.step(0.1, DT, reference, readings)
    drawn, velocity = driver.point(0.1, reference, readings), SPEED * np.array([[0.1, -0.2, 0.3]])
    np.testing.assert_allclose(following, drawn + DT * velocity)
    subspace = known.controller.subspace
    lead = 0.03 * velocity @ subspace.components_
    np.testing.assert_allclose(targets, clip_to_range(subspace.inverse_transform(drawn) + lead))


def test_the_targets_of_a_point_that_stays_are_the_same_array(known, driver):
    """It tells the grip that nothing is to be aimed anew; those of another point are others."""
    schedule, subspace = schedule_for(known.task), known.controller.subspace
    driver.give(np.zeros((1, 3)))
    after, readings = schedule.action_start + 0.5, known.plan.q_start[None]
    one, two = known.plan.z_goal[None], known.plan.z_goal[None] + 0.01
    first, _ = driver.step(after, DT, one, readings)
    same, following = driver.step(after + DT, DT, one.copy(), readings)
    assert same is first
    np.testing.assert_array_equal(following, one)
    other, _ = driver.step(after + 2 * DT, DT, two, readings)
    for targets, z in ((first, one), (other, two)):
        np.testing.assert_array_equal(targets, clip_to_range(subspace.inverse_transform(z)))
    assert total(np.abs(other - first)[0]) > 1e-3


def test_targets_go_over_to_the_posture_while_the_hand_squeezes(known, driver):
    schedule, readings = schedule_for(known.task), known.plan.q_start[None]
    driver.give(np.full((1, 3), 0.2))
    last, z = driver.step(schedule.reach, DT, driver.start(1), readings)
    posture = clip_to_range(known.controller.subspace.inverse_transform(z))
    begins, _ = driver.step(schedule.squeeze_start + 1e-9, DT, z, readings)
    half, _ = driver.step(schedule.squeeze_start + 0.5 * schedule.squeeze, DT, z, readings)
    np.testing.assert_allclose(begins, last, atol=1e-6)
    np.testing.assert_allclose(half, 0.5 * (last + posture), atol=1e-6)

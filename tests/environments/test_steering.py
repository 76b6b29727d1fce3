"""What a driver gives for the actions of a policy."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from dataclasses import replace

from handsim.environments.asked import grasped
from handsim.environments.entries import SPEED
from handsim.environments.steering import TargetDriver, VelocityDriver, steered_driver
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import ramp, schedule_for
from handsim.joints import LOWER, N_JOINTS, UPPER, clip_to_range
from handsim.learning.transport.coupling import WIDEST_AT
from handsim.reproducible import total

DT = 0.01
LEAD = np.full(N_JOINTS, 0.03)


@pytest.fixture(scope="module")
def known():
    return grasped("pen-write", Conditions())


@pytest.fixture
def driver(known) -> VelocityDriver:
    return VelocityDriver(known.controller, known.plan, LEAD, schedule_for(known.task))


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
    start, plan = known.plan.q_start, known.plan
    widest_at = WIDEST_AT * plan.arrive * schedule_for(known.task).reach
    outside = start - subspace.inverse_transform(subspace.transform(start))
    left = 1.0 - ramp(np.array([0.1, 0.1 + 1e-6]), 0.0, widest_at)
    fading = outside * (left[0] + 0.03 * (left[1] - left[0]) / 1e-6)
    posture = subspace.inverse_transform(drawn) + lead + fading
    np.testing.assert_allclose(targets, clip_to_range(posture), atol=1e-6)


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
    driver.step(0.5 * schedule.reach, DT, driver.start(1) + 0.2, readings)
    last, z = driver.step(schedule.reach, DT, driver.start(1), readings)
    posture = clip_to_range(known.controller.subspace.inverse_transform(z))
    begins, _ = driver.step(schedule.squeeze_start + 1e-9, DT, z, readings)
    half, _ = driver.step(schedule.squeeze_start + 0.5 * schedule.squeeze, DT, z, readings)
    np.testing.assert_allclose(begins, last, atol=1e-6)
    np.testing.assert_allclose(half, 0.5 * (last + posture), atol=1e-6)


def test_the_point_goes_on_by_the_velocity_after_the_reach(known, driver):
    driver.give(np.array([[0.1, -0.2, 0.3]]))
    z, after = known.plan.z_goal[None], schedule_for(known.task).squeeze_start + 0.1
    driver.step(0.5, DT, z, known.plan.q_start[None])  # in the reach, as always before
    _, following = driver.step(after, DT, z, known.plan.q_start[None])
    np.testing.assert_array_equal(following, z + DT * SPEED * np.array([[0.1, -0.2, 0.3]]))
    assert driver.point(after, z, known.plan.q_start[None] + 0.1) is z


def test_readings_draw_the_point_to_the_end_of_the_reach_and_no_longer(known, driver):
    end, z = schedule_for(known.task).reach, driver.start(1)
    readings = known.plan.q_start[None] + 0.1
    assert not np.array_equal(driver.point(end, z, readings), z)
    np.testing.assert_array_equal(driver.point(end + 1e-9, z, readings), z)


@pytest.mark.parametrize("way", [-1.0, 1.0])
@pytest.mark.parametrize("after", [0.3, 3.0])
def test_the_point_stays_where_destinations_may_lie(known, driver, way, after):
    low, high = known.controller.reach
    z_start = known.controller.subspace.transform(known.plan.q_start)
    low, high = np.minimum(low, z_start), np.maximum(high, z_start)
    driver.give(np.full((1, 3), way))
    z = driver.start(1)
    for _ in range(400):
        posture = known.controller.subspace.inverse_transform(z)
        driver.step(0.3, DT, z, posture)
        _, z = driver.step(after, DT, z, posture)
    np.testing.assert_array_equal(z[0], low if way < 0.0 else high)


def test_a_start_beyond_the_destinations_is_no_reason_to_jump(known):
    """Bounds are those of destinations, made wider where the plan begins outside."""
    subspace, (low, high) = known.controller.subspace, known.controller.reach
    for z in (low - 0.5, high + 0.5):
        plan = replace(known.plan, q_start=subspace.inverse_transform(z))
        driver = VelocityDriver(known.controller, plan, LEAD, schedule_for(known.task))
        driver.give(np.zeros((1, 3)))
        _, following = driver.step(0.0, DT, driver.start(1), plan.q_start[None])
        np.testing.assert_allclose(following[0], z, atol=1e-9)


@pytest.mark.parametrize("far", [-3.0, 3.0])
def test_targets_stay_within_the_ranges_of_motion(known, driver, far):
    """Those of the reach, of the squeeze and of the action."""
    schedule = schedule_for(known.task)
    z = known.plan.z_goal[None] + far
    posture = known.controller.subspace.inverse_transform(z)[0]
    assert ((posture < LOWER) | (posture > UPPER)).any()
    driver.give(np.full((1, 3), np.sign(far)))
    times = (0.5, schedule.squeeze_start + 0.4 * schedule.squeeze, schedule.action_start + 0.1)
    for time in times:
        targets, _ = driver.step(time, DT, z, posture[None])
        assert ((targets >= LOWER) & (targets <= UPPER)).all()
    np.testing.assert_array_equal(targets[0], clip_to_range(posture))


def test_the_hand_has_closed_when_the_action_begins(known, driver):
    schedule, readings = schedule_for(known.task), known.plan.q_start[None]
    driver.give(np.zeros((1, 3)))
    driver.step(schedule.reach, DT, driver.start(1), readings)
    z = known.plan.z_goal[None]
    at_once, _ = driver.step(schedule.action_start, DT, z, readings)
    np.testing.assert_array_equal(
        at_once, clip_to_range(known.controller.subspace.inverse_transform(z))
    )
    before, _ = driver.step(schedule.action_start - 0.2, DT, z, readings)
    assert np.abs(before - at_once).max() > 1e-3


def test_what_is_asked_beside_commands_is_the_plans(known, driver):
    subspace, schedule = known.controller.subspace, schedule_for(known.task)
    np.testing.assert_allclose(
        driver.destination, clip_to_range(subspace.inverse_transform(known.plan.z_goal))
    )
    z_start = subspace.transform(known.plan.q_start)
    np.testing.assert_array_equal(driver.start(2), np.tile(z_start, (2, 1)))
    readings = known.plan.q_start + np.array([[0.0], [0.1]])
    np.testing.assert_array_equal(driver.coordinates(readings), subspace.transform(readings))
    at_goal = subspace.inverse_transform(known.plan.z_goal)
    assert driver.arrived(at_goal)
    assert not driver.arrived(subspace.inverse_transform(known.plan.z_goal + np.deg2rad(10.0)))
    assert driver.name == "policy"
    assert driver.reach > schedule.end  # a policy is asked at every reading


def test_several_runs_are_steered_as_each_by_itself(known):
    rng, schedule = np.random.default_rng(4), schedule_for(known.task)
    actions = rng.uniform(-1, 1, (3, 3))
    readings = known.plan.q_start + rng.normal(0.0, 0.05, (3, N_JOINTS))
    together = VelocityDriver(known.controller, known.plan, LEAD, schedule)
    z = together.start(3) + rng.normal(0.0, 0.1, (3, 3))
    together.give(actions)
    for time in (0.4, schedule.squeeze_start + 0.2, schedule.action_start + 0.2):
        targets, following = together.step(time, DT, z, readings)
        for i in range(3):
            alone = VelocityDriver(known.controller, known.plan, LEAD, schedule)
            alone.give(actions[i : i + 1])
            for earlier in (0.4, time):
                own, its = alone.step(earlier, DT, z[i : i + 1], readings[i : i + 1])
            np.testing.assert_array_equal(targets[i], own[0])
            np.testing.assert_array_equal(following[i], its[0])


def test_joint_targets_are_what_a_policy_gives(known):
    schedule = schedule_for(known.task)
    driver = steered_driver("joints", known.controller, known.plan, LEAD, schedule)
    assert isinstance(driver, TargetDriver)
    z, readings = driver.start(1), known.plan.q_start[None] + 0.1
    actions = np.linspace(-1.0, 1.0, N_JOINTS)[None]
    driver.give(actions)
    for time in (0.3, schedule.action_start + 0.3):
        targets, following = driver.step(time, DT, z, readings)
        np.testing.assert_allclose(targets, LOWER + 0.5 * (actions + 1.0) * (UPPER - LOWER))
        np.testing.assert_array_equal(following, z)
        np.testing.assert_array_equal(
            driver.point(time, z, readings), known.controller.subspace.transform(readings)
        )


def test_velocities_are_what_other_policies_give(known):
    driver = steered_driver(
        "components", known.controller, known.plan, LEAD, schedule_for(known.task)
    )
    assert isinstance(driver, VelocityDriver)

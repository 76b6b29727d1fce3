"""What drives the fingers: a script, or a controller with a reference of its own."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import ramp, schedule_for
from handsim.grasping.planning.plan_store import plan_store
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import (
    CORRECTION,
    LearnedDriver,
    ScriptedDriver,
    learned_driver,
)
from handsim.joints import LOWER, N_JOINTS, UPPER, clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.transport.coupling import WIDEST_AT
from handsim.tasks.table_one import task_by_name

SCHEDULE = schedule_for(task_by_name("cube-raise"))
LEAD = np.zeros(N_JOINTS)
DT = 0.01


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def plan(controller):
    store = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    return store.read()["cube-raise"]


def test_a_destination_in_the_subspace_is_followed_to_the_bit(controller, plan):
    z_goal = plan.z_goal + 0.01
    driver = learned_driver(controller, replace(plan, z_goal=z_goal), LEAD, SCHEDULE)
    assert driver.z_goal.tobytes() == driver.timing.field.z_goal.tobytes() == z_goal.tobytes()
    lifted = clip_to_range(controller.subspace.inverse_transform(z_goal))
    np.testing.assert_array_equal(driver.destination, lifted)


def test_without_one_it_is_the_projection_of_the_posture(controller, plan):
    driver = learned_driver(controller, replace(plan, z_goal=None), LEAD, SCHEDULE)
    wanted = controller.subspace.transform(plan.q_goal)
    np.testing.assert_allclose(driver.z_goal, wanted, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("z_goal", [np.zeros(2), np.full(3, 9.0), np.full(3, np.nan)])
def test_a_destination_of_another_controller_is_refused(controller, plan, z_goal):
    with pytest.raises(InputError):
        learned_driver(controller, replace(plan, z_goal=z_goal), LEAD, SCHEDULE)


@pytest.fixture(scope="module")
def leads() -> np.ndarray:
    """Ratios of damping to stiffness of the hand's actuators [s]."""
    lead = Scene.build(task_by_name("cube-raise"), Conditions(base="free")).lead
    assert 0.005 < lead.min() < lead.max() < 0.05
    return lead


@pytest.fixture(scope="module")
def driver(controller, plan, leads) -> LearnedDriver:
    return learned_driver(controller, plan, leads, SCHEDULE)


def test_a_reference_starts_where_the_plan_starts_and_is_carried_by_the_velocity(driver):
    """A reading that agrees with the reference changes nothing about it."""
    z = driver.start(3)
    driver = replace(driver, outside=None)
    np.testing.assert_array_equal(z, np.tile(driver.z_start, (3, 1)))
    subspace = driver.controller.subspace
    for time in (0.3, 0.6, 0.9):
        reading = subspace.inverse_transform(z)
        targets, after = driver.step(time, DT, z, reading)
        velocity = driver.timing.velocities(z, time)
        assert np.abs(velocity).max() > 0.05
        np.testing.assert_allclose(after, z + DT * velocity, atol=1e-12)
        ahead = clip_to_range(reading + (velocity @ subspace.components_) * driver.lead)
        np.testing.assert_allclose(targets, ahead, atol=1e-12)
        z = after


def test_a_hand_begins_where_it_rests_though_that_is_outside_the_subspace(driver, plan):
    """It does not spring to the nearest posture that the components have, which is 19 deg away."""
    resting = plan.q_start[None]
    targets, _ = driver.step(0.0, DT, driver.start(1), resting)
    np.testing.assert_allclose(targets[0], plan.q_start, atol=np.deg2rad(0.5))
    sprung, _ = replace(driver, outside=None).step(0.0, DT, driver.start(1), resting)
    assert np.rad2deg(np.abs(sprung[0] - plan.q_start).max()) > 15.0


def test_what_is_outside_fades_with_minimum_jerk_until_two_thirds_of_the_transport(driver, plan):
    assert WIDEST_AT == 0.67
    assert driver.widest_at == WIDEST_AT * plan.arrive * driver.reach
    within, z, reading = replace(driver, outside=None), driver.start(2), plan.q_start[None][[0, 0]]
    narrow = [plan.q_start > LOWER + 0.05, plan.q_start < UPPER - 0.05]
    free = np.logical_and.reduce(narrow)  # what no range cuts off
    assert free.sum() > 15
    outside, lead = driver.outside[free], driver.lead[free]

    def left(time):
        away = driver.step(time, DT, z, reading)[0] - within.step(time, DT, z, reading)[0]
        return away[:, free]

    half = driver.widest_at / 2
    fading = 1.875 / driver.widest_at  # the greatest rate of minimum jerk
    np.testing.assert_allclose(left(half), [outside * (0.5 - fading * lead)] * 2, atol=1e-9)
    early = outside * (1 - ramp(0.2 * driver.widest_at, 0.0, driver.widest_at))
    late = left(0.2 * driver.widest_at)[0] - early
    rate = 30 * 0.2**2 * 0.8**2 / driver.widest_at
    np.testing.assert_allclose(late, -outside * rate * lead, atol=1e-9)
    for time in (driver.widest_at, driver.widest_at + DT, driver.reach - DT):
        np.testing.assert_array_equal(left(time), 0.0)


def test_a_reference_is_drawn_to_the_reading_by_a_fiftieth(driver):
    assert CORRECTION == 0.02
    z, off = driver.start(1), np.array([[0.2, -0.1, 0.05]])
    reading = driver.controller.subspace.inverse_transform(z + off)
    _, after = driver.step(0.5, DT, z, reading)
    drawn = z + 0.02 * off
    np.testing.assert_allclose(after, drawn + DT * driver.timing.velocities(drawn, 0.5), atol=1e-12)


def followed(driver: LearnedDriver, bias: np.ndarray, by_reading: bool = False) -> np.ndarray:
    """Postures (n, 22) of a hand that does what its actuators do, seen by a glove that is off.

    ``by_reading`` takes the reading itself for where the hand is meant to be, each time.
    """
    subspace = driver.controller.subspace
    reference, q, path = driver.start(1), subspace.inverse_transform(driver.start(1)), []
    for time in np.arange(0.0, driver.reach, DT):
        reading = q + bias
        if by_reading:
            z = subspace.transform(reading)
            velocity = driver.timing.velocities(z, time)
            targets = clip_to_range(reading + (velocity @ subspace.components_) * driver.lead)
        else:
            targets, reference = driver.step(time, DT, reference, reading)
        q = targets + (q - targets) * np.exp(-DT / driver.lead)
        path.append(q[0])
    return np.array(path)


@pytest.mark.parametrize("seed", range(3))
def test_a_glove_that_is_off_by_3_deg_moves_the_hand_little(driver, seed):
    """Where targets are made of readings, the hand moves by 3 deg in each time of the lead."""
    bias = np.deg2rad(3.0) * np.random.default_rng(seed).choice([-1.0, 1.0], N_JOINTS)
    off, before = (
        np.rad2deg(np.abs(followed(driver, bias, law) - followed(driver, 0.0 * bias, law)))
        for law in (False, True)
    )
    assert off.mean() < 1.5
    assert off.max() < 6.0
    assert before.mean() > 5 * off.mean()


def test_a_hand_that_does_as_it_is_told_comes_to_its_destination(driver):
    path = followed(driver, np.zeros(N_JOINTS))
    assert driver.arrived(path[-1])
    assert not driver.arrived(path[0])
    jump = np.rad2deg(np.abs(driver.destination - path[-1]).max())
    assert jump < 5.0


@pytest.mark.parametrize("far", [-3.0, 3.0])
def test_targets_stay_within_the_ranges_of_motion(driver, far):
    subspace = driver.controller.subspace
    z = driver.z_goal[None] + far
    q = subspace.inverse_transform(z)
    assert ((q < LOWER) | (q > UPPER)).any()
    outside = replace(driver, outside=np.full(N_JOINTS, far))
    for each in (driver, outside):
        targets, _ = each.step(0.5, DT, z, q)
        assert ((targets >= LOWER) & (targets <= UPPER)).all()
    targets, _ = replace(driver, outside=None).step(0.5, DT, z, q)
    lead = driver.timing.velocities(z, 0.5) @ subspace.components_ * driver.lead
    np.testing.assert_allclose(targets, clip_to_range(q + lead), atol=1e-12)


def test_runs_together_get_the_bits_of_each_alone(driver):
    generator = np.random.default_rng(0)
    readings = driver.controller.demonstrations[3].q_start + generator.normal(0, 0.2, (40, 22))
    references = driver.start(40) + generator.normal(0, 0.1, (40, 3))
    for time in (0.0, 0.4, 1.1, 1.3):
        targets, after = driver.step(time, DT, references, readings)
        for i in range(40):
            own, own_after = driver.step(time, DT, references[[i]], readings[[i]])
            np.testing.assert_array_equal(targets[i], own[0])
            np.testing.assert_array_equal(after[i], own_after[0])
    for i, z in enumerate(driver.coordinates(readings)):
        np.testing.assert_array_equal(z, driver.coordinates(readings[[i]])[0])


def test_a_script_needs_no_readings():
    start, opened, closed = (np.full(N_JOINTS, value) for value in (0.1, 0.3, 0.9))
    script = ScriptedDriver(start, opened, closed, reach=1.0, peak_aperture_at=0.6)
    reference = script.start(2)
    assert reference.shape == (2, 0)
    readings = np.full((2, N_JOINTS), np.nan)
    told = [script.step(time, DT, reference, readings)[0][0] for time in (0, 0.3, 0.6, 0.8, 1, 2)]
    np.testing.assert_allclose(told, [0.1, 0.2, 0.3, 0.6, 0.9, 0.9])
    np.testing.assert_array_equal(script.destination, closed)
    assert script.coordinates(readings).shape == (2, 0)
    assert script.arrived(readings[0])

"""What drives the fingers: a plan's destination is gone to as it is."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.plan_store import plan_store
from handsim.grasping.rollout.drivers import learned_driver
from handsim.joints import N_JOINTS, clip_to_range
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name

SCHEDULE = schedule_for(task_by_name("cube-raise"))
LEAD = np.zeros(N_JOINTS)


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
    np.testing.assert_array_equal(driver.targets(SCHEDULE.reach, plan.q_start), lifted)


def test_without_one_it_is_the_projection_of_the_posture(controller, plan):
    driver = learned_driver(controller, replace(plan, z_goal=None), LEAD, SCHEDULE)
    wanted = controller.subspace.transform(plan.q_goal)
    np.testing.assert_allclose(driver.z_goal, wanted, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("z_goal", [np.zeros(2), np.full(3, 9.0), np.full(3, np.nan)])
def test_a_destination_of_another_controller_is_refused(controller, plan, z_goal):
    with pytest.raises(InputError):
        learned_driver(controller, replace(plan, z_goal=z_goal), LEAD, SCHEDULE)

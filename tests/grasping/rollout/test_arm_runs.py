"""A hand on an arm goes where its palm is to be, with a person's strength alone."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.arm.arm_joints import ARM_JOINT_NAMES
from handsim.arm.arm_strength import arm_torque_limits
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import Schedule
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import ScriptedDriver
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

TASK = task_by_name("cube-raise")
SCHEDULE = Schedule(steps=(0.8,), hold=0.3, reach=0.8, squeeze=0.2)


def run_above(height: float, **conditions) -> Rollout:
    """A scripted grasp ``height`` [m] above the object, or below it."""
    scene = Scene.build(TASK, Conditions(**conditions))
    side = scene.conditions.hand.side
    hand = HandModel.from_spec(build_hand(scene.conditions.hand))
    plan, q_open = scripted_plan(TASK.for_side(side), hand, side=side)
    plan = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, height])))
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, SCHEDULE.reach)
    return simulate(scene, plan, driver, schedule=SCHEDULE)


def misses(run: Rollout) -> tuple[np.ndarray, np.ndarray]:
    """How far the palm is from where it is to be, (n,) [mm] and [deg]."""
    model = run.model()
    data, miss = mujoco.MjData(model), []
    for qpos, pos, quat in zip(run.qpos, run.mocap_pos, run.mocap_quat, strict=True):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        palm, asked = (
            Rotation.from_quat(each, scalar_first=True) for each in (data.body("palm").xquat, quat)
        )
        turn = (palm * asked.inv()).magnitude()
        miss.append((np.linalg.norm(data.body("palm").xpos - pos), turn))
    away, turned = np.array(miss).T
    return 1000 * away, np.rad2deg(turned)


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_palm_follows_its_path(side):
    away, turned = misses(run_above(0.10, hand=HandSize(side=side)))
    assert away[0] < 0.1
    assert away.max() < 4.0
    assert away[-1] < 0.5
    assert turned.max() < 2.5


def test_an_arm_that_meets_the_table_is_not_where_it_is_to_be():
    """It presses with what its muscles have, where a free hand presses with hundreds of newtons."""
    on_arm, free = (run_above(-0.06, base=base) for base in ("arm", "free"))
    away, _ = misses(on_arm)
    assert away.max() > 15.0
    assert 15.0 < on_arm.table_force.max() < 0.1 * free.table_force.max()
    limits = arm_torque_limits(Scene.build(TASK, Conditions()).arm.geometry)
    model = on_arm.model()
    ranges = [model.actuator(name).forcerange[1] for name in ARM_JOINT_NAMES]
    np.testing.assert_allclose(ranges, limits, rtol=1e-4)


def test_a_path_that_no_arm_follows_is_told_by_its_strain():
    assert run_above(0.10).outcome.strain < 1.5
    assert run_above(1.5).outcome.strain > 20.0
    assert run_above(0.10, base="free").outcome.strain == 0.0

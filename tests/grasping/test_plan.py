import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.grasping.conditions import Conditions, Perturbation, perturb
from handsim.grasping.gripping.squeeze import SQUEEZE_DEG, squeeze_offset
from handsim.grasping.plan import GraspPlan, PalmPath, Pose, ramp, schedule_for
from handsim.joints import JOINT_INDEX
from handsim.tasks.table_one import task_by_name


def quat(axis: str, degrees: float) -> np.ndarray:
    return Rotation.from_euler(axis, degrees, degrees=True).as_quat(scalar_first=True)


@pytest.fixture
def plan() -> GraspPlan:
    return GraspPlan(
        palm=Pose(np.array([-0.1, -0.05, 0.08]), quat("z", 30)),
        retreat=np.array([-0.1, 0.0, 0.02]),
        q_start=np.zeros(22),
        q_goal=np.full(22, 0.3),
    )


def path(plan: GraspPlan, task: str) -> PalmPath:
    chosen = task_by_name(task)
    object_pose = Pose(np.array([0.01, 0.02, 0.0]), quat("z", chosen.yaw_deg))
    return PalmPath(plan, chosen, schedule_for(chosen), object_pose)


def test_the_reach_begins_at_the_retreat_and_ends_at_the_grasp(plan):
    palm = path(plan, "tall-glass-drink")
    grasp = palm.object_pose @ plan.palm
    start = palm.object_pose @ plan.palm.moved(plan.retreat)
    np.testing.assert_allclose(palm.at(0.0).pos, start.pos)
    for time in (palm.schedule.reach, palm.schedule.action_start):
        np.testing.assert_allclose(palm.at(time).pos, grasp.pos)
        np.testing.assert_allclose(palm.at(time).rotation.as_matrix(), grasp.rotation.as_matrix())


def test_every_step_keeps_the_grasp_point_in_the_hand(plan):
    palm = path(plan, "tall-glass-drink")
    point = palm.object_pose.pos + palm.object_pose.rotation.apply(palm.task.grasp.point)
    before, after = palm.at(palm.schedule.action_start), palm.at(palm.schedule.end)
    shift = sum(np.array(step.shift) for step in palm.task.steps)
    assert np.linalg.norm(shift) > 0.05
    local = before.rotation.inv().apply(point - before.pos)
    np.testing.assert_allclose(after.rotation.apply(local) + after.pos, point + shift, atol=1e-12)


def test_drinking_turns_the_palm_as_the_task_says(plan):
    palm = path(plan, "tall-glass-drink")
    turn = palm.at(palm.schedule.end).rotation * palm.at(0.0).rotation.inv()
    wanted = sum(np.deg2rad(step.angle_deg) * np.array(step.axis) for step in palm.task.steps)
    np.testing.assert_allclose(turn.as_rotvec(), wanted, atol=1e-12)


def test_the_palm_moves_without_jumps(plan):
    palm = path(plan, "tall-glass-drink")
    times = np.arange(0.0, palm.schedule.end, 0.01)
    steps = np.diff(palm.poses(times)[0], axis=0)
    assert 0.001 < np.linalg.norm(steps, axis=1).max() < 0.02


def test_clicking_flexes_one_finger(plan):
    palm = path(plan, "mouse-left-click")
    times = np.linspace(0.0, palm.schedule.hold_start, 200)
    moved = np.abs(palm.flexions(times)).max(axis=0)
    wanted = max(step.angle_deg for step in palm.task.steps)
    assert moved[JOINT_INDEX["index_mcp"]] == pytest.approx(np.deg2rad(wanted), rel=0.05)
    assert np.count_nonzero(moved) == 1


def test_ramp_is_minimum_jerk():
    assert ramp(0.9, 1.0, 2.0) == 0.0
    assert ramp(2.0, 1.0, 2.0) == pytest.approx(0.5)
    assert ramp(3.1, 1.0, 2.0) == 1.0
    assert ramp(1.2, 1.0, 2.0) == pytest.approx(10 * 0.1**3 - 15 * 0.1**4 + 6 * 0.1**5)


def test_squeeze_flexes_what_it_says():
    offset = np.rad2deg(squeeze_offset(0.5))
    assert offset[JOINT_INDEX["index_mcp"]] == pytest.approx(0.5 * SQUEEZE_DEG["index_mcp"])
    assert offset[JOINT_INDEX["thumb_abduction"]] == 0
    assert np.count_nonzero(offset) == len(SQUEEZE_DEG) == 14


def test_perturbations_stay_within_their_ranges_and_repeat():
    ranges = Perturbation()
    trials = [perturb(Conditions(), seed) for seed in range(200)]
    assert trials[3] == perturb(Conditions(), 3)
    offsets = np.array([trial.object_offset for trial in trials])
    assert np.abs(offsets[:, :2]).max() <= ranges.position
    assert np.abs(offsets[:, :2]).max() > 0.9 * ranges.position
    frictions = [trial.friction for trial in trials]
    assert ranges.friction[0] <= min(frictions) < max(frictions) <= ranges.friction[1]
    assert not any(trial.nominal for trial in trials)

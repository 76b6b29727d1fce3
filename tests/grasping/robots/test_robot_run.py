"""Runs of a robot hand: the own hand read from its file holds what a person's plan holds."""

import pickle
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.planning.planner import STEPS
from handsim.grasping.planning.search import shortened
from handsim.grasping.robots import robot_grasper as module
from handsim.grasping.robots.robot_grasper import RobotGrasper, key_of_robot
from handsim.grasping.robots.robot_lead import LearnedLead
from handsim.grasping.robots.robot_planner import RobotGrasps, plan_robot_grasp
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout_file import read_rollout, write_rollout
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.table_one import task_by_name

TASK, FREE = task_by_name("cube-raise"), Conditions(base="free")


@pytest.fixture(scope="module")
def held(grasps, scene, plan):
    return grasps.run(scene, plan)


@pytest.mark.ci
def test_a_hand_from_a_file_raises_the_cube(held):
    assert held.outcome.success, held.outcome
    assert held.outcome.opposed > 0.95
    thumb = held.outcome.forces_n["thumb"]
    assert 1.0 < thumb < 4.0 * held.outcome.need_n


def test_the_same_run_gives_the_same_bits(held, grasps, scene, plan):
    again = grasps.run(scene, plan)
    np.testing.assert_array_equal(again.qpos, held.qpos)
    np.testing.assert_array_equal(again.ctrl, held.ctrl)


def test_it_squeezes_longer_than_a_person_by_the_lag_of_its_servos(grasps, scene):
    from handsim.grasping.plan import schedule_for
    from handsim.grasping.robots.robot_planner import SQUEEZE_LAGS
    from handsim.grasping.robots.robot_servos import RobotServos

    lag = RobotServos.at(scene.robot, scene.robot.reference).lag
    longer = grasps.schedule(scene).squeeze - schedule_for(TASK).squeeze
    assert longer == pytest.approx(SQUEEZE_LAGS * lag, abs=0.005)
    assert longer / 0.01 == pytest.approx(round(longer / 0.01), abs=1e-6)


def test_the_reading_is_the_person_whom_it_follows(held, grasps):
    z = grasps.lead.controller.subspace.transform(held.reading)
    np.testing.assert_allclose(held.z, z)
    assert held.reading.shape == (len(held.time), 22)


def test_a_rollout_is_read_again_with_its_meshes_and_model(held, tmp_path):
    write_rollout(held, tmp_path / "run.npz")
    model = read_rollout(tmp_path / "run.npz").model()
    assert model.nq == held.qpos.shape[1]
    assert model.body("forearm").mass[0] == pytest.approx(0.5)


def test_far_from_the_object_it_misses_and_a_brief_run_ends_when_it_is_due(grasps, scene, plan):
    apart = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.2])))
    whole, brief = (grasps.run(scene, apart, brief=each) for each in (False, True))
    assert whole.outcome.reason in ("missed", "not arrived")
    assert len(brief.time) < len(whole.time)
    np.testing.assert_array_equal(brief.qpos, whole.qpos[: len(brief.time)])


def test_what_is_pushed_far_ends_a_brief_run_as_the_action_begins(grasps, scene, plan):
    across = replace(plan, retreat=np.array([0.15, 0.0, 0.0]))  # fingers sweep over the table
    whole, brief = (grasps.run(scene, across, brief=each) for each in (False, True))
    assert whole.outcome.pushed_m > 0.04
    assert brief.time[-1] == pytest.approx(grasps.schedule(scene).action_start)


def test_a_hand_that_diverges_is_unstable(grasps, robot, plan):
    scene = RobotScene.build(TASK, FREE, robot)
    scene.model.opt.gravity[2] = -1e7
    assert grasps.run(scene, plan).outcome.reason == "unstable"


def test_an_actuator_that_is_no_servo_is_refused(hand_file, tmp_path):
    text, n = re.subn(
        r'<position (name="thumb_mcp" joint="thumb_mcp")[^/]*/>',
        r"<motor \1/>",
        hand_file.read_text(),
    )
    assert n == 1
    (tmp_path / "hand.xml").write_text(text)
    motor = RobotHand(tmp_path / "hand.xml", "palm", {f: f"{f}_pad" for f in ("thumb", "index")})
    with pytest.raises(InputError, match="no position servo: actuator"):
        RobotScene.build(TASK, FREE, motor)


def test_latency_and_mass_change_a_run(grasps, robot, plan, held):
    for changed in (replace(FREE, latency=0.05), replace(FREE, mass_scale=2.0)):
        run = grasps.run(RobotScene.build(TASK, changed, robot), plan)
        assert not np.array_equal(run.qpos, held.qpos)


def test_a_search_begins_with_the_better_start_and_keeps_it_where_it_holds(grasps, plan, held):
    off = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.1])))
    untried = replace(plan, palm=None)  # the one before holds with room to spare
    found, run, mapped = plan_robot_grasp(grasps, TASK, FREE, [off, plan, untried], generations=0)
    assert run.outcome.success
    again = grasps.run(RobotScene.build(TASK, FREE, grasps.retargeter.robot), found, mapped)
    np.testing.assert_array_equal(again.qpos, run.qpos)
    np.testing.assert_allclose(found.palm.pos, plan.palm.pos)
    np.testing.assert_allclose(run.qpos, held.qpos, atol=1e-6)


def test_what_does_not_hold_is_searched_again_from_what_was_found(grasps, plan, monkeypatch):
    off = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.2])))
    seeds, begun, tasks = [], [], []

    class Noting(RobotGrasps):
        def costs(self, scenes, plan):
            tasks.append(scenes[0].task)
            return super().costs(scenes, plan)

    noting = Noting(grasps.lead, grasps.retargeter)

    def search(cost, start, *, generations, seed, enough):
        seeds.append(seed)
        begun.append(cost(start))
        lower = start.copy()
        lower[5] = -0.1 / STEPS["shift"]  # half of the way each time
        return cost(lower), lower

    monkeypatch.setattr("handsim.grasping.robots.robot_planner.minimise", search)
    found, run, _ = plan_robot_grasp(noting, TASK, FREE, [off], seed=5)
    assert run.outcome.success
    assert seeds == [5, 6]
    short = shortened(TASK)
    assert tasks == [short, short, short, TASK, TASK] != [TASK] * 5  # which it did not hold
    assert min(begun) > 1.0
    np.testing.assert_allclose(found.palm.pos, plan.palm.pos, atol=1e-9)


def test_a_point_of_the_search_is_a_plan_in_its_steps(controller, plan, grasps):
    assert grasps.lead.n_varied == 12
    same = grasps.lead.varied(plan, np.zeros(12))
    np.testing.assert_allclose(same.goal_in(controller.subspace), plan.z_goal)
    point = np.zeros(12)
    point[[1, 3, 8, 9, 10, 11]] = [-1.0, 2.0, 1.0, 1.0, -0.5, 1.0]
    other = grasps.lead.varied(plan, point)
    moved = other.z_goal - plan.z_goal
    np.testing.assert_allclose(moved, [0.0, -STEPS["z"], 0.0], atol=1e-12)
    np.testing.assert_allclose(
        other.palm.pos - plan.palm.pos, [2 * STEPS["shift"], 0.0, 0.0], atol=1e-12
    )
    turned = (other.palm.rotation * plan.palm.rotation.inv()).as_rotvec()
    np.testing.assert_allclose(turned, [0.0, 0.0, STEPS["turn"]], atol=1e-12)
    assert other.squeeze == pytest.approx(plan.squeeze + STEPS["squeeze"])
    assert other.arrive == pytest.approx(plan.arrive - 0.5 * STEPS["arrive"])
    assert other.grip == pytest.approx(plan.grip * np.exp(STEPS["grip"]))


def tried(grasps, task, conditions, plan):
    """What a search returns that ends with this plan."""
    scene = RobotScene.build(task, conditions, grasps.retargeter.robot)
    told = grasps.told(scene, plan)
    return plan, grasps.run_told(scene, plan, told), told.movement.mapped


@pytest.fixture
def grasper(controller, robot, tmp_path):
    shipped = shipped_plans(controller.digest, Conditions())
    people = ControllerGrasper(controller, shared=(shipped,))
    return RobotGrasper(LearnedLead(people), robot, tmp_path / "plans")


def test_a_plan_is_searched_once_and_kept_for_this_hand_alone(
    grasper, three_fingers, monkeypatch, plan
):
    searched = []

    def search(grasps, task, conditions, starts, *, progress):
        searched.append(starts)
        return tried(grasps, task, conditions, starts[0])

    monkeypatch.setattr(module, "plan_robot_grasp", search)
    said: list[str] = []
    noting = replace(grasper, note=said.append)
    first = noting(TASK, Conditions())
    assert first.conditions.base == "free"
    np.testing.assert_array_equal(searched[0][0].palm.pos, plan.palm.pos)
    assert [start.arrive for start in searched[0]] == [0.6, 0.85, 0.6, 0.85]
    away = [np.linalg.norm(start.palm.pos - plan.palm.pos) for start in searched[0]]
    assert away[:2] == [0.0, 0.0]
    assert 0.0 < away[2] == away[3] < 0.02  # where the person's palm came to
    assert said == ["plan of cube-raise is searched for this hand, which takes minutes"]
    with monkeypatch.context() as elsewhere:  # another processor would map otherwise
        elsewhere.setattr(Retargeter, "retarget", None)
        again = replace(grasper, made={})(TASK, Conditions())  # from the file
    np.testing.assert_array_equal(again.qpos, first.qpos)
    assert len(searched) == 1
    replace(grasper, robot=three_fingers, made={})(TASK, Conditions())
    assert len(searched) == 2
    assert len(list(grasper.folder.iterdir())) == 2


def test_on_a_mount_a_search_begins_with_the_plan_for_a_free_base(grasper, monkeypatch, plan):
    begun = []

    def search(grasps, task, conditions, starts, *, progress):
        begun.append((conditions.base, starts))
        found = replace(starts[0], grip=starts[0].grip + 0.5)
        return tried(grasps, task, conditions, found)

    monkeypatch.setattr(module, "plan_robot_grasp", search)
    unplanned = replace(grasper, folder=None, made={})
    assert unplanned(TASK, Conditions(base="mounted")).conditions.base == "mounted"
    free = grasper.stored_for(TASK).plan
    mounted = grasper.stored_for(TASK, "mounted").plan
    assert [base for base, _ in begun] == ["mounted", "free", "mounted"]
    assert [len(starts) for _, starts in begun] == [4, 4, 5]
    assert begun[2][1][0].grip == free.grip == plan.grip + 0.5
    assert mounted.grip == plan.grip + 1.0
    again = replace(grasper, made={})  # both are kept
    assert again.stored_for(TASK).plan.grip == free.grip
    assert again.stored_for(TASK, "mounted").plan.grip == mounted.grip
    assert len(begun) == 3


def test_a_search_begins_with_what_was_kept_for_other_settings(grasper, monkeypatch, plan):
    begun = []

    def search(grasps, task, conditions, starts, *, progress):
        begun.append(starts)
        return tried(grasps, task, conditions, replace(starts[0], grip=2.5))

    monkeypatch.setattr(module, "plan_robot_grasp", search)
    grasper.stored_for(TASK)
    module._usual_key.cache_clear()
    monkeypatch.setattr(module, "CLEARANCE", 0.004)
    assert replace(grasper, made={}).stored_for(TASK).plan.grip == 2.5
    module._usual_key.cache_clear()
    assert [len(starts) for starts in begun] == [4, 5]
    assert begun[1][0].grip == 2.5 != begun[1][1].grip


def test_a_free_base_too_goes_from_reading_to_reading_without_steps(grasps, scene, plan):
    """Told a hundred times a second where to be, it would stop and start as often."""
    model, data = scene.model, scene.data
    speeds, step = [], mujoco.mj_step

    def watched(*args, **kwargs):
        step(*args, **kwargs)
        speeds.append(float(np.linalg.norm(data.joint("forearm").qvel[:3])))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mujoco.mj_step", watched)
        run = grasps.run(scene, plan)
    reach = np.array(speeds[100:300])  # 0.2 to 0.6 s
    assert len(speeds) == len(run.time) * round(0.01 / model.opt.timestep)
    assert np.abs(np.diff(reach)).max() < 0.05 * reach.max()


def test_a_plan_that_cannot_be_kept_is_used(grasper, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "plan_robot_grasp", lambda g, t, c, s, **_: tried(g, t, c, s[0]))
    (tmp_path / "file").write_text("")
    said: list[str] = []
    run = replace(grasper, folder=tmp_path / "file", note=said.append)(TASK, Conditions())
    assert run.outcome.success
    assert "could not be kept" in said[-1]


def test_another_process_gets_the_same_hand(grasper):
    assert grasper.grasps.retargeter.robot is grasper.robot  # mapped already
    other = pickle.loads(pickle.dumps(grasper))
    assert other.robot.joint_names == grasper.robot.joint_names
    assert other.robot.frames == grasper.robot.frames


def test_the_key_of_a_plan_knows_hand_and_task(scene, robot, three_fingers):
    key = key_of_robot(scene)
    assert key.differs_in(key_of_robot(RobotScene.build(TASK, FREE, robot))) == ()
    other = key_of_robot(RobotScene.build(TASK, FREE, three_fingers))
    assert "hand" in key.differs_in(other)

"""Sensors, commands and records of a run, and that they cost little beside the physics."""
# pyright: reportAttributeAccessIssue=false

import pickle
from time import process_time

import mujoco
import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.grasper import replayed_plan
from handsim.grasping.rollout import _stepping
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import LearnedDriver, learned_driver
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import MAX_SPEED, diverged, simulate
from handsim.grasping.rollout.sensing import Touch
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import LOWER, UPPER
from handsim.learning.controller import GraspController
from handsim.tasks.scene import build_scene
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.build(TASK, Conditions(base="free"))


@pytest.fixture(scope="module")
def plan(controller, scene) -> GraspPlan:
    return replayed_plan(controller, scene, HandModel.from_spec(build_hand()))


@pytest.fixture(scope="module")
def driver(controller, scene, plan) -> LearnedDriver:
    return learned_driver(controller, plan, scene.lead, schedule_for(TASK))


@pytest.fixture(scope="module")
def run(scene, plan, driver) -> Rollout:
    return simulate(scene, plan, driver)


def test_a_run_counts_contacts_one_by_one_where_sensors_are_too_few(
    scene, plan, driver, run, monkeypatch
):
    exact = []

    def counted(model, data):
        exact.append(data.time)
        return Touch(np.full(6, 7.0), np.full((6, 3), 0.5), np.array(0.001))

    # As if each sensor could tell none of the contacts that it finds.
    monkeypatch.setattr(_stepping, "SLOTS", 0)
    monkeypatch.setattr(_stepping, "contacts_of", counted)
    again = simulate(scene, plan, driver)
    touched = (run.contact_force > 0).any(axis=1)
    assert touched.any()
    assert (again.contact_force[touched] == 7.0).all()
    assert (again.press[touched] == 0.5).all()
    assert (again.penetration[touched] == 0.001).all()
    assert len(exact) < len(run.time)  # not while nothing touches
    np.testing.assert_array_equal(again.qpos, run.qpos)


def test_forearms_of_many_poses_are_those_of_each_to_the_bit(scene):
    wrist, generator = Wrist(scene.hand.model), np.random.default_rng(0)
    pos, quat = generator.normal(size=(50, 3)), generator.normal(size=(50, 4))
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    q = generator.uniform(LOWER, UPPER, (50, 22))
    q[0] = 0.0
    places, turns = wrist.forearm(pos, quat, q)
    rows = wrist.forearm(pos.reshape(5, 10, 3), quat.reshape(5, 10, 4), q.reshape(5, 10, 22))
    np.testing.assert_array_equal(rows[0].reshape(50, 3), places)
    np.testing.assert_array_equal(rows[1].reshape(50, 4), turns)
    for i in range(50):
        place, turn = wrist.forearm(pos[i], quat[i], q[i])
        np.testing.assert_array_equal(places[i], place)
        np.testing.assert_array_equal(turns[i], turn)
        place, turn = wrist.forearm(pos[[i]], quat[[i]], q[[i]])
        np.testing.assert_array_equal(places[[i]], place)
        np.testing.assert_array_equal(turns[[i]], turn)


def test_noise_drawn_before_is_that_of_reading_after_reading(scene, plan):
    glove, schedule = DataGlove(), schedule_for(TASK)
    commands = Commands.of(plan, TASK, schedule).disturbed(Conditions(seed=5), glove)
    generator = np.random.default_rng(5)
    generator.uniform()  # the direction of shaking, though there is none
    q = np.linspace(0.0, 1.0, 22)
    for row in commands.disturbance[:20]:
        np.testing.assert_array_equal(glove.reading(q, row), glove.read(q, generator))


def test_the_text_of_the_model_is_made_when_wanted(scene, run):
    made = []
    given = {name: getattr(run, name) for name in run.__dataclass_fields__}
    lazy = Rollout(**given | {"model_xml": lambda: made.append(1) or "<mujoco/>"})
    assert not made
    assert lazy.model_xml == lazy.model_xml == "<mujoco/>"
    assert made == [1]
    # It is that of the scene as it is built, which has the hand's own sensors alone.
    spec = build_scene(TASK, base="free", friction=Conditions().friction)
    spec.compile()
    assert run.model_xml == spec.to_xml()
    assert pickle.loads(pickle.dumps(run)).model_xml == run.model_xml


def test_a_run_leaves_the_sensors_on_and_repeats_itself(scene, plan, driver, run):
    assert not scene.hand.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_SENSOR
    np.testing.assert_array_equal(simulate(scene, plan, driver).qpos, run.qpos)


def test_arrival_is_judged_when_the_reach_ends(scene, plan, driver, run):
    asked = []

    class Asked(LearnedDriver):
        def arrived(self, reading):
            asked.append(reading)
            return True

    parts = ("controller", "z_start", "z_goal", "timing", "lead", "reach")
    simulate(scene, plan, Asked(*(getattr(driver, part) for part in parts)))
    (row,) = np.flatnonzero(np.isclose(run.time, schedule_for(TASK).reach))
    np.testing.assert_array_equal(asked, run.reading[[row]])


def test_a_brief_run_is_the_beginning_of_a_whole_one(controller):
    """On an arm, for which the scripted palm was found, the recorded grasp holds to the end."""
    scene = Scene.build(TASK, Conditions())
    plan = replayed_plan(controller, scene, HandModel.from_spec(build_hand()))
    driver = learned_driver(controller, plan, scene.lead, schedule_for(TASK))
    run = simulate(scene, plan, driver)
    assert run.outcome.success
    np.testing.assert_array_equal(simulate(scene, plan, driver, brief=True).qpos, run.qpos)
    apart = GraspPlan(plan.palm.moved(np.array([0.0, 0.0, 0.2])), *(
        getattr(plan, name)
        for name in ("retreat", "q_start", "q_goal", "squeeze", "grip", "arrive")
    ))  # fmt: skip
    whole, brief = (simulate(scene, apart, driver, brief=each) for each in (False, True))
    n = len(brief.time)
    assert not whole.outcome.success
    assert n < len(whole.time)
    np.testing.assert_array_equal(brief.qpos, whole.qpos[:n])
    np.testing.assert_array_equal(brief.contact_force, whole.contact_force[:n])


@pytest.mark.parametrize(
    ("speed", "bad"),
    [(MAX_SPEED, False), (-1.01 * MAX_SPEED, True), (np.nan, True), (np.inf, True)],
)
def test_divergence_is_a_matter_of_speed_and_numbers(speed, bad):
    qvel, warnings = np.zeros((4, 7)), np.zeros((4, 8), dtype=np.int32)
    qvel[2, 3] = speed
    assert diverged(qvel, warnings).tolist() == [False, False, bad, False]
    warnings[1, mujoco.mjtWarning.mjWARN_BADQACC] = 1
    warnings[3, mujoco.mjtWarning.mjWARN_CONTACTFULL] = 1
    assert diverged(qvel, warnings).tolist() == [False, True, bad, False]


@pytest.mark.ci
@pytest.mark.slow
def test_what_is_not_physics_costs_little(scene, plan, driver, run):
    """Held to 1.15 by the benchmarks (`make bench`); with room here for a busy machine."""
    model = run.model()
    data = mujoco.MjData(model)

    def alone() -> float:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.ctrl[:] = run.qpos[0], run.ctrl[0]
        mujoco.mj_forward(model, data)
        start = process_time()
        for ctrl, pos, quat in zip(run.ctrl, run.mocap_pos, run.mocap_quat, strict=True):
            data.ctrl[:], data.mocap_pos[0], data.mocap_quat[0] = ctrl, pos, quat
            mujoco.mj_step(model, data, nstep=5)
        return process_time() - start

    def ours() -> float:
        start = process_time()
        simulate(scene, plan, driver)
        return process_time() - start

    def ratio() -> float:
        # The processor's speed changes within a second: neighbours are compared with each other.
        # On a shared one single ratios went from 1.0 to 1.9 round 1.26, medians of 21 of them
        # from 1.24 to 1.28.
        return float(np.median([ours() / alone() for _ in range(21)]))

    assert any(ratio() < 1.33 for _ in range(3))  # the next is measured only where one is above

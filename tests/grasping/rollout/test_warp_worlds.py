"""Runs in the worlds of mujoco_warp: what is around the worlds, and their verdicts."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.errors import InputError, MissingToolError, UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.rollout import _warp_worlds
from handsim.grasping.rollout import run as runs
from handsim.grasping.rollout.batch import grasp_batch, simulate_batch
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import ScriptedDriver
from handsim.grasping.rollout.jobs import Job
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

from .made_up_warp import Rows, ScopedCapture, as_module, capture_launch, recorded_or_made

FREE = Conditions(base="free")


@pytest.fixture
def worlds(monkeypatch):
    """The stand-in, in mujoco_warp's place."""
    made = as_module()
    monkeypatch.setitem(sys.modules, "mujoco_warp", made)
    monkeypatch.setattr(_warp_worlds, "find_spec", lambda name: name)
    return made


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


def scripted(hand: HandModel, conditions: Conditions, name: str = "cube-raise") -> Job:
    scene = Scene.build(task_by_name(name), conditions)
    plan, q_open = scripted_plan(scene.task, hand)
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, 0.3)
    schedule = schedule_for(scene.task)
    schedule = replace(schedule, steps=(0.2,) * len(schedule.steps), hold=0.1, reach=0.3)
    return Job(scene, plan, driver, schedule)


def assert_near(made, known) -> None:
    """The same run, but for single precision on the way to the worlds and back."""
    assert made.outcome.success == known.outcome.success
    assert made.outcome.reason == known.outcome.reason
    np.testing.assert_array_equal(made.time, known.time)
    np.testing.assert_allclose(made.qpos, known.qpos, atol=5e-3)


@pytest.mark.parametrize("base", ["arm", "free"])
def test_each_world_is_the_run_that_mujoco_makes(worlds, hand, base) -> None:
    """Friction, mass and place differ from world to world, and so do their gloves."""
    nominal = Conditions(base=base)
    hard = replace(nominal, seed=2, nominal=False, friction=0.5, mass_scale=1.5)
    jobs = [scripted(hand, each) for each in (nominal, hard, perturb(nominal, 3))]
    known = simulate_batch(jobs, n_threads=1)
    made = simulate_batch(jobs, device="warp")
    assert [run.conditions for run in made] == [job.scene.conditions for job in jobs]
    assert known[0].contact_force.max() > 0.5
    for run, other in zip(made, known, strict=True):
        assert_near(run, other)
    assert np.abs(made[0].qpos - made[1].qpos).max() > 1e-3
    assert np.abs(made[0].contact_force - known[0].contact_force).max() < 0.2


def test_on_a_gpu_steps_are_recorded_once_and_then_started_as_one(worlds, hand, monkeypatch):
    """What was recorded moves as the steps themselves do."""
    job = scripted(hand, FREE)
    known = simulate_batch([job], device="warp")
    started = []

    def launch(graph) -> None:
        started.append(graph)
        capture_launch(graph)

    made_up = SimpleNamespace(ScopedCapture=ScopedCapture, capture_launch=launch)
    monkeypatch.setitem(sys.modules, "warp", made_up)
    monkeypatch.setattr(Rows, "device", SimpleNamespace(is_cuda=True))
    monkeypatch.setattr(worlds, "step", recorded_or_made)
    (run,) = simulate_batch([job], device="warp")
    assert len(started) == len(run.time) - 1 > 50, "all readings but the first"
    assert all(each is started[0] for each in started)
    np.testing.assert_array_equal(run.qpos, known[0].qpos)
    np.testing.assert_array_equal(run.contact_force, known[0].contact_force)


def test_what_worlds_share_keeps_hands_of_other_sizes_and_objects_apart(worlds, hand) -> None:
    """Their runs come back in the order of the jobs all the same."""
    small = replace(FREE, hand=HandSize(0.175, 0.078))
    jobs = [scripted(hand, FREE), scripted(hand, small), scripted(hand, FREE, "mouse-slide")]
    keys = [_warp_worlds.shared_key(job.scene.hand.model) for job in jobs[:2]]
    assert keys[0] != keys[1]
    for run, other in zip(simulate_batch(jobs, device="warp"), simulate_batch(jobs), strict=True):
        assert (run.task, run.conditions) == (other.task, other.conditions)
        assert_near(run, other)


def test_a_run_for_which_there_is_no_room_is_made_by_mujoco(worlds, hand, monkeypatch) -> None:
    """That the solver stopped at its limit of iterations is no lack of room."""
    jobs = [scripted(hand, replace(FREE, seed=seed)) for seed in (0, 1)]
    assert None not in runs.run_jobs(jobs, device="warp")
    monkeypatch.setattr(_warp_worlds, "MOST_CONTACTS", 3)
    assert runs.run_jobs(jobs, device="warp") == [None, None]
    made, known = simulate_batch(jobs, device="warp"), simulate_batch(jobs)
    for run, other in zip(made, known, strict=True):
        np.testing.assert_array_equal(run.qpos, other.qpos)


@pytest.mark.parametrize("burst", ["target", "world"])
def test_one_that_diverges_ends_and_the_others_go_on(worlds, hand, monkeypatch, burst) -> None:
    jobs = [scripted(hand, replace(FREE, seed=seed)) for seed in (0, 1)]
    known = simulate_batch(jobs, device="warp")
    step, steps = worlds.step, []

    def bursting(model, data):
        step(model, data)
        steps.append(1)
        if len(steps) == 155:
            broken = data.qpos.numpy()
            broken[1, -1] = np.nan
            data.qpos.assign(broken)

    if burst == "world":
        monkeypatch.setattr(worlds, "step", bursting)
    else:
        jobs[1] = replace(jobs[1], driver=Undefined(jobs[1].driver))
    made = simulate_batch(jobs, device="warp")
    assert made[1].outcome.reason == "unstable"
    assert made[1].time[-1] == pytest.approx(0.3)
    assert np.isfinite(made[1].ctrl).all() or burst == "target"
    assert_near(made[0], known[0])


class Undefined:
    """A driver whose targets are no numbers after 0.3 s."""

    def __init__(self, driver) -> None:
        self._driver, self.name, self.reach = driver, "undefined", np.inf
        self.destination = driver.destination

    def start(self, n):
        return self._driver.start(n)

    def step(self, time, dt, reference, readings):
        target, reference = self._driver.step(min(time, 0.29), dt, reference, readings)
        return (target if time < 0.3 else np.full_like(target, np.nan)), reference

    def coordinates(self, readings):
        return self._driver.coordinates(readings)

    def arrived(self, reading):
        return True


def test_sensors_are_computed_once_a_reading_and_left_on(worlds, hand, monkeypatch) -> None:
    step, on = worlds.step, []

    def seen(model, data):
        on.append(not model.opt.disableflags & _warp_worlds.NO_SENSORS)
        step(model, data)

    monkeypatch.setattr(worlds, "step", seen)
    simulate_batch([scripted(hand, FREE)], device="warp")
    assert on == [False] * 4 + [True] + on[5:]
    assert sum(on) * 5 == len(on)


def test_what_worlds_lack_is_said_in_one_line(worlds, hand) -> None:
    job = scripted(hand, FREE)
    job.scene.model.opt.integrator = 0
    with pytest.raises(InputError, match=r"'cube-raise': mjINT_EULER is unsupported; leave out"):
        simulate_batch([job], device="warp")


def test_without_mujoco_warp_or_with_another_device_the_remedy_is_named(hand, monkeypatch) -> None:
    monkeypatch.setattr(_warp_worlds, "find_spec", lambda name: None)
    with pytest.raises(MissingToolError, match=r"pip install 'handsim\[warp\]'"):
        simulate_batch([scripted(hand, FREE)], device="warp")
    with pytest.raises(UnknownNameError, match="did you mean cpu"):
        simulate_batch([], device="cuda")


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_verdicts_of_mujoco_warp_are_those_of_mujoco(tmp_path, monkeypatch) -> None:
    """Compiling takes minutes the first time."""
    pytest.importorskip("mujoco_warp", reason="handsim[warp] is not installed")
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    nominal = Conditions()
    plan = shipped_plans(controller.digest, nominal).read()["cube-raise"]
    trials = [nominal, perturb(nominal, 1), perturb(nominal, 2)]
    task = task_by_name("cube-raise")
    known = grasp_batch(controller, task, plan, trials)
    made = grasp_batch(controller, task, plan, trials, device="warp")
    assert [run.outcome.success for run in made] == [run.outcome.success for run in known]
    assert [run.outcome.reason for run in made] == [run.outcome.reason for run in known]
    for run, other in zip(made, known, strict=True):
        assert run.outcome.lift_m == pytest.approx(other.outcome.lift_m, abs=5e-3)

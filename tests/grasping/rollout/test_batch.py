"""Runs made together are those made one by one, bit for bit."""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.grasper import replayed_plan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout import _stepping, batch, sensing
from handsim.grasping.rollout import run as runs
from handsim.grasping.rollout.batch import grasp_batch, simulate_batch
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import ScriptedDriver, learned_driver
from handsim.grasping.rollout.jobs import Job, command_key
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.grasping.rollout.sensing import SLOTS
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import N_JOINTS, UPPER
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

TASK = task_by_name("cube-raise")
FREE = Conditions(base="free")
"""Less physics than with an arm."""


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


@pytest.fixture(scope="module")
def plan(controller, hand) -> GraspPlan:
    return replayed_plan(controller, Scene.build(TASK, FREE), hand)


def assert_same(one: Rollout, other: Rollout) -> None:
    for each in fields(Rollout):
        a, b = getattr(one, each.name), getattr(other, each.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=each.name)
        else:
            assert a == b, each.name


def short(job: Job, hold: float = 0.1) -> Job:
    """The same run, with little time left after the squeeze."""
    schedule = schedule_for(job.scene.task)
    return replace(job, schedule=replace(schedule, steps=(0.2,) * len(schedule.steps), hold=hold))


def alone(job: Job) -> Rollout:
    return simulate(job.scene, job.plan, job.driver, job.glove, job.schedule)


@pytest.mark.ci
@pytest.mark.slow
def test_seeds_sizes_and_perturbations_come_out_as_one_by_one(controller, plan):
    conditions = [
        Conditions(seed=3),
        perturb(Conditions(), 1),
        Conditions(hand=HandSize(0.175, 0.078)),
        Conditions(seed=4),
        perturb(FREE, 2),
    ]
    together = grasp_batch(controller, TASK, plan, conditions, n_threads=2)
    for run, each in zip(together, conditions, strict=True):
        assert run.conditions == each
        assert_same(run, run_plan(controller, Scene.build(TASK, each), plan))
    readings = [run.reading for run in together]
    assert not np.array_equal(readings[0], readings[3])  # of the same scene, but another seed


def scripted(name: str, hand: HandModel, reach: float, **conditions) -> Job:
    scene = Scene.build(task_by_name(name), replace(FREE, **conditions))
    plan, q_open = scripted_plan(scene.task, hand)
    driver = ScriptedDriver(plan.q_start, q_open, plan.q_goal, reach)
    job = short(Job(scene, plan, driver))
    assert job.schedule is not None
    return replace(job, schedule=replace(job.schedule, reach=reach))


def test_tasks_of_any_shape_and_runs_of_any_length_go_together(hand):
    jobs = [
        scripted("cube-raise", hand, 0.3),
        scripted("mouse-slide", hand, 0.3),  # another shape, by itself
        scripted("cube-raise", hand, 0.45, seed=1),  # longer
        scripted("cube-raise", hand, 0.2, seed=2),
    ]
    together = simulate_batch(jobs, n_threads=1)
    assert [run.task for run in together] == [job.scene.task.name for job in jobs]
    assert len({len(run.time) for run in together}) > 1
    for run, job in zip(together, jobs, strict=True):
        assert_same(run, alone(job))


@pytest.mark.parametrize("base", ["arm", "free"])
def test_gloves_that_are_late_and_lossy_come_out_as_one_by_one(hand, base):
    """Two share a driver, but lose other readings and grip otherwise; a third is not late."""
    first = scripted("cube-raise", hand, 0.3, base=base)
    given = {"bias": 0.05, "drift": 0.02, "lost": 0.3, "shake": 2.0, "base": base}
    conditions = [
        Conditions(seed=seed, latency=late, **given) for seed, late in enumerate((0.03, 0.03, 0.0))
    ]
    jobs = [
        replace(
            first,
            scene=replace(first.scene, conditions=each),
            plan=replace(first.plan, grip=2.0 + 3.0 * each.seed),
        )
        for each in conditions
    ]
    keys = [command_key(job) for job in jobs]
    assert keys[0] == keys[1] != keys[2]
    together = simulate_batch(jobs, n_threads=1)
    for run, job in zip(together, jobs, strict=True):
        assert_same(run, alone(job))
    assert not np.array_equal(together[0].qpos, together[1].qpos)


def test_commands_stay_within_the_ranges_together_as_alone(hand):
    """A squeeze that asks for far more than fingers can bend, of hands that touch nothing."""
    jobs = [scripted("cube-raise", hand, 0.2, seed=seed) for seed in range(2)]
    high = np.array([0.0, 0.0, 0.3])
    jobs = [
        replace(
            job,
            driver=jobs[0].driver,  # so that they are commanded together
            plan=replace(job.plan, squeeze=8.0, palm=job.plan.palm.moved(high)),
        )
        for job in jobs
    ]
    assert command_key(jobs[0]) == command_key(jobs[1])
    for run, job in zip(simulate_batch(jobs, n_threads=1), jobs, strict=True):
        ctrl = run.ctrl[:, job.scene.hand.ctrl_index]
        assert (ctrl <= UPPER).all()
        assert (ctrl[-1] == UPPER).sum() > 3
        assert_same(run, alone(job))


def test_the_number_of_threads_changes_nothing(controller, plan):
    conditions = [replace(FREE, seed=seed) for seed in range(3)]
    one, many = (
        simulate_batch([short(job) for job in jobs_of(controller, plan, conditions)], n)
        for n in (1, 3)
    )
    for a, b in zip(one, many, strict=True):
        assert_same(a, b)


def jobs_of(controller, plan, conditions) -> list[Job]:
    scene = Scene.build(TASK, FREE)
    driver = learned_driver(controller, plan, scene.lead, schedule_for(scene.task))
    return [Job(replace(scene, conditions=each), plan, driver) for each in conditions]


@dataclass(frozen=True)
class Bursting:
    """Holds still until its target is no number."""

    burst: float
    name: str = "bursting"
    reach: float = np.inf

    @property
    def destination(self):
        return np.zeros(N_JOINTS)

    def start(self, n):
        return np.empty((n, 0))

    def step(self, time, dt, reference, readings):
        return np.full(readings.shape, np.nan if time >= self.burst else 0.0), reference

    def coordinates(self, readings):
        return readings[:, :0]

    def arrived(self, reading):
        return True


def test_one_that_diverges_ends_by_itself(controller, plan, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    sound, other = jobs_of(controller, plan, [FREE, replace(FREE, seed=1)])
    jobs = [short(sound), short(replace(other, driver=Bursting(0.31))), short(other)]
    together = simulate_batch(jobs, n_threads=1)
    assert [run.outcome.reason == "unstable" for run in together] == [False, True, False]
    assert together[1].time[-1] == pytest.approx(0.31)
    for run, job in zip(together, jobs, strict=True):
        assert_same(run, alone(job))
    # MuJoCo would tell the terminal, and a log file in whatever folder one happens to be in.
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_more_contacts_than_sensors_can_tell_are_counted_one_by_one(controller, plan, monkeypatch):
    conditions = [FREE, replace(FREE, seed=1)]
    jobs = [short(job) for job in jobs_of(controller, plan, conditions)]
    expected = simulate_batch(jobs, n_threads=1)
    assert expected[0].contact_force.max() > 0
    # A batch's contact forces are spoiled and its sensors said to have too few slots: runs by
    # themselves put it right.
    monkeypatch.setattr(runs.Runs, "check", spoiled(runs.Runs.check))
    for run, known in zip(simulate_batch(jobs, n_threads=1), expected, strict=True):
        assert_same(run, known)


def spoiled(check):
    def checked(self, start, stop):
        check(self, start, stop)
        if len(self.jobs) > 1:
            self.samples["contact_force"][:] = -1.0
            self.uncounted[:] = True

    return checked


@pytest.mark.parametrize("slots", [0, SLOTS])
def test_a_batch_leaves_out_runs_with_too_many_contacts_alone(controller, plan, monkeypatch, slots):
    """As if each sensor had no slots: both runs touch the object, the second once it is read."""
    monkeypatch.setattr(sensing.Sensors, "contacts", with_slots(sensing.Sensors.contacts, slots))
    near, other = (short(j) for j in jobs_of(controller, plan, [FREE, replace(FREE, seed=1)]))
    far = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.3])))
    made = runs.run_jobs([near, replace(other, plan=far)])
    assert [run is None for run in made] == [slots == 0, False]


def with_slots(contacts, slots):
    def counted(self, values):
        touch, _ = contacts(self, values)
        return touch, self.n_contacts(values).max(axis=-1) > slots

    return counted


def test_runs_of_a_batch_end_when_their_object_is_lost_as_alone(controller, plan):
    """The first holds, the others reach too high; the last of them is another driver's."""
    apart = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.2])))
    conditions = [FREE, replace(FREE, seed=1)]
    held, lost = (short(job, 0.4) for job in jobs_of(controller, plan, conditions))
    lost = replace(lost, plan=apart)
    driver = ScriptedDriver(plan.q_start, plan.q_start, plan.q_goal, 1.2)
    jobs = [held, lost, replace(lost, driver=driver)]
    together = runs.run_jobs(jobs, brief=True)
    lengths = [len(run.time) for run in together]
    assert lengths[1] < lengths[0] > lengths[2]
    for run, job in zip(together, jobs, strict=True):
        assert_same(
            run, simulate(job.scene, job.plan, job.driver, job.glove, job.schedule, brief=True)
        )


def test_without_batches_in_mujoco_runs_are_made_one_by_one(controller, plan, monkeypatch):
    jobs = [short(job) for job in jobs_of(controller, plan, [FREE, replace(FREE, seed=1)])]
    expected = simulate_batch(jobs, n_threads=1)
    monkeypatch.setattr(batch, "find_spec", lambda name: None)
    monkeypatch.setattr(_stepping, "BatchOfSimulations", None)
    for run, known in zip(simulate_batch(jobs, n_threads=1), expected, strict=True):
        assert_same(run, known)


def test_nothing_to_do():
    assert simulate_batch([]) == []

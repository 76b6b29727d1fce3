"""What grasps, pictures and starting cost beside MuJoCo and Python alone; run by `make bench`.

A run is held against a bare loop that gives the same commands to the same scene: a copy of its
model, with all sensors of the hand. The bars are ratios of CPU time within one run, the best of
several rounds taken in turns: other work on the machine disturbs that less than the clock.
"""
# pyright: reportAttributeAccessIssue=false

import subprocess
import sys
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from time import process_time

import mujoco
import numpy as np
import pytest
from mujoco.batch import Batch

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.planning.grasper import replayed_plan
from handsim.grasping.planning.plan_store import plan_store
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.batch import grasp_batch
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import LearnedDriver, learned_driver
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.learning.transport.stored import shipped_transport
from handsim.tasks.table_one import task_by_name

pytestmark = pytest.mark.slow

STEPS = 5
"""Between two readings."""
SEEDS, THREADS = 64, 2
ALIKE = 1e-9
"""How near the bare loop comes to the same end [m or rad]."""
TASKS = ("cube-raise", "pen-write", "tall-glass-drink")
"""A scene of usual cost, the cheapest one and one of the dearest."""


@dataclass
class Setting:
    """A task that is about to be grasped, and the record of having done so."""

    name: str
    scene: Scene
    plan: GraspPlan
    driver: LearnedDriver
    run: Rollout
    model: mujoco.MjModel

    def ours(self) -> Rollout:
        return simulate(self.scene, self.plan, self.driver)

    def alone(self) -> np.ndarray:
        """The same commands to the same scene, and nothing else; the last positions."""
        model, run, data = self.model, self.run, mujoco.MjData(self.model)
        data.qpos[:], data.ctrl[:] = run.qpos[0], run.ctrl[0]
        mujoco.mj_forward(model, data)
        for ctrl, pos, quat in zip(run.ctrl, run.mocap_pos, run.mocap_quat, strict=True):
            before = data.qpos.copy()
            data.ctrl[:] = ctrl
            if model.nmocap:  # a free hand's forearm
                data.mocap_pos[0], data.mocap_quat[0] = pos, quat
            mujoco.mj_step(model, data, nstep=STEPS)
        return before


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module", params=TASKS)
def setting(controller: GraspController, request: pytest.FixtureRequest) -> Setting:
    return set_up(controller, request.param)


def set_up(controller: GraspController, name: str) -> Setting:
    scene = Scene.build(task_by_name(name), Conditions())
    store = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    plan = store.read().get(name)
    if plan is None:  # as while the plans are made anew
        plan = replayed_plan(controller, scene, HandModel.from_spec(build_hand()))
    plan = replace(plan, transport=shipped_transport())
    driver = learned_driver(controller, plan, scene.lead, schedule_for(scene.task))
    run = simulate(scene, plan, driver)
    return Setting(name, scene, plan, driver, run, copy(scene.hand.model))


def cost(work: Callable[[], object]) -> float:
    start = process_time()
    work()
    return process_time() - start


def cheapest(*works: Callable[[], object], rounds: int) -> list[float]:
    """CPU seconds of the best round of each [s], in turns."""
    costs = [[cost(work) for work in works] for _ in range(rounds)]
    return [min(column) for column in zip(*costs, strict=True)]


# Beside each other, for the record.


def test_a_run(benchmark, setting):
    assert len(benchmark.pedantic(setting.ours, rounds=5).time) > 100


def test_the_same_commands_to_mujoco_alone(benchmark, setting):
    end = benchmark.pedantic(setting.alone, rounds=5)
    hand = setting.scene.hand.qpos_index
    np.testing.assert_allclose(end[hand], setting.run.qpos[-1][hand], atol=ALIKE)


def test_a_run_with_its_time_law(benchmark, controller, setting):
    benchmark.pedantic(run_plan, (controller, setting.scene, setting.plan), rounds=5)


def test_building_a_scene(benchmark, setting):
    benchmark.pedantic(Scene.build, (setting.scene.task, Conditions()), rounds=5)


def test_the_text_of_a_scene(benchmark, setting):
    benchmark.pedantic(setting.scene.xml, rounds=5)


def test_a_batch_of_seeds(benchmark, controller):
    ours, _ = batches(set_up(controller, "cube-raise"), controller)
    assert len(benchmark.pedantic(ours, rounds=2)) == SEEDS


def test_the_same_batch_by_mujoco_alone(benchmark, controller):
    _, alone = batches(set_up(controller, "cube-raise"), controller)
    benchmark.pedantic(alone, rounds=2)


@pytest.mark.parametrize(
    "code",
    ["pass", "import handsim", "from handsim.cli import main; main()"],
    ids=["python", "import", "help"],
)
def test_starting(benchmark, code):
    command = [sys.executable, "-c", code, *(["--help"] if "main" in code else [])]
    benchmark.pedantic(
        subprocess.run, (command,), {"check": True, "capture_output": True}, rounds=5
    )


# The bars.


def batches(
    setting: Setting, controller: GraspController
) -> tuple[Callable[[], list[Rollout]], Callable[[], np.ndarray]]:
    """Grasps under many seeds, and MuJoCo's batch with the same commands."""
    conditions = [Conditions(seed=seed) for seed in range(SEEDS)]

    def ours() -> list[Rollout]:
        return grasp_batch(controller, setting.scene.task, setting.plan, conditions, THREADS)

    runs = ours()
    ctrl = np.stack([run.ctrl for run in runs])
    pos = np.stack([run.mocap_pos for run in runs])
    quat = np.stack([run.mocap_quat for run in runs])

    def alone() -> np.ndarray:
        batch = Batch(setting.model, SEEDS, THREADS)
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        batch.bind("qpos")[:] = np.stack([run.qpos[0] for run in runs])
        batch.bind("ctrl")[:] = ctrl[:, 0]
        batch.forward()
        for tick in range(ctrl.shape[1]):
            before = batch.bind("qpos").copy()
            batch.bind("ctrl")[:] = ctrl[:, tick]
            if setting.model.nmocap:
                batch.bind("mocap_pos")[:, 0] = pos[:, tick]
                batch.bind("mocap_quat")[:, 0] = quat[:, tick]
            batch.step(nstep=STEPS)
        return before

    apart = np.abs(alone() - np.stack([run.qpos[-1] for run in runs])).max(axis=1)
    assert np.median(apart) < ALIKE  # a seed whose object slides may end elsewhere
    return ours, alone


def test_a_run_costs_little_more_than_its_steps(setting):
    ours, alone = cheapest(setting.ours, setting.alone, rounds=15)
    print(f"{setting.name}: {ours / alone:.3f} x {1e3 * alone:.0f} ms")
    assert ours / alone <= 1.15


def test_a_batch_has_nine_tenths_of_the_throughput_of_mujocos(controller):
    ours, alone = cheapest(*batches(set_up(controller, "cube-raise"), controller), rounds=4)
    print(f"throughput of {SEEDS} seeds on {THREADS} threads: {alone / ours:.3f} of MuJoCo's alone")
    assert alone / ours >= 0.9


def test_help_is_there_in_half_a_second():
    """CPU seconds of the whole process."""
    code = (
        "import time, resource, sys\n"
        "from handsim.cli import main\n"
        "try:\n    main()\n"
        "except SystemExit:\n    pass\n"
        "used = resource.getrusage(resource.RUSAGE_SELF)\n"
        "print('CPU', used.ru_utime + used.ru_stime)\n"
    )
    command = [sys.executable, "-c", code, "--help"]
    costs = []
    for _ in range(5):
        told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        costs.append(float(told.rpartition("CPU ")[2]))
    print(f"handsim --help: {min(costs):.2f} s")
    assert min(costs) <= 0.5

"""Speeds that bear on use, each beside its yardstick; run by `make bench`."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from handsim.files import data_folder
from handsim.hand.tasks import task_by_name
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_controller
from handsim.motion.recording import read_recordings
from handsim.simulation.closed_loop import Stage
from handsim.simulation.conditions import Conditions
from handsim.simulation.grasping import ControllerGrasper
from handsim.simulation.plan import schedule_for

pytestmark = pytest.mark.slow

TASK = task_by_name("cube-raise")


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


def test_velocity_at_one_point(benchmark, controller):
    goal = controller.demonstrations[0]
    velocity = benchmark(controller.velocity, goal.z_start, goal.z_goal)
    assert np.isfinite(velocity).all()


def test_value_and_gradient_of_the_same_spline_by_scipy(benchmark, controller):
    spline = controller.navigation.obstacle.chi
    scipys = NdBSpline(spline.basis.knots, spline.coefficients, spline.basis.degree)
    point = controller.demonstrations[0].z_start[None]
    orders = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    parts = benchmark(lambda: [scipys(point, nu=order)[0] for order in orders])
    ours = spline.jet(point[0], 1)
    np.testing.assert_allclose(parts[0], ours[0], rtol=1e-9)


def test_directions_at_100_000_points(benchmark, controller):
    goal = controller.demonstrations[0]
    points = np.random.default_rng(0).normal(goal.z_goal, 0.3, (100_000, 3))
    directions = benchmark(controller.navigation.directions, points, goal.z_goal)
    assert directions.shape == points.shape


def test_learning_the_built_in_experiments(benchmark):
    recordings = read_recordings(Path(data_folder("assets")) / "experiments")
    learned = benchmark.pedantic(learn_controller, (recordings,), rounds=3)
    assert learned.summary["n_recordings"] == len(recordings)


def test_a_grasp_with_the_controller(benchmark, controller):
    grasp = ControllerGrasper(controller, "replay")
    rollout = benchmark.pedantic(grasp, (TASK, Conditions()), rounds=3)
    assert len(rollout.time) > 100


def test_as_many_steps_of_the_same_scene_by_mujoco_alone(benchmark):
    stage = Stage.build(TASK, Conditions())
    model, data = stage.hand.model, stage.hand.data
    steps = round(schedule_for(TASK).end / model.opt.timestep)

    def run() -> None:
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data, nstep=steps)

    benchmark.pedantic(run, rounds=3)
    assert data.time > 1.0

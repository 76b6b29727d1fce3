"""Runs made together are those made one by one, bit for bit."""

from dataclasses import fields

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.hand.model import HandModel, build_hand
from handsim.hand.tasks import task_by_name
from handsim.learning.controller import GraspController
from handsim.simulation.batch import grasp_batch
from handsim.simulation.conditions import Conditions, perturb
from handsim.simulation.planner import replayed_plan, run_plan
from handsim.simulation.rollout import Rollout
from handsim.simulation.stage import Stage

TASK = task_by_name("cube-raise")


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


def assert_same(one: Rollout, other: Rollout) -> None:
    for each in fields(Rollout):
        a, b = getattr(one, each.name), getattr(other, each.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=each.name)
        else:
            assert a == b, each.name


def test_seeds_sizes_and_perturbations_come_out_as_one_by_one(controller):
    conditions = [
        Conditions(seed=3),
        perturb(Conditions(), 1),
        Conditions(hand_length=0.175, hand_breadth=0.078),
        Conditions(seed=4),
        perturb(Conditions(), 2),
    ]
    plan = replayed_plan(
        controller, Stage.build(TASK, Conditions()), HandModel.from_spec(build_hand())
    )
    together = grasp_batch(controller, TASK, plan, conditions, n_threads=2)
    for run, each in zip(together, conditions, strict=True):
        assert run.conditions == each
        assert_same(run, run_plan(controller, Stage.build(TASK, each), plan))

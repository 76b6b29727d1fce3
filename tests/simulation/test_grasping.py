"""What grasps, and what it remembers."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.files import data_folder
from handsim.hand.tasks import task_by_name
from handsim.learning.controller import GraspController
from handsim.motion.recording import Recording, RecordingSet
from handsim.simulation import grasping
from handsim.simulation.conditions import Conditions
from handsim.simulation.grasping import ControllerGrasper, trial_conditions, without_object
from handsim.simulation.plan_store import PlanStore, plan_key


def test_an_object_is_left_out_with_all_its_recordings():
    time = np.arange(20) / 100
    q = np.linspace(0, 1, 20)[:, None] * np.ones(22)
    recordings = RecordingSet(
        tuple(
            Recording(
                name=f"r{i}",
                time=time,
                q=q,
                number=i,
                object=name,
                task="t",
                subject="s",
                hand_length=0.19,
                hand_breadth=0.09,
            )
            for i, name in enumerate(["cube", "jar", "cube"], start=1)
        )
    )
    assert [r.name for r in without_object(recordings, "cube")] == ["r2"]
    with pytest.raises(InputError, match="no recordings"):
        without_object(without_object(recordings, "cube"), "jar")


def test_trials_have_the_seeds_that_follow():
    usual = Conditions(seed=7, hand_length=0.18)
    nominal, *trials = trial_conditions(usual, 2)
    assert nominal == usual
    assert [each.seed for each in trials] == [8, 9]
    assert not any(each.nominal for each in trials)
    assert {each.hand_length for each in trials} == {0.18}


def test_the_first_grasp_by_a_new_plan_is_the_same_as_all_later_ones(tmp_path, monkeypatch):
    """Plans are kept in degrees, and what comes back differs in the last bit."""
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    task = task_by_name("cube-raise")
    built_in = data_folder("assets") / "plans" / f"{plan_key(controller.digest, Conditions())}.json"
    known = PlanStore(built_in).read()["cube-raise"]
    plan = replace(known, q_goal=known.q_goal * (1 + np.linspace(0, 1e-6, 22)))
    assert np.any(np.deg2rad(np.rad2deg(plan.q_goal)) != plan.q_goal)
    grasper = ControllerGrasper(controller, store=PlanStore(tmp_path / "plans.json"))
    planned = []

    def quickly(controller, task, conditions, known):
        planned.append(task.name)
        run = grasping.run_plan(controller, grasping.Stage.build(task, conditions), plan)
        return plan, run

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    stage = grasping.Stage.build(task, Conditions())
    first, second = (grasper.plan_for(task, stage) for _ in range(2))
    assert planned == ["cube-raise"]
    assert first.q_goal.tobytes() == second.q_goal.tobytes() != plan.q_goal.tobytes()


def test_errors_come_through_from_other_processes():
    error = UnknownNameError("task", "cube-rase", ("cube-raise",))
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)
    assert copy.known == error.known

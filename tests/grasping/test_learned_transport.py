"""The palm comes in as was learned from recorded reaches, and ends where the plan says."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.rollout.commands import Commands, expected_path
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.kinematics import Kinematics
from handsim.learning.controller import GraspController
from handsim.learning.transport.recorded import recorded_transport
from handsim.navigation.flow import FlowPath
from handsim.recordings.folder import read_recordings
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import HandSize

TASK = task_by_name("tall-glass-side-move")


@pytest.fixture(scope="module")
def transport():
    return recorded_transport(read_recordings(data_folder("assets") / "people" / "pillow"))


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def plans(controller):
    return shipped_plans(controller.digest, Conditions()).read()


def paths(plan, task, transport):
    schedule = schedule_for(task)
    usual = Commands.of(plan, task, schedule)
    return usual, Commands.of(replace(plan, transport=transport), task, schedule)


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_it_starts_and_ends_as_a_straight_reach_and_is_the_same_after_it(plans, transport, task):
    straight, learned = paths(plans[task.name], task, transport)
    placed = round(plans[task.name].arrive * straight.schedule.reach * 100) + 1
    np.testing.assert_allclose(learned.palm_pos[0], straight.palm_pos[0], atol=1e-12)
    np.testing.assert_allclose(learned.palm_pos[placed:], straight.palm_pos[placed:], atol=1e-12)
    np.testing.assert_array_equal(learned.palm_quat, straight.palm_quat)
    apart = np.linalg.norm(learned.palm_pos - straight.palm_pos, axis=1).max()
    assert 0.003 < apart < 0.06  # of 160 mm
    speed = 100 * np.linalg.norm(np.diff(learned.palm_pos[: placed + 1], axis=0), axis=1)
    assert speed.max() < 0.8
    assert learned.palm_pos[:placed, 2].min() > 0.0


def test_it_comes_in_as_the_transport_says_with_the_table_kept_off(plans, transport):
    plan = replace(plans[TASK.name], transport=transport)
    path = expected_path(plan, TASK, schedule_for(TASK))
    made = path.learned_reach
    assert made.proved
    assert made.n_walls == 1
    times = np.array([0.1, 0.3, 0.5])
    np.testing.assert_allclose(path.poses(times)[0], made.at(times))
    assert made.law.duration == pytest.approx(plan.arrive * 1.2)


def test_runs_by_one_plan_have_its_reach_in_common(plans, transport, monkeypatch):
    plan = replace(plans[TASK.name], transport=replace(transport, duration=1.01))
    asked, reach = [], type(transport).reach

    def counted(*given):
        asked.append(given)
        return reach(*given)

    monkeypatch.setattr(type(transport), "reach", counted)
    for same in (plan, replace(plan, transport=replace(transport, duration=1.01))):
        expected_path(same, TASK, schedule_for(TASK)).poses(np.zeros(1))
    assert len(asked) == 1
    later = replace(plan, arrive=0.9 * plan.arrive)
    expected_path(later, TASK, schedule_for(TASK)).poses(np.zeros(1))
    assert len(asked) == 2


def test_a_flow_that_does_not_arrive_is_refused(plans, transport, monkeypatch):
    plan = replace(plans[TASK.name], transport=replace(transport, duration=1.02))
    path = expected_path(plan, TASK, schedule_for(TASK))
    stuck = replace(path.learned_reach, path=FlowPath(np.zeros((2, 3)), False, "a minimum"))
    monkeypatch.setattr(type(transport), "reach", lambda *_, **__: stuck)
    other = replace(plan, transport=replace(transport, duration=1.03))
    again = expected_path(other, TASK, schedule_for(TASK))
    with pytest.raises(InputError, match=r"palm to tall-glass-side-move \(a minimum\); let it go"):
        again.poses(np.zeros(1))


def test_a_grasper_carries_every_plan_so_for_its_side(controller, plans, transport):
    shared = (shipped_plans(controller.digest, Conditions()),)
    grasper = ControllerGrasper(controller, shared=shared)
    assert grasper.transport == transport
    scene = Scene.build(TASK, Conditions())
    assert grasper.plan_for(TASK, scene).transport.n_reaches == 20
    assert not grasper.plan_for(TASK, scene).transport.mirrored
    found, missing = grasper.look_up_all([TASK], Conditions())
    assert found[TASK.name].transport is not None and missing == []
    replayed = replace(grasper, mode="replay").plan_for(TASK, scene)
    assert replayed.transport is not None
    left = grasper._carried(plans[TASK.name], Conditions(hand=HandSize(side="left")))
    assert left.transport.mirrored
    assert replace(grasper, transport=None).plan_for(TASK, scene).transport is None


@pytest.mark.parametrize("name", ["tall-glass-top-move", "cup-top-move", "cup-side-move"])
def test_the_hand_is_widest_at_about_two_thirds_of_the_transport(controller, name):
    """It opens to the posture that the subspace has for a start while the palm comes in."""
    task, shared = task_by_name(name), (shipped_plans(controller.digest, Conditions()),)
    grasper = ControllerGrasper(controller, shared=shared)
    run = grasper(task, Conditions(seed=5001))
    plan = grasper.plan_for(task, Scene.build(task, Conditions()))
    coming = run.time <= plan.arrive * 1.2
    aperture = Kinematics().aperture(run.reading[coming])
    assert aperture.max() > aperture[0] + 0.015
    assert 0.55 < run.time[aperture.argmax()] / (plan.arrive * 1.2) < 0.85
    assert np.abs(np.diff(aperture)).max() < 0.006, "at a reading: it does not spring"


@pytest.mark.ci
def test_the_glass_is_held(controller):
    shared = (shipped_plans(controller.digest, Conditions()),)
    usual = ControllerGrasper(controller, shared=shared)
    straight = replace(usual, transport=None)
    run = usual(TASK, Conditions())
    assert run.outcome.success
    other = straight(TASK, Conditions())
    assert np.abs(run.qpos - other.qpos).max() > 0.002

"""What a run is commanded, when it is given up, and when it has diverged."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import Schedule
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.rollout import run as closed_loop
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.run import diverged, run_alone, steps_per_reading
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")
SCHEDULE = Schedule(steps=(0.1,), hold=0.4, reach=0.05, squeeze=0.05)
"""Sixty-one readings: reach, squeeze, lift and a hold that is shaken."""


class Asking:
    """A driver that keeps what it is asked and follows what it reads."""

    name, reach = "asking", SCHEDULE.reach

    def __init__(self):
        self.asked = []

    def targets(self, time, reading):
        self.asked.append((time, reading))
        return reading

    def coordinates(self, reading):
        return reading[..., :0]

    def arrived(self, reading):
        return True


@pytest.fixture(scope="module")
def made():
    """A short run that is shaken, its commands, scene and driver."""
    scene = Scene.build(TASK, Conditions(seed=6, shake=3.0))
    plan, _ = scripted_plan(TASK, HandModel.from_spec(build_hand()))
    # Far from the object, so that nothing touches.
    plan = replace(plan, palm=plan.palm.moved(np.array([0.0, 0.0, 0.3])))
    driver = Asking()
    run = run_alone(scene, plan, driver, DataGlove(), SCHEDULE)
    commands = Commands.of(plan, TASK, SCHEDULE).disturbed(scene.conditions, DataGlove())
    return SimpleNamespace(run=run, commands=commands, scene=scene, driver=driver, plan=plan)


def test_a_hand_is_shaken_as_its_conditions_say(made):
    """Commanded forearm poses are those of the shaken palm, and so is the forearm itself."""
    still = Commands.of(made.plan, TASK, SCHEDULE)
    shaking = made.commands.palm_pos - still.palm_pos
    assert np.linalg.norm(shaking[20:], axis=1).max() > 0.005
    wrist = Wrist(made.scene.hand.model)
    ctrl = made.run.ctrl[:, made.scene.hand.ctrl_index]
    pos, _ = wrist.forearms(made.commands.palm_pos, made.commands.palm_quat, ctrl)
    np.testing.assert_allclose(made.run.mocap_pos, pos, atol=1e-12)
    free = int(made.scene.hand.model.joint("forearm").qposadr[0])
    way = made.run.qpos[40:, free : free + 2] - made.run.qpos[39, free : free + 2]
    asked = shaking[40:, :2] - shaking[39, :2]
    assert np.abs(way - asked).max() < 0.3 * np.abs(asked).max()


def test_commands_are_targets_with_the_squeeze_added(made):
    ctrl = made.run.ctrl[:, made.scene.hand.ctrl_index]
    for tick in range(6):
        targets = made.driver.asked[tick][1]
        np.testing.assert_array_equal(ctrl[tick], made.commands.commanded(targets, tick))
    last = made.driver.asked[-1][1]
    np.testing.assert_array_equal(ctrl[6:], made.commands.commanded(last, slice(6, None)))
    assert (made.commands.added[-1] > 0).sum() == 11


def test_the_driver_is_asked_at_every_reading_of_the_reach_and_once_after(made):
    times = [time for time, _ in made.driver.asked]
    np.testing.assert_allclose(times, np.arange(7) / 100)
    for tick, (_, reading) in enumerate(made.driver.asked):
        np.testing.assert_array_equal(reading, made.run.reading[tick])


def test_a_run_begins_as_its_plan_says_and_lasts_as_long(made):
    assert len(made.run.time) == 61
    np.testing.assert_array_equal(made.run.qpos[0, made.scene.hand.qpos_index], made.plan.q_start)
    assert not made.run.qvel[0].any()
    assert made.run.outcome.reason == "missed"


def test_five_steps_are_made_between_readings(made):
    model = made.scene.hand.model
    assert model.opt.timestep == 0.002
    assert steps_per_reading(model) == 5
    assert made.scene.hand.data.time == pytest.approx(0.61)


def lost(tick=50, rise=0.0, palm=0.1, lift=0.1):
    """Whether a run is lost whose object has risen by ``rise`` while the palm rose."""
    run = SimpleNamespace(
        scene=SimpleNamespace(task=SimpleNamespace(rule=SimpleNamespace(lift=lift))),
        commands=SimpleNamespace(lift=np.where(np.arange(100) == tick, palm, -np.inf)),
        height=np.array([0.3 + rise]),
        first_height=0.3,
    )
    return closed_loop._Run.lost(run, tick)


def test_an_object_is_lost_that_stays_behind_the_palm():
    assert lost()
    assert lost(rise=0.0199)
    assert not lost(rise=0.0201)
    assert lost(palm=0.04)
    assert not lost(palm=0.0399)
    assert not lost(palm=-np.inf)  # the action has not begun
    assert not lost(lift=0.0)  # what is not to be lifted
    assert not lost(lift=0.0199)
    assert lost(lift=0.02)


def looked_at(first_bad, looks=(4, 9)):
    """What looks at the end of some readings say of a run of ten."""
    after, warned = np.zeros((10, 7)), np.zeros((10, 8), dtype=np.int32)
    if first_bad is not None:
        after[first_bad:, 2] = np.nan
    run = SimpleNamespace(after=after, warned=warned, n_looked_at=0)
    return [closed_loop._Run.first_diverged(run, tick) for tick in looks]


def test_the_first_reading_after_which_a_run_diverged_is_found():
    assert looked_at(None) == [None, None]
    assert looked_at(0) == [0, 5]
    assert looked_at(4)[0] == 4
    assert looked_at(5) == [None, 5]
    assert looked_at(9) == [None, 9]


@pytest.mark.parametrize("kind", ["BADCTRL", "BADQPOS", "BADQVEL", "BADQACC"])
def test_each_warning_of_bad_numbers_is_divergence(kind):
    warnings = np.zeros((2, 8), dtype=np.int32)
    warnings[1, getattr(mujoco.mjtWarning, f"mjWARN_{kind}")] = 3
    assert diverged(np.zeros((2, 4)), warnings).tolist() == [False, True]


def test_speed_counts_either_way_up_to_500():
    qvel = np.array([[0, 500.0], [0, -500.0], [500.1, 0], [0, -500.1], [np.nan, 0]])
    none = np.zeros((5, 8), dtype=np.int32)
    assert diverged(qvel, none).tolist() == [False, False, True, True, True]


@pytest.mark.parametrize("bad", [0, 7, 24, 25, 55, 60])
def test_a_run_that_diverges_ends_with_the_reading_before(made, monkeypatch, bad):
    """As if the velocities after reading ``bad`` were no numbers."""
    unstable, calls = [], []

    def from_bad(qvel, warnings):
        calls.append(len(qvel))
        rows = np.arange(sum(calls[:-1]), sum(calls))
        return rows >= bad

    def told(scene, commands, driver, glove, samples, *, unstable):
        return len(samples["qpos"]), unstable

    monkeypatch.setattr(closed_loop, "diverged", from_bad)
    monkeypatch.setattr(closed_loop, "record_of", told)
    n, unstable = run_alone(made.scene, made.plan, Asking(), DataGlove(), SCHEDULE)
    assert (n, unstable) == (bad + 1, True)

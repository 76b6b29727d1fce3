"""What a run is commanded, when it is given up, and when it has diverged."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout import run as runs
from handsim.grasping.rollout.commands import Commands
from handsim.grasping.rollout.forearm import Wrist
from handsim.grasping.rollout.glove import DataGlove, steps_per_reading
from handsim.grasping.rollout.jobs import Job, commands_of
from handsim.grasping.rollout.run import diverged, simulate
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.tasks.task import Step

from .short_runs import SCHEDULE, TASK, Asking, high_plan, made_with


@pytest.fixture(scope="module")
def made():
    """A short run of a free hand that is shaken."""
    return made_with(seed=6, shake=3.0, base="free")


def test_a_hand_is_shaken_as_its_conditions_say(made):
    """Commanded forearm poses are those of the shaken palm, and so is the forearm itself."""
    still = Commands.of(made.plan, TASK, SCHEDULE)
    shaking = made.commands.palm_pos - still.palm_pos
    assert np.linalg.norm(shaking[20:], axis=1).max() > 0.005
    wrist = Wrist(made.scene.hand.model)
    pos, _ = wrist.forearm(made.commands.palm_pos, made.commands.palm_quat, told(made))
    np.testing.assert_allclose(made.run.mocap_pos, pos, atol=1e-12)
    free = int(made.scene.hand.model.joint("forearm").qposadr[0])
    way = made.run.qpos[40:, free : free + 2] - made.run.qpos[39, free : free + 2]
    asked = shaking[40:, :2] - shaking[39, :2]
    assert np.abs(way - asked).max() < 0.3 * np.abs(asked).max()


def told(made) -> np.ndarray:
    """Where the driver wants the hand, (61, 22): after the reach it goes over to its end."""
    asked = np.array([each[1] for each in made.driver.asked])
    way = made.driver.destination - asked[-1]
    return np.vstack([asked, asked[-1] + made.commands.closed[6:, None] * way])


def test_commands_are_what_the_driver_wants_with_the_squeeze_added(made):
    """Fingers that have met nothing seek on once the hand has closed, at reading 10."""
    assert made.commands.closed[10] == 1.0
    sought = 0.04 * np.clip(np.arange(61) - 9, 0, 50)[:, None]
    wanted = told(made) + (made.commands.closed[:, None] + sought) * made.commands.closing
    ctrl = made.run.ctrl[:, made.scene.hand.ctrl_index]
    np.testing.assert_allclose(ctrl, np.clip(wanted, LOWER, UPPER), rtol=0, atol=1e-12)
    # Three flexions each of three fingers; of the thumb all joints, the abduction backwards.
    moved = np.flatnonzero(made.commands.closing)
    assert len(moved) == 9 + 4
    assert moved[made.commands.closing[moved] < 0].tolist() == [JOINT_INDEX["thumb_abduction"]]


def test_fingers_act_as_the_task_says():
    press = Step(0.1, flex=("index",), angle_deg=12.0)
    usual, acting = (
        made_with(replace(TASK, steps=(step,)), base="free") for step in (TASK.steps[0], press)
    )
    index = acting.scene.hand.ctrl_index[JOINT_INDEX["index_mcp"]]
    flexed = acting.run.ctrl[:, index] - usual.run.ctrl[:, index]
    np.testing.assert_allclose(flexed[:10], 0.0, atol=1e-12)
    assert np.rad2deg(flexed[20]) == pytest.approx(12.0, abs=0.5)


@pytest.mark.parametrize("late", [0.02, 0.03])
def test_a_late_glove_tells_what_was(late):
    made, delay = made_with(seed=6, base="free", latency=late), round(100 * late)
    for tick, (_, reading, *_) in enumerate(made.driver.asked):
        np.testing.assert_array_equal(reading, made.run.reading[max(tick - delay, 0)])


def test_where_a_reading_is_lost_the_one_before_is_taken():
    for late in (0, 2):
        made = made_with(seed=7, base="free", lost=0.5, latency=late / 100)
        lost = made.commands.lost[:6]
        assert lost[1:].any() and not lost[1:].all()
        measured: list[int] = []
        for tick, (_, reading, *_) in enumerate(made.driver.asked):
            measured.append(measured[-1] if measured and lost[tick] else tick)
            expected = made.run.reading[measured[max(tick - late, 0)]]
            np.testing.assert_array_equal(reading, expected)


def test_jobs_have_the_commands_of_their_own_plan_timing_and_seed(made):
    """Also where jobs share one of them, so that not all is made anew for each."""
    job = Job(made.scene, made.plan, made.driver, SCHEDULE)
    others = [
        replace(job, plan=replace(made.plan, squeeze=0.5)),
        replace(job, schedule=replace(SCHEDULE, squeeze=0.1)),
        replace(job, scene=replace(made.scene, conditions=Conditions(seed=7, base="free"))),
    ]
    for each, commands in zip([job, *others], commands_of([job, *others]), strict=True):
        expected = Commands.of(each.plan, TASK, each.schedule)
        expected = expected.disturbed(each.scene.conditions, DataGlove())
        for name in ("times", "palm_pos", "closing", "closed", "flexion", "disturbance"):
            np.testing.assert_array_equal(getattr(commands, name), getattr(expected, name))


def test_the_driver_is_asked_at_every_reading_of_the_reach(made):
    """With the reference that it gave the last time, and where it is read at once."""
    assert len(made.driver.asked) == 6
    for tick, (time, reading, dt, reference) in enumerate(made.driver.asked):
        assert time == pytest.approx(tick / 100)
        assert dt == pytest.approx(0.01)
        assert reference == tick
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


def lost(rise=0.0, palm=0.1, lift=0.1):
    """Whether the second of two runs is lost, whose object has risen by ``rise``.

    Its palm has risen by ``palm`` and the task asks for ``lift``. The first run's palm is down.
    """
    due = Commands.together([lifted(-np.inf), lifted(palm)]).due_to_rise(lift)
    made = ending(due, height=[0.5, 0.3 + rise], first=[0.5, 0.3])
    runs.Runs.end_lost(made, 50)
    assert not made.lost[0]
    assert made.ends.tolist() == [61, 51 if made.lost[1] else 61]
    assert made.end == 61
    return bool(made.lost[1])


def lifted(palm):
    """Commands of a palm that has risen at one reading."""
    lift = np.where(np.arange(61) == 50, palm, -np.inf)
    return replace(Commands.of(high_plan(), TASK, SCHEDULE), lift=lift)


def ending(due, height, first, ends=(61, 61)):
    """Runs of two jobs, as far as `end_lost` looks at them."""
    return SimpleNamespace(
        _due=due,
        _any_due=due.any(axis=1).tolist(),
        _height=np.array(height),
        _first_height=np.array(first),
        ends=np.array(ends),
        lost=np.zeros(2, dtype=bool),
        end=max(ends),
    )


def test_all_end_with_the_last_that_is_lost_and_none_ends_twice():
    made = ending(np.ones((61, 2), dtype=bool), [0.0, 0.0], [0.0, 0.0], ends=(40, 61))
    runs.Runs.end_lost(made, 50)
    assert made.lost.tolist() == [False, True]
    assert made.ends.tolist() == [40, 51]
    assert made.end == 51


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


@pytest.mark.parametrize("kind", ["BADCTRL", "BADQPOS", "BADQVEL", "BADQACC"])
def test_each_warning_of_bad_numbers_is_divergence(kind):
    warnings = np.zeros((2, 8), dtype=np.int32)
    warnings[1, getattr(mujoco.mjtWarning, f"mjWARN_{kind}")] = 3
    assert diverged(np.zeros((2, 4)), warnings).tolist() == [False, True]


def test_speed_counts_either_way_up_to_500():
    qvel = np.array([[0, 500.0], [0, -500.0], [500.1, 0], [0, -500.1], [np.nan, 0]])
    none = np.zeros((5, 8), dtype=np.int32)
    assert diverged(qvel, none).tolist() == [False, False, True, True, True]


@pytest.mark.parametrize("bad", [0, 7, 49, 50, 55, 60])
def test_a_run_that_diverges_ends_with_the_reading_before(made, monkeypatch, bad):
    """As if the velocities after reading ``bad`` were no numbers."""
    calls = []

    def from_bad(qvel, warnings):
        calls.append(len(qvel))
        rows = np.arange(sum(calls[:-1]), sum(calls))
        return rows[:, None] >= bad

    monkeypatch.setattr(runs, "diverged", from_bad)
    monkeypatch.setattr(runs, "record_of", length)
    asking = Asking()
    assert simulate(made.scene, made.plan, asking, DataGlove(), SCHEDULE) == (bad + 1, True)
    assert calls == [50, 11][: bad // 50 + 1]  # nothing is simulated after it is found


def length(scene, commands, driver, samples, *, reading, arrived, unstable):
    return len(samples["qpos"]), unstable


@pytest.mark.parametrize(("at", "unstable"), [(10, False), (49, True), (60, True)])
def test_a_run_that_is_lost_between_checks_has_not_diverged(made, monkeypatch, at, unstable):
    """Though its velocities are no numbers: they are checked at readings 49 and 60."""
    asked = []

    def due_to_rise(self, required):
        asked.append(required)
        return np.arange(61) == at

    monkeypatch.setattr(Commands, "due_to_rise", due_to_rise)
    monkeypatch.setattr(
        runs, "diverged", lambda qvel, warnings: np.full(qvel.shape[:2], len(qvel) != 50 or at < 60)
    )
    monkeypatch.setattr(runs, "record_of", length)
    n, told = simulate(made.scene, made.plan, Asking(), DataGlove(), SCHEDULE, brief=True)
    assert told is unstable
    assert n == {10: 11, 49: 1, 60: 51}[at]
    assert asked == [TASK.rule.lift]


def test_one_has_diverged_as_it_has_among_several():
    rng = np.random.default_rng(3)
    found = []
    for _ in range(200):
        qvel, warnings = rng.normal(0.0, 150.0, 8), np.zeros(7, dtype=np.int32)
        if rng.uniform() < 0.2:
            qvel[rng.integers(8)] = rng.choice([np.nan, np.inf, -np.inf, runs.MAX_SPEED])
        if rng.uniform() < 0.3:
            warnings[rng.integers(7)] = 1
        found.append(runs.has_diverged(qvel, warnings))
        assert found[-1] == runs.diverged(qvel, warnings)
    assert 20 < sum(found) < 180

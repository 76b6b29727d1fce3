"""Options of `handsim grasp` beside the usual ones."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from handsim.cli import defaults
from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, made_hard
from handsim.grasping.judging import protocols
from handsim.grasping.judging.six_axis import six_axis
from handsim.grasping.planning import grasper as grasping
from handsim.grasping.planning.plan_store import PlanStore
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout_file import read_rollout
from handsim.joints import CONTACT_PARTS
from handsim.learning.controller import GraspController

EXPERIMENTS = data_folder("assets") / "experiments"
CONTROLLER = data_folder("assets") / "controller.npz"


@pytest.fixture
def planned(monkeypatch):
    """Plan by taking the built-in plan, and say for which controllers that was begun."""
    built_in = defaults.planning_grasper(None, Conditions()).store.read()
    controllers, made = [], []

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        if known is None:
            controllers.append(controller)
        else:  # a plan that did not hold is the start of a further search: no other may be
            assert any(known is plan for plan in made), "nothing that has seen the object"
        plan = replace(built_in[task.name], z_goal=None)  # of another subspace
        made.append(plan)
        return plan, run_plan(controller, Scene.build(task, conditions), plan)

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    return controllers


@pytest.fixture
def begun(monkeypatch):
    """Numbers of trials that were begun; none is run."""
    numbers = []

    def judged(grasp, tasks, conditions, n_trials, **options):
        numbers.append(n_trials)
        raise InputError("begun")

    monkeypatch.setattr(protocols, "judge_runs", judged)
    return numbers


def test_six_axis_decides_and_the_hard_setting_is_told(run, tmp_path):
    said = run("grasp", "demonstrator", "--task", "jar-move", "--protocol", "six-axis",
               "--json", "-o", tmp_path).json()  # fmt: skip
    assert (said["task"], said["trials"], said["successes"]) == ("jar-move", 0, 0)
    (nominal,) = said["per_trial"]
    rollout = read_rollout(tmp_path / "jar-move.npz")
    usual, hard = six_axis(rollout), six_axis(rollout, hard=True)
    assert usual.success
    assert said["nominal_success"] is nominal["success"] is True
    assert said["nominal_hard_success"] is nominal["hard_success"] is hard.success
    assert nominal["lift_success"] is rollout.outcome.success is True
    assert nominal["epsilon"] > 0.05
    assert nominal["six_axis"]["shift_m"] == list(usual.shift_m)
    assert nominal["six_axis_hard"]["shift_m"] == list(hard.shift_m)
    assert nominal["six_axis_hard"]["reason"] == hard.reason
    assert max(hard.shift_m) > max(usual.shift_m)  # contacts creep


def test_results_say_how_the_hand_presses_and_what_carries_it(run):
    said = run("grasp", "demonstrator", "--task", "cube-raise", "--json").json()
    (nominal,) = said["per_trial"]
    assert nominal["base"] == "arm"
    assert tuple(nominal["forces_n"]) == CONTACT_PARTS
    assert nominal["margin"] == max(nominal["forces_n"].values()) / nominal["need_n"]
    assert nominal["opposed"] > 0.95
    assert nominal["table_force_n"] <= 15.0
    assert nominal["pushed_m"] <= 0.010
    assert nominal["strain"] < 2.0


def test_a_hand_that_flies_is_said_to_fly(run, tmp_path):
    asked = ("grasp", "demonstrator", "--task", "cube-raise", "--base", "free", "-o", tmp_path)
    made = run(*asked, "--json")
    assert "the hand flies" in made.err and f"wrote 1 rollout to {tmp_path}\n" in made.err
    assert made.json()["per_trial"][0]["base"] == "free"
    assert read_rollout(tmp_path / "cube-raise.npz").conditions.base == "free"
    assert "flies" not in run("grasp", "demonstrator", "--task", "cube-raise").err
    refused = run("grasp", "demonstrator", "--task", "cube-raise", "--base", "robot")
    assert refused.code == 2
    assert "--base" in refused.err


def test_the_palm_comes_in_as_in_the_reaches_that_are_shipped(run, tmp_path):
    asked = ("grasp", "--task", "cube-raise", "--json", "-o", tmp_path)
    shipped = {"recordings": "people", "n_reaches": 20, "certified": True}
    assert run(*asked).json()["transport"] == shipped
    way = read_rollout(tmp_path / "cube-raise.npz").qpos
    assert run(*asked, "--transport", "people").json()["transport"] == shipped
    np.testing.assert_array_equal(read_rollout(tmp_path / "cube-raise.npz").qpos, way)
    assert run(*asked, "--transport", "straight").json()["transport"] is None
    assert np.abs(read_rollout(tmp_path / "cube-raise.npz").qpos - way).max() > 0.002


def test_a_script_comes_in_straight(run):
    asked = ("grasp", "demonstrator", "--task", "cube-raise", "--json")
    plain = run(*asked).json()
    assert "transport" not in plain
    assert run(*asked, "--transport", "straight").json() == plain
    refused = run(*asked, "--transport", "people")
    assert (refused.code, refused.err.count("\n")) == (2, 1)
    assert "the demonstrator's palm goes straight; drop --transport" in refused.err


def test_trials_are_made_hard_in_one_thing(run, tmp_path):
    told = run("grasp", "demonstrator", "--task", "cube-raise", "--trials", "1",
               "--hard", "friction", "--seed", "4", "-o", tmp_path)  # fmt: skip
    assert f"wrote 2 rollouts to {tmp_path}\n" in told.err
    made = {read_rollout(path).conditions for path in tmp_path.glob("*.npz")}
    assert made == {Conditions(seed=4), made_hard(Conditions(seed=4), 5, "friction")}
    assert {each.friction for each in made} == {0.8, 0.3}


def test_both_protocols_are_shown_as_tables(run):
    lift = run("grasp", "demonstrator", "--task", "cube-raise").out
    for column in ("thumb [N]", "need [N]", "table [N]"):
        assert column in lift
    assert "1 of 1 tasks held" in lift
    six = run("grasp", "demonstrator", "--task", "cube-raise", "--protocol", "six-axis").out
    assert "hard" in six
    assert "shift [mm]" in six


def test_a_left_hand_grasps(run, tmp_path):
    asked = ("grasp", "demonstrator", "--task", "cube-raise", "--side", "left", "-o", tmp_path)
    assert run(*asked, "--json").json()["nominal_success"] is True
    rollout = read_rollout(tmp_path / "cube-raise.npz")
    assert rollout.conditions.hand.side == "left"
    right = run("grasp", "demonstrator", "--task", "cube-raise", "--json").json()
    assert right["per_trial"][0]["peak_slip_m"] != rollout.outcome.peak_slip_m


@pytest.mark.ci
@pytest.mark.slow
def test_processes_at_once_change_nothing_but_the_time(run):
    asked = ("grasp", "demonstrator", "--task", "cube-raise", "--trials", 1, "--json")
    assert run(*asked, "--jobs", 2).json() == run(*asked).json()


@pytest.mark.ci
@pytest.mark.slow
def test_an_object_left_out_is_grasped_by_what_has_not_seen_it(run, planned, tmp_path):
    path = shutil.copy(CONTROLLER, tmp_path / "c.npz")
    asked = ("grasp", path, "--leave-out", "jar", "--task", "all", "--json")
    said = run(*asked).json()
    assert said["left_out"] == "jar"
    assert [task["task"] for task in said["tasks"]] == ["jar-move", "jar-unscrew"]
    assert len(planned) == 2
    whole = GraspController.load(CONTROLLER)
    for learned in planned:
        assert "jar" not in {d.object for d in learned.demonstrations}
        assert len(learned.demonstrations) == len(whole.demonstrations) - 2
        assert not np.allclose(learned.subspace.components_, whole.subspace.components_)
    # The plans are beside the controller's own, and are not made twice.
    (stored,) = (tmp_path / "c.plans").iterdir()
    assert set(PlanStore(stored).read()) == {"jar-move", "jar-unscrew"}
    assert run(*asked).json()["tasks"] == said["tasks"]
    assert len(planned) == 2


@pytest.mark.ci
@pytest.mark.slow
def test_what_is_left_out_comes_from_the_recordings_named(run, planned, tmp_path):
    folder = shutil.copytree(EXPERIMENTS, tmp_path / "mine")
    asked = ("grasp", "--recordings", folder, "--leave-out", "cube", "--task", "cube-raise")
    assert run(*asked, "--json").json()["task"] == "cube-raise"
    assert len(planned) == 1
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".plans"] == ["mine.plans"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--leave-out", "cub", "--task", "all"), ("cub", "cube")),
        (("--leave-out", "cube", "--task", "jar-move"), ("jar-move", "cube-raise")),
        (("--leave-out", "cube", "--task", "cube-raise", "--replay"), ("--replay",)),
        (("demonstrator", "--leave-out", "cube", "--task", "all"), ("demonstrator",)),
        (("--recordings", EXPERIMENTS, "--task", "cube-raise"), ("--leave-out",)),
        (("--task", "cube-raise", "--jobs", "0"), ("--jobs",)),
        (("--task", "cube-raise", "--side", "middle"), ("--side", "left")),
        (("--task", "cube-raise", "--protocol", "seven"), ("--protocol", "six-axis")),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(run, options, words):
    result = run("grasp", *options)
    assert result.code == 2
    assert result.err.count("\n") == 1
    for word in words:
        assert word in result.err


@pytest.mark.parametrize(
    ("options", "time"),
    [
        (("--trials", 10_000_000_000), "317 years a task, at 1 s a run in 1 process;"),
        (("--trials", 864_000, "--jobs", 2), "5 days a task, at 1 s a run in 2 processes;"),
        (("--trials", 100_001), "28 h a task"),
    ],
)
def test_more_trials_than_can_be_waited_for_are_refused(run, begun, tmp_path, options, time):
    folder = tmp_path / "runs"
    result = run("grasp", "demonstrator", "--task", "cube-raise", *options, "-o", folder)
    assert (result.code, result.out) == (2, "")
    assert result.err.count("\n") == 1
    assert f"--trials {options[1]}: about {time}" in result.err
    assert "100000 are the most" in result.err
    assert (begun, folder.exists()) == ([], False)


def test_as_many_trials_as_are_allowed_are_begun(run, begun):
    assert run("grasp", "demonstrator", "--task", "cube-raise", "--trials", 100_000).code == 2
    assert begun == [100_000]


def test_a_controller_of_other_recordings_is_refused(run, tmp_path):
    folder = shutil.copytree(EXPERIMENTS, tmp_path / "mine")
    index = folder / "experiments.csv"
    lines = index.read_text().splitlines()
    index.write_text("\n".join(line for line in lines if "pen-move" not in line) + "\n")
    assert run("learn", folder, "-o", tmp_path / "c.npz").code == 0
    asked = ("grasp", tmp_path / "c.npz", "--leave-out", "cube", "--task", "all")
    result = run(*asked)
    assert result.code == 2
    assert "c.npz was not learned from the built-in experiments" in result.err
    assert "--recordings" in result.err
    assert run(*asked, "--recordings", EXPERIMENTS).code == 2

"""Plans beside a controller, as the command line finds, refuses and keeps them."""

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest

from handsim.cli.defaults import planning_grasper
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning import grasper as grasping
from handsim.learning.controller import GraspController
from handsim.tasks import task as grasp_task
from handsim.tasks.table_one import TASKS, task_by_name

CONTROLLER = data_folder("assets") / "controller.npz"
TASK = "cube-raise"


@pytest.fixture
def copied(tmp_path):
    """The built-in controller in a file of its own, as if it had been learned here."""
    return shutil.copy(CONTROLLER, tmp_path / "c.npz")


@pytest.fixture
def planned(monkeypatch):
    """Searches: none takes any time, each finds the built-in plan a little changed."""
    plans, asked = planning_grasper(None, Conditions()).read(), []

    def quickly(controller, task, conditions, known=None, *, others=(), seed=0, progress=None):
        asked.append(task.name)
        plan = replace(plans[task.name], squeeze=plans[task.name].squeeze + 0.01)
        return plan, SimpleNamespace(outcome=SimpleNamespace(success=True))

    monkeypatch.setattr(grasping, "plan_grasp", quickly)
    return asked


def test_nothing_is_planned_for_the_built_in_controller_in_another_file(run, copied, planned):
    mine = run("grasp", copied, "--task", TASK, "--trials", 1, "--json")
    built_in = run("grasp", "--task", TASK, "--trials", 1, "--json")
    assert (mine.code, mine.err) == (0, "")
    assert mine.json() == built_in.json()
    assert planned == []
    assert [path.name for path in copied.parent.iterdir()] == ["c.npz"]
    found = planning_grasper(copied, Conditions()).known(TASKS, Conditions())
    assert found.keys() == {task.name for task in TASKS}


def test_an_object_that_has_changed_is_planned_again_and_that_is_said(
    run, copied, planned, monkeypatch
):
    cube = task_by_name(TASK).object
    (piece,) = cube.pieces
    heavier = replace(cube, pieces=(replace(piece, mass=1.1 * piece.mass),))
    monkeypatch.setattr(grasp_task, "OBJECTS", {**grasp_task.OBJECTS, "cube": heavier})
    assert task_by_name(TASK).object is heavier
    first = run("grasp", copied, "--task", TASK, "--json")
    assert first.code == 0
    assert first.err == f"plan of {TASK} is of another object: planned again\n"
    again = run("grasp", copied, "--task", TASK, "--json")
    assert (again.err, again.json()) == ("", first.json())
    assert planned == [TASK]
    monkeypatch.undo()
    assert run("grasp", copied, "--task", TASK, "--json").err == ""  # the built-in one fits again


def damaged(copied, change) -> tuple:
    store = planning_grasper(copied, Conditions()).store
    plan = planning_grasper(None, Conditions()).store.entries()[TASK]
    store.add(TASK, plan)
    content = json.loads(store.path.read_text())
    change(content)
    store.path.write_text(json.dumps(content))
    return store.path, store.path.read_bytes()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(schema=3), "newer than 2"),
        (lambda c: c.update(owner="0" * 16), "plans of another controller or hand"),
        (lambda c: c["plans"].update({TASK: c["plans"][TASK] | {"task": "jar-move"}}), "jar-move"),
        (lambda c: c["plans"][TASK].update(z_goal_rad=[float("nan")] * 3), "3 numbers"),
        (lambda c: c.update(plans="none"), "not a file of plans"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line_and_not_overwritten(
    run, copied, planned, tmp_path, change, words
):
    path, content = damaged(copied, change)
    (tmp_path / "s.toml").write_text(f'tasks = ["{TASK}"]\ncontrollers = ["c.npz"]\n')
    for command in (
        ("grasp", copied, "--task", TASK),
        ("grasp", copied, "--task", "jar-move", "--jobs", 2),
        ("sweep", tmp_path / "s.toml", "-o", tmp_path / "r.csv", "--jobs", 1),
        ("baseline", "record", tmp_path / "b.npz", "--controller", copied),
        ("report", copied, "-o", tmp_path / "r.html"),
    ):
        said = run(*command)
        assert (said.code, said.out) == (2, "")
        (line,) = said.err.splitlines()[-1:]
        assert str(path) in line
        assert words in line
    assert path.read_bytes() == content
    assert planned == []
    assert not any((tmp_path / name).exists() for name in ("b.npz", "r.csv", "r.html"))


def test_where_plans_cannot_be_kept_they_are_used_and_that_is_said(run, tmp_path, planned):
    path = tmp_path / "c.npz"
    built_in = GraspController.load(CONTROLLER)
    steeper = replace(built_in.navigation, k=built_in.navigation.k + 0.5)
    replace(built_in, navigation=steeper).save(path)
    (tmp_path / "c.plans").write_text("a file, and no folder")
    said = run("grasp", path, "--task", TASK, "--trials", 2, "--json")
    assert said.code == 0
    assert len(said.json()["per_trial"]) == 3
    assert planned == [TASK]
    before, after = said.err.splitlines()
    assert before.startswith("plans that are made now are used, but not kept: ")
    assert before.endswith(f"{tmp_path / 'c.plans'}: is a file; give the name of a folder")
    assert after.startswith(f"plan of {TASK} is used, but could not be kept: {tmp_path}")
    (tmp_path / "s.toml").write_text(f'tasks = ["{TASK}"]\ncontrollers = ["c.npz"]\n')
    swept = run("sweep", tmp_path / "s.toml", "-o", tmp_path / "r.csv", "--jobs", 1, "--json")
    assert swept.json()["runs"] == 1
    assert "could not be kept" in swept.err

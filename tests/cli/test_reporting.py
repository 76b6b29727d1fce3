"""`handsim report` and `view`."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from handsim.cli.defaults import planning_grasper
from handsim.cli.reporting import _known_plan, _names, _shown
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.plan_key import key_for
from handsim.grasping.planning.plan_store import StoredPlan
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize
from handsim.viewing.live import page as live
from handsim.viewing.live import window

TASK = "cube-raise"


@pytest.fixture
def learned(run, tmp_path: Path) -> Path:
    """A controller with the demonstrator's plan of one task stored beside it."""
    path = tmp_path / "my controller.npz"
    assert run("learn", "-o", path, "--components", 2).code == 0
    plan, _ = scripted_plan(task_by_name(TASK), HandModel.from_spec(build_hand()))
    _keep(path, Conditions(), plan)
    return path


def _keep(path: Path, hand: Conditions, plan: GraspPlan) -> None:
    task = task_by_name(TASK)
    planning_grasper(path, hand).keep(task, StoredPlan(plan, True, key_for(task, hand)))


@pytest.mark.ci
@pytest.mark.slow
def test_the_page_holds_what_is_planned_and_how_it_was_made(run, learned, tmp_path) -> None:
    page = tmp_path / "report.html"
    result = run("report", learned, "-o", page)
    assert (result.code, result.out) == (0, "")
    assert ", 1 grasp\n" in result.err
    text = page.read_text()
    assert text.count("<video") == 1
    assert f'<td class="text">{TASK}</td>' in text
    assert "handsim learn -o controller.npz --method direction --components 2 --k 4" in text
    assert f"handsim report &#x27;{learned}&#x27; -o {page}" in text


def test_bad_input_is_refused_before_the_work(run, tmp_path) -> None:
    for arguments, word in (
        (("report", "-o", tmp_path / "r.txt"), ".html"),
        (("report", "-o", tmp_path / "no" / "r.html"), "no"),
        (("report", "-o", tmp_path / "r.html", "--tasks", "cube-rase"), TASK),
        (("report", tmp_path / "c.npz", "-o", tmp_path / "r.html"), "c.npz"),
        (("view", "--web", "--task", "cube-rase"), TASK),
        (("view", "--port", "0"), "port"),
        (("view", "--web", "--port", "18081", "--at", "goal=1,2"), "goal '1,2'"),
    ):
        result = run(*arguments)
        assert (result.code, result.out) == (2, "")
        assert result.err.count("\n") == 1
        assert word in result.err
    assert list(tmp_path.iterdir()) == []


def test_several_stand_side_by_side_on_a_page_by_names_that_differ(
    run, learned, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    opened: list[live.LivePage] = []
    monkeypatch.setattr(live, "serve", lambda page: (opened.append(page), page.close()))
    monkeypatch.setenv("DISPLAY", ":0")
    result = run("view", "built-in", learned, "--port", "18080", "--at", "share=0.5&at=way")
    assert (result.code, result.out) == (0, "")
    (page,) = opened
    assert page._names == ("built-in", "my controller")
    assert [len(each.controller.subspace.components_) for each in page._shown] == [3, 2]
    assert page.panel.state.share == 0.5
    plan = page._shown[1].plans(TASK, Conditions())
    assert plan is not None
    assert page._shown[1].plans("jar-move", Conditions()) is None
    result = run("view", *[learned] * 5)
    assert (result.code, result.err) == (2, "handsim: 5 controllers; give 1 to 4\n")


def test_names_of_controllers() -> None:
    paths = [None, Path("/a/x,y.npz"), Path("/a/c.npz"), Path("/b/c.npz"), Path("/b/c.npz")]
    assert _names(paths) == ["built-in", "x_y", "a/c", "b/c", "b/c 5"]


@pytest.mark.slow
def test_a_controller_is_learned_from_a_folder_of_recordings(tmp_path) -> None:
    from handsim.files import data_folder

    folder = tmp_path / "anna"
    shutil.copytree(data_folder("assets") / "experiments", folder)
    shown = _shown(folder, "anna")
    assert len(shown.recordings) == len(shown.controller.demonstrations) == 24
    assert shown.plans(TASK, Conditions()) is None


def test_plans_for_this_hand_come_before_those_for_the_median_one(learned) -> None:
    large = Conditions(hand=HandSize(0.21, 0.095))
    assert _known_plan(learned, "jar-move", large) is None
    median = _known_plan(learned, TASK, large)
    assert median is not None
    _keep(learned, large, replace(median, squeeze=3.25))
    assert _known_plan(learned, TASK, large).squeeze == 3.25
    assert _known_plan(learned, TASK, Conditions()).squeeze == median.squeeze


def test_a_window_where_there_is_a_display_and_a_page_where_there_is_none(
    run, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    opened: list[object] = []
    monkeypatch.setattr(window, "show", lambda controller, plans, task: opened.append(task))
    monkeypatch.setattr(live, "serve", lambda page: (opened.append(page.address), page.close()))
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    assert run("view", "--task", TASK).code == 0
    result = run("view", "--web", "--port", "18080")
    monkeypatch.delenv("DISPLAY")
    assert run("view", "--port", "18080").code == 0
    assert opened[0] == TASK
    assert all(str(address).startswith("http://127.0.0.1:") for address in opened[1:])
    assert len(opened) == 3
    assert (result.code, result.out) == (0, "")
    assert str(opened[1]) in result.err

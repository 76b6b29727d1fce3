"""What commands say when they are interrupted, and names that cannot be printed."""

import importlib.util
import os
import subprocess
import sys

import pytest

from handsim.cli import reporting
from handsim.cli.waiting import NOTHING, keeping, what_is_kept
from handsim.errors import InputError
from handsim.learning.controller import GraspController

MAIN = "from handsim.cli import main; main()"


def test_what_is_kept_is_said_once_and_forgotten():
    with pytest.raises(KeyboardInterrupt), keeping("rows are in a.csv"), keeping("plans are kept"):
        raise KeyboardInterrupt
    assert what_is_kept() == "rows are in a.csv; plans are kept"
    with keeping("rows are in a.csv"):
        pass
    assert what_is_kept() == NOTHING


def test_what_is_kept_of_a_command_is_forgotten_with_it(run, monkeypatch):
    def refuse(*_: object) -> None:
        with keeping("rows are in a.csv"):
            raise InputError("none of these")

    monkeypatch.setattr("handsim.cli.defaults.controller_or_built_in", refuse)
    assert run("certify").err == "handsim: none of these\n"
    assert what_is_kept() == NOTHING


def interrupt(*args, **kwargs):
    raise KeyboardInterrupt


def test_an_interrupt_is_one_line_and_130(run, monkeypatch, tmp_path):
    monkeypatch.setattr("handsim.learning.learn.learn_controller", interrupt)
    result = run("learn", "-o", tmp_path / "c.npz")
    assert (result.code, result.out) == (130, "")
    assert result.err.splitlines()[-1] == f"handsim: interrupted; {NOTHING}"
    assert not list(tmp_path.iterdir())


def test_an_interrupted_grasp_says_where_rollouts_and_plans_are(run, monkeypatch, tmp_path):
    monkeypatch.setattr("handsim.grasping.planning.planner.run_plan", interrupt)
    monkeypatch.setattr("handsim.grasping.planning.grasper.run_plan", interrupt, raising=False)
    result = run("grasp", "--task", "cube-raise", "-o", tmp_path / "runs")
    assert result.code == 130
    said = result.err.splitlines()[-1]
    assert said.startswith("handsim: interrupted; rollouts of the runs that ended are in ")
    assert "plans made until then are kept" in said


def test_view_without_its_extra_says_so_before_it_reads_anything(run, monkeypatch):
    monkeypatch.setattr(reporting, "find_spec", lambda name: None)
    monkeypatch.setattr(GraspController, "load", interrupt)
    result = run("view", "--web")
    assert (result.code, result.err) == (
        2, "handsim: the page needs viser; run: pip install 'handsim[viewer]'\n"
    )  # fmt: skip
    assert importlib.util.find_spec("handsim") is not None


@pytest.mark.parametrize(
    ("name", "environment", "shown"),
    [
        ("größe", {"PYTHONIOENCODING": "ascii"}, "gr\\xf6\\xdfe"),
        ("größe", {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, "e"),
        ("bad\udcff", {"PYTHONUTF8": "1"}, "bad\\udcff"),
    ],
)
def test_names_that_cannot_be_printed_are_shown_by_their_numbers(
    tmp_path, name, environment, shown
):
    folder = tmp_path / name
    folder.mkdir()
    rows = "\n".join(f"{i / 100},{i}" for i in range(50))
    (folder / f"{name}.csv").write_text("time_s,index_pip_deg\n" + rows)
    command = [sys.executable, "-c", MAIN, "recordings", "info", os.fsencode(folder)]
    done = subprocess.run(
        command, capture_output=True, env=os.environ | environment, check=False, cwd=tmp_path
    )
    said = (done.stdout + done.stderr).decode("utf-8", "surrogateescape")
    assert "Traceback" not in said
    assert shown in said

"""What takes long says how far it is: by a bar on a terminal, by a line now and then elsewhere."""

import os
import shutil
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from handsim.cli import grasping, waiting
from handsim.cli.console import note
from handsim.cli.waiting import fraction_done, how_far, in_time, progress
from handsim.errors import InputError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions

POSTURES = data_folder("assets") / "experiments" / "cube-raise.csv"
COMMANDS = {
    "learning": ("learn", "-o", "c.npz"),
    "certifying": ("certify",),
    "drawing": ("render", POSTURES, "-o", "p.mp4", "--size", "64x48"),
    "grasping": ("grasp", "demonstrator", "--task", "cube-raise"),
}


def on_terminal(folder: Path, *command: object) -> str:
    """What a command writes to standard error where that is a terminal."""
    pty = pytest.importorskip("pty")
    reader, writer = pty.openpty()
    written = bytearray()

    def drain() -> None:
        while True:
            try:
                written.extend(os.read(reader, 4096))
            except OSError:  # the terminal is closed
                return

    process = subprocess.Popen(
        [sys.executable, "-c", "from handsim.cli import main; main()", *map(str, command)],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=writer,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "120"},
    )
    os.close(writer)
    thread = threading.Thread(target=drain)
    thread.start()
    assert process.wait(120) in (0, 1)
    thread.join()
    os.close(reader)
    return written.decode(errors="replace")


SAMPLED = [
    pytest.param(each, marks=pytest.mark.slow) if each == "certifying" else each
    for each in COMMANDS
]


@pytest.mark.parametrize("label", SAMPLED)
def test_a_terminal_shows_a_bar(label: str, tmp_path: Path) -> None:
    said = on_terminal(tmp_path, *COMMANDS[label])
    assert label in said
    assert "so far" in said
    assert "\x1b[" in said


@pytest.mark.parametrize("label", SAMPLED)
def test_a_pipe_gets_none(label: str, run, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*COMMANDS[label])
    assert result.code in (0, 1)
    for line in result.err.splitlines():
        assert not line.startswith(label) or "so far" in line
    for mark in ("\x1b", "\r", "%  "):
        assert mark not in result.err


def test_a_bar_is_drawn_only_where_someone_looks(monkeypatch, capsys) -> None:
    waiting.heard()
    assert list(progress([1, 2, 3], "counting")) == [1, 2, 3]
    with fraction_done("counting") as done:
        done(0.5)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with fraction_done("counting") as done:
        done(0.5)
    assert list(progress([1, 2, 3], "walking")) == [1, 2, 3]
    said = capsys.readouterr().err
    assert "counting" in said
    assert "walking" in said


def test_a_line_breaks_a_silence_elsewhere(monkeypatch, capsys) -> None:
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 0.2)
    waiting.heard()
    with fraction_done("waiting") as done:
        time.sleep(0.3)
        done(0.5)
        time.sleep(0.2)
        for _ in range(5):
            note("said by somebody else")
            time.sleep(0.1)
    lines = capsys.readouterr().err.splitlines()
    assert lines[:2] == ["waiting: 0 s so far", "waiting: 50 %, 0 s so far, about 0 s left"]
    assert set(lines[2:]) == {"said by somebody else"}


def test_the_line_comes_to_a_silence_that_began_before(monkeypatch, capsys) -> None:
    """Imports take a while, too, before the work that has a bar begins."""
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 1.0)
    waiting.heard()
    time.sleep(0.8)
    with fraction_done("waiting"):
        time.sleep(0.6)  # the line is due after 0.2 s, with much room on a busy machine
    assert capsys.readouterr().err in ("waiting: 0 s so far\n", "waiting: 1 s so far\n")


def test_of_work_within_work_the_innermost_speaks(monkeypatch, capsys) -> None:
    """Outer work may also have been left alone, as an iterator that nobody ends."""
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 0.3)
    waiting.heard()
    with fraction_done("outer"):
        with fraction_done("inner"):
            time.sleep(0.8)
        assert "inner: " in (said := capsys.readouterr().err)
        assert "outer" not in said
        time.sleep(0.8)
    assert "outer: " in capsys.readouterr().err


@pytest.mark.parametrize("terminal", [False, True])
def test_nothing_is_said_of_a_command_that_has_ended(run, monkeypatch, terminal) -> None:
    """An iterator that was left by an error is not ended: whoever keeps the error keeps it."""
    left = []

    def fail(*_: object) -> None:
        left.append(progress(range(9), "going through"))
        next(left[0])
        raise InputError("none of these")

    monkeypatch.setattr("handsim.cli.defaults.controller_or_built_in", fail)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    said = run("certify")
    assert said.code == 2 and said.err.endswith("handsim: none of these\n")
    assert not waiting._working and not waiting._bars
    left[0].close()
    assert not waiting._working and not waiting._bars


def test_of_work_within_work_the_innermost_has_the_bar(monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with fraction_done("outer") as outer:
        (whole,) = waiting._bars
        assert whole.live.is_started
        with fraction_done("inner") as inner:
            inner(0.5)
            assert [bar.live.is_started for bar in waiting._bars] == [False, True]
        assert waiting._bars == [whole] and whole.live.is_started
        outer(0.5)
    assert not waiting._bars and not whole.live.is_started
    assert "inner" in capsys.readouterr().err


def test_a_process_that_works_for_another_says_nothing(monkeypatch, capsys) -> None:
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 0.05)
    monkeypatch.setattr("multiprocessing.parent_process", lambda: "the one with the terminal")
    waiting.heard()
    for terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)  # noqa: B023
        with fraction_done("planning") as done:
            done(0.5)
            time.sleep(0.2)
    assert capsys.readouterr().err == ""


def test_planning_says_how_far_it_is(run, tmp_path, monkeypatch) -> None:
    def slowly(controller, task, conditions, known=None, *, others, seed, progress):
        progress(0.25)
        time.sleep(0.3)
        raise InputError("that is enough of it")

    monkeypatch.setattr("handsim.grasping.planning.grasper.plan_grasp", slowly)
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 0.1)
    shutil.copy(data_folder("assets") / "controller.npz", tmp_path)
    size = ("--hand-length", "0.17")
    result = run("grasp", tmp_path / "controller.npz", "--task", "cube-raise", *size)
    said = [line for line in result.err.splitlines() if line.startswith("planning cube-raise: ")]
    assert "planning cube-raise: 25 %, 0 s so far, about 1 s left" in said


def test_what_is_interrupted_stops_speaking(capsys) -> None:
    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt), fraction_done("waiting"):
        assert threading.active_count() == before + 1
        raise KeyboardInterrupt
    assert threading.active_count() == before


@pytest.mark.parametrize(
    ("fraction", "elapsed", "said"),
    [
        (0.0, 59.6, "60 s so far"),
        (0.25, 30.0, "25 %, 30 s so far, about 90 s left"),
        (0.01, 60.0, "1 %, 60 s so far, about 99 min left"),
        (1.0, 7.0, "100 %, 7 s so far, about 0 s left"),
    ],
)
def test_how_far_is_said_with_an_estimate(fraction: float, elapsed: float, said: str) -> None:
    assert how_far(fraction, elapsed) == said


def test_times_have_the_unit_that_suits_them() -> None:
    said = [in_time(seconds) for seconds in (119.0, 120.0, 7200.0, 2 * 86400.0, 1e11)]
    assert said == ["119 s", "2 min", "2 h", "2 days", "3,171 years"]


SILENT = {
    "building": ("hand", "build", "-o", "hand"),
    "evaluating": ("evaluate",),
    "importing": ("recordings", "import", POSTURES.parent, "--format", "handsim", "-o", "made"),
    "drawing": ("recordings", "info", "--plot", "p.png"),
}


@pytest.mark.parametrize("label", SILENT)
def test_what_takes_over_two_seconds_is_not_silent(label, run, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(waiting, "LONGEST_SILENCE", 0.01)
    result = run(*SILENT[label])
    assert result.code == 0, result.err
    assert any(line.startswith(f"{label}: ") for line in result.err.splitlines())


def test_every_run_of_a_grasp_counts(monkeypatch) -> None:
    fractions: list[float] = []

    @contextmanager
    def bar(label: str):
        yield fractions.append

    monkeypatch.setattr(grasping, "fraction_done", bar)
    runs = [("task", SimpleNamespace(conditions=Conditions(seed=i)), None) for i in range(4)]
    assert [run.conditions.seed for _, run in grasping._kept(iter(runs), None, 4, [])] == [
        0,
        1,
        2,
        3,
    ]
    assert fractions == [0.25, 0.5, 0.75, 1.0]

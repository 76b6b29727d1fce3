"""What takes long says how far it is: on a terminal, and nowhere else."""

import os
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from handsim.cli import grasping
from handsim.cli.console import fraction_done, progress
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
    assert "%" in said
    assert "\x1b[" in said


@pytest.mark.parametrize("label", SAMPLED)
def test_a_pipe_gets_none(label: str, run, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*COMMANDS[label])
    assert result.code in (0, 1)
    assert label not in result.err
    for mark in ("\x1b", "\r", "%  "):
        assert mark not in result.err


def test_a_bar_is_drawn_over_several_items_only_where_someone_looks(monkeypatch, capsys) -> None:
    assert list(progress([1, 2, 3], "counting")) == [1, 2, 3]
    with fraction_done("counting") as done:
        assert done is None
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with fraction_done("counting") as done:
        assert done is not None
        done(0.5)
    assert list(progress([1, 2, 3], "walking")) == [1, 2, 3]
    said = capsys.readouterr().err
    assert "counting" in said
    assert "walking" in said


def test_every_run_of_a_grasp_counts(monkeypatch) -> None:
    fractions: list[float] = []

    @contextmanager
    def bar(label: str):
        yield fractions.append

    monkeypatch.setattr(grasping, "fraction_done", bar)
    runs = [("task", SimpleNamespace(conditions=Conditions(seed=i)), None) for i in range(4)]
    assert [run.conditions.seed for _, run in grasping._kept(iter(runs), None, 4)] == [0, 1, 2, 3]
    assert fractions == [0.25, 0.5, 0.75, 1.0]

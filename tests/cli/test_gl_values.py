"""Commands with every value of MUJOCO_GL: those that draw nothing work, the others say one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from handsim.files import data_folder
from handsim.viewing.opengl import backend as gl

POSTURES = data_folder("assets") / "experiments" / "cube-raise.csv"
DRAWING = (
    ("render", POSTURES, "-o", "x.png"),
    ("figures", "-o", "figures"),
    ("report", "-o", "x.html", "--tasks", "none"),
)
NO_DISPLAY = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}


def command_line(folder: Path, said: str, *words: object) -> subprocess.CompletedProcess[str]:
    """Run a command in a process of its own, since MuJoCo reads the variable once."""
    return subprocess.run(
        [sys.executable, "-c", "from handsim.cli import main; main()", *map(str, words)],
        env=os.environ | NO_DISPLAY | {"MUJOCO_GL": said},
        capture_output=True, text=True, cwd=folder, check=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("said", "command"),
    [
        ("glfw", ("hand", "build", "-o", "hand")),
        ("off", ("hand", "build", "-o", "hand")),
        ("0", ("grasp", "demonstrator", "--task", "mouse-left-click")),
    ],
)
def test_commands_that_draw_nothing_work_without_a_display(tmp_path, said, command):
    done = command_line(tmp_path, said, *command)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("command", DRAWING, ids=lambda command: command[0])
@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("glx", ("'glx' does not open", "unset MUJOCO_GL")),
        ("off", ("MUJOCO_GL=off", "turns rendering off", "unset MUJOCO_GL")),
        ("nonsense", ("MUJOCO_GL 'nonsense'", "osmesa")),
    ],
)
def test_commands_that_draw_say_one_line(run, tmp_path, monkeypatch, said, words, command):
    if not sys.platform.startswith("linux"):
        pytest.skip("windows can be opened without a display server's name elsewhere")
    monkeypatch.chdir(tmp_path)
    for name, value in {**NO_DISPLAY, "MUJOCO_GL": said}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(gl, "probe", lambda backend, seconds: gl.ProbeResult(backend, True))
    result = run(*command)
    assert result.code == 2
    assert result.err.count("\n") == 1
    for word in words:
        assert word in result.err
    assert not list(tmp_path.iterdir())


def test_a_traceback_of_old_is_one_line_in_a_process_of_its_own(tmp_path):
    done = command_line(tmp_path, "glfw", *DRAWING[0])
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "command", [("baseline", "check"), ("sweep", "s.toml", "-o", "s.csv"), ("view",)]
)
def test_unknown_values_are_one_line_wherever_mujoco_is_needed(tmp_path, command):
    done = command_line(tmp_path, "nonsense", *command)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "MUJOCO_GL 'nonsense'" in done.stderr

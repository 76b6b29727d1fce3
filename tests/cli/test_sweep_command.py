"""`handsim sweep`: what it reads, what it says, what it refuses."""

import csv
import os
import shutil
import subprocess
import sys
import threading
from contextlib import suppress

import pytest

from handsim.files import data_folder
from handsim.grasping.sweep.runner import COLUMNS

CONTROLLER = data_folder("assets") / "controller.npz"
PLANS = data_folder("assets") / "plans"
SWEEP = 'tasks = ["cube-raise"]\ncontrollers = ["demonstrator"]\nseeds = 2\n'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(SWEEP)
    return path


def test_a_sweep_becomes_a_table_a_summary_and_goes_on(run, file, tmp_path):
    output = tmp_path / "r.csv"
    asked = ("sweep", file, "-o", output, "--jobs", 1)
    first = run(*asked)
    assert first.code == 0
    assert "wrote 2 runs to" in first.err and "already" not in first.err
    assert first.out.splitlines()[0] == "| task | demonstrator |"
    assert "| cube-raise | held, 1/1 |" in first.out
    content = output.read_bytes()
    rows = list(csv.DictReader(content.decode().splitlines()))
    assert [*rows[0]] == ["sweep", "run", *COLUMNS]
    assert [row["nominal"] for row in rows] == ["True", "False"]
    again = run(*asked, "--json")
    assert "2 of 2 runs already in" in again.err and "wrote" not in again.err
    said = again.json()
    assert (said["runs"], said["runs_before"]) == (2, 2)
    (controller,) = said["controllers"]
    assert controller["controller"] == "demonstrator"
    assert (controller["nominal_held"], controller["successes"]) == (1, 1)
    assert [task["task"] for task in controller["per_task"]] == ["cube-raise"]
    assert output.read_bytes() == content


def test_a_sweep_says_what_grasp_says(run, file, tmp_path):
    run("sweep", file, "-o", tmp_path / "r.csv", "--jobs", 1)
    said = run("grasp", "demonstrator", "--task", "cube-raise", "--trials", 1, "--json").json()
    with (tmp_path / "r.csv").open() as table:
        for row, trial in zip(csv.DictReader(table), said["per_trial"], strict=True):
            for name in ("lift_m", "peak_slip_m", "peak_tilt_deg", "hold_s", "penetration_m"):
                assert float(row[name]) == pytest.approx(trial[name], rel=1e-5)
            assert row["success"] == str(trial["success"])


def test_controllers_are_beside_the_file_that_names_them(run, tmp_path, monkeypatch):
    folder = tmp_path / "study"
    (folder / "mine").mkdir(parents=True)
    shutil.copy(CONTROLLER, folder / "mine" / "c.npz")
    shutil.copytree(PLANS, folder / "mine" / "c.plans")
    before = sorted(PLANS.iterdir())
    (folder / "s.toml").write_text(
        'tasks = ["cube-raise"]\ncontrollers = ["mine/c.npz", "demonstrator"]\n'
    )
    monkeypatch.chdir(tmp_path)
    said = run("sweep", "study/s.toml", "-o", "r.csv", "--jobs", 1, "--json")
    assert said.code == 0
    mine, script = said.json()["controllers"]
    assert mine["controller"] == "mine/c.npz"
    assert (mine["nominal_held"], script["nominal_held"]) == (1, 1)
    assert "planning" not in said.err  # its plans are known
    assert sorted(PLANS.iterdir()) == before


def test_a_changed_sweep_or_controller_is_not_mixed_in(run, file, tmp_path):
    output = tmp_path / "r.csv"
    run("sweep", file, "-o", output, "--jobs", 1)
    content = output.read_bytes()
    file.write_text(SWEEP + "frictions = [0.7]\n")
    result = run("sweep", file, "-o", output)
    assert result.code == 2
    assert result.err.startswith(f"handsim: {output}: holds rows of another sweep")
    assert result.err.count("\n") == 1
    assert output.read_bytes() == content
    file.write_text(f"# comments do not matter\n{SWEEP}")
    assert run("sweep", file, "-o", output).code == 0


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("tasks = []", (), ("sweep.toml", "tasks")),
        (SWEEP + "colour = 1", (), ("sweep.toml", "colour")),
        ('tasks = "all"\ncontrollers = ["none.npz"]', (), ("none.npz", "no such file")),
        ('tasks = "all"\ncontrollers = ["sweep.toml"]', (), ("sweep.toml", "controller")),
        (SWEEP, ("-o", "r.txt"), (".txt", ".csv")),
        (SWEEP, ("-o", "nowhere/r.csv"), ("nowhere",)),
        (SWEEP, ("-o", "r.csv", "--jobs", "0"), ("--jobs",)),
        (SWEEP, ("-o", "r.csv", "--jobs", "2", "--dask", "tcp://127.0.0.1:1"), ("--dask",)),
        (SWEEP, ("-o", "r.csv", "--dask", "here"), ("here", "scheduler")),
    ],
)
def test_bad_input_takes_one_line_and_writes_nothing(run, file, monkeypatch, text, options, words):
    pytest.importorskip("distributed")
    monkeypatch.chdir(file.parent)
    file.write_text(text)
    result = run("sweep", file, *(options or ("-o", "r.csv")))
    assert result.code == 2
    assert result.out == ""
    assert result.err.count("\n") == 1
    for word in words:
        assert word in result.err
    assert [path.name for path in file.parent.iterdir()] == ["sweep.toml"]


def test_a_terminal_shows_a_bar_and_a_pipe_none(file, tmp_path, run):
    pty = pytest.importorskip("pty")
    reader, writer = pty.openpty()
    command = ("sweep", str(file), "-o", str(tmp_path / "r.csv"), "--jobs", "1")
    said: list[bytes] = []

    def listen() -> None:
        with suppress(OSError):  # the other end is closed
            while part := os.read(reader, 1 << 16):
                said.append(part)

    listening = threading.Thread(target=listen)
    listening.start()
    done = subprocess.run(
        [sys.executable, "-c", "from handsim.cli import main; main()", *command],
        stdout=subprocess.PIPE,
        stderr=writer,
        check=False,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "120"},
    )
    os.close(writer)
    listening.join()
    os.close(reader)
    assert done.returncode == 0
    assert b"grasping" in b"".join(said)
    assert b"%" in b"".join(said)
    assert b"\x1b" not in done.stdout
    assert "\x1b" not in run("sweep", file, "-o", tmp_path / "s.csv", "--jobs", 1).err

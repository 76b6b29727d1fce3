"""Bad input: one line that says what is wrong, exit code 2, and nothing half written."""

import os
import shutil
import subprocess
import sys

import pytest

from handsim.files import data_folder

EXPERIMENTS = data_folder("assets") / "experiments"
CONTROLLER = data_folder("assets") / "controller.npz"


@pytest.fixture
def folder(tmp_path):
    return shutil.copytree(EXPERIMENTS, tmp_path / "recordings")


@pytest.fixture
def refused(run, tmp_path):
    """Run something that must be refused, and return the one line it says."""

    def _refused(*args: object) -> str:
        before = sorted(path.name for path in tmp_path.rglob("*"))
        result = run(*args)
        assert result.code == 2
        assert result.out == ""
        assert result.err.count("\n") == 1
        assert result.err.startswith("handsim: ")
        assert sorted(path.name for path in tmp_path.rglob("*")) == before
        return result.err

    return _refused


def edit(folder, name: str, change) -> None:
    path = folder / name
    lines = path.read_text().splitlines()
    path.write_text("\n".join(change(lines)) + "\n")


def set_cell(row: int, column: int, value: str):
    def change(lines: list[str]) -> list[str]:
        cells = lines[row].split(",")
        cells[column] = value
        lines[row] = ",".join(cells)
        return lines

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (set_cell(5, 3, "nan"), ("row 6", "thumb_ip_deg")),
        (set_cell(5, 3, "many"), ("row 6", "thumb_ip_deg")),
        (set_cell(0, 2, "thumb_mcq_deg"), ("thumb_mcp_deg",)),
        (set_cell(9, 0, "0.0"), ("row 10", "time_s")),
        (set_cell(4, 7, "181"), ("row 5", "index_dip_deg", "180")),
        (lambda lines: lines[:6], ("10",)),
        (
            lambda lines: [f"{line},{line.split(',')[4]}" for line in lines],
            ("abduction_deg", "twice"),
        ),
        (lambda lines: [], ("empty",)),
    ],
)
def test_damaged_recordings(refused, folder, tmp_path, change, words):
    edit(folder, "cube-raise.csv", change)
    message = refused("learn", folder, "-o", tmp_path / "c.npz")
    for word in ("cube-raise.csv", *words):
        assert word in message


def test_missing_folder_and_empty_folder(refused, tmp_path):
    (tmp_path / "empty").mkdir()
    assert "nowhere" in refused("learn", tmp_path / "nowhere", "-o", tmp_path / "c.npz")
    assert "experiments.csv" in refused("learn", tmp_path / "empty", "-o", tmp_path / "c.npz")


def test_missing_recording_file(refused, folder, tmp_path):
    (folder / "cube-raise.csv").unlink()
    assert "cube-raise.csv" in refused("learn", folder, "-o", tmp_path / "c.npz")


def test_controller_cut_in_half(refused, tmp_path):
    whole = CONTROLLER.read_bytes()
    (tmp_path / "half.npz").write_bytes(whole[: len(whole) // 2])
    for command in (("evaluate",), ("grasp", "--task", "cube-raise")):
        assert "half.npz" in refused(command[0], tmp_path / "half.npz", *command[1:])


def test_files_of_another_kind(refused, tmp_path):
    shutil.copy(CONTROLLER, tmp_path / "c.npz")
    message = refused("render", tmp_path / "c.npz", "-o", tmp_path / "x.mp4")
    assert "controller" in message


@pytest.mark.parametrize("length", ["2", "-1", "nan"])
def test_hands_that_are_none(refused, tmp_path, length):
    for args in (("hand", "build", "-o", tmp_path / "hand"), ("grasp", "--task", "cube-raise")):
        message = refused(*args, "--hand-length", length)
        assert "0.12" in message
        assert "0.26" in message


def test_unknown_names_offer_the_nearest(refused, tmp_path):
    assert "cube-raise" in refused("grasp", "--task", "cube-rase")
    assert "cube-raise" in refused("postures", "--task", "cube-rase", "-o", tmp_path / "p.csv")


def test_who_names_no_task_is_told_where_they_are(refused):
    assert "neither is given" in refused("grasp")
    for asked in ((), ("--task", "cube-rase")):
        assert "`handsim tasks` lists" in refused("grasp", *asked)


def test_outputs_that_cannot_be_written_are_refused_before_the_work(refused, tmp_path):
    assert "no" in refused("learn", "-o", tmp_path / "no" / "c.npz")
    assert ".txt" in refused("learn", "-o", tmp_path / "c.txt")
    source = EXPERIMENTS / "cube-raise.csv"
    assert ".avi" in refused("render", source, "-o", tmp_path / "x.avi")


@pytest.mark.parametrize(
    "options",
    [("--size", "640"), ("--size", "0x480"), ("--fps", "0"), ("--camera", "nowhere")],
)
def test_views_that_cannot_be_drawn(refused, tmp_path, options):
    refused("render", EXPERIMENTS / "cube-raise.csv", "-o", tmp_path / "x.png", *options)


def test_usage_errors_take_one_line_too(refused):
    assert "No such option" in refused("grasp", "--task", "cube-raise", "--bogus")
    assert "No such command" in refused("grap")
    refused("grasp", "--task", "cube-raise", "--trials", "-1")
    refused("learn")


@pytest.mark.parametrize(
    "command",
    [
        ("grasp", "--task", "cube-raise"),
        ("hand", "build", "-o", "hand"),
        ("render", "p.csv", "-o", "p.mp4"),
    ],
)
def test_opengl_backends_that_are_none(tmp_path, command):
    done = subprocess.run(
        [sys.executable, "-c", "from handsim.cli import main; main()", *command],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=os.environ | {"MUJOCO_GL": "nonsense"},
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "osmesa" in done.stderr
    assert not list(tmp_path.iterdir())

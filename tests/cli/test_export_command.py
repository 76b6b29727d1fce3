"""`handsim export`: the format by the name of the output, outputs and libraries looked at first."""

import json
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from handsim.files import data_folder
from handsim.grasping.rollout_file import read_rollout

EXPERIMENTS = data_folder("assets") / "experiments"
ROLLOUT = Path(__file__).parents[1] / "data" / "schemas" / "rollout-2.npz"


@pytest.mark.parametrize(
    ("name", "format"),
    [("a.parquet", "pandas"), ("a.csv", "pandas"), ("a.h5", "hdf5"), ("a.hdf5", "hdf5"),
     ("set", "lerobot")],
)  # fmt: skip
def test_the_name_says_the_format(run, tmp_path: Path, name: str, format: str) -> None:
    result = run("export", ROLLOUT, "-o", tmp_path / name, "--json")
    assert result.code == 0, result.err
    said = result.json()
    assert (said["format"], said["output"]) == (format, str(tmp_path / name))
    rollout = read_rollout(ROLLOUT)
    assert said["episodes"] == [
        {
            "name": "rollout-2", "kind": "rollout", "task": "cube-raise",
            "sentence": "Grasp the cube and raise it.", "n_samples": 12,
            "duration_s": rollout.time[-1], "success": rollout.outcome.success,
        }
    ]  # fmt: skip
    assert result.err.endswith(f"wrote 1 movement to {tmp_path / name}\n")
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    ("to", "name"),
    [("hdf5", "a.h5"), ("hdf5", "a"), ("pandas", "a.csv"), ("pandas", "a"), ("parquet", "a"),
     ("lerobot", "data.v1")],
)  # fmt: skip
def test_a_format_may_be_named(run, tmp_path: Path, to: str, name: str) -> None:
    for option in ("--to", "--format"):
        result = run("export", ROLLOUT, option, to, "-o", tmp_path / name)
        assert result.code == 0, result.err
        assert "cube-raise" in result.out
    if to == "lerobot":
        assert (tmp_path / name / "meta" / "info.json").is_file()
    elif to == "hdf5":
        assert h5py.is_hdf5(tmp_path / name)
    else:
        read = pd.read_csv if name.endswith(".csv") else pd.read_parquet
        assert len(read(tmp_path / name)) == 12


def test_a_folder_of_recordings_is_read_back(run, tmp_path: Path) -> None:
    result = run("export", EXPERIMENTS, "-o", tmp_path / "all.parquet", "--json")
    frame = pd.read_parquet(tmp_path / "all.parquet")
    said = result.json()
    assert said["columns"] == list(frame.columns)
    assert [each["name"] for each in said["episodes"]] == list(dict.fromkeys(frame["name"]))
    assert len(said["episodes"]) == 24
    one = pd.read_csv(EXPERIMENTS / "cube-raise.csv")
    rows = frame[frame["name"] == "cube-raise"]
    for column in one.columns:
        assert np.allclose(rows[column], one[column], rtol=0, atol=1e-12), column


def test_several_sources_are_several_groups(run, tmp_path: Path) -> None:
    postures = EXPERIMENTS / "pen-write.csv"
    result = run("export", ROLLOUT, postures, "-o", tmp_path / "a.h5", "--json")
    assert result.json()["groups"] == ["rollout-2", "pen-write"]
    with h5py.File(tmp_path / "a.h5") as file:
        assert set(file) == {"rollout-2", "pen-write"}
        assert file["pen-write"].attrs["kind"] == "postures"


def test_what_was_done_to_movements_is_said(run, tmp_path: Path) -> None:
    result = run("export", ROLLOUT, "-o", tmp_path / "set", "--fps", 5, "--json")
    said = result.json()
    assert (said["fps"], said["n_episodes"], said["n_frames"]) == (5, 1, 29)
    assert said["resampled"] == ["rollout-2"]
    assert said["left_out"] == []
    assert "resampled to 5 frames a second: rollout-2\n" in result.err
    info = json.loads((tmp_path / "set/meta/info.json").read_text())
    assert said["features"] == list(info["features"])
    assert info["total_frames"] == 29


def test_a_film_is_made_where_asked_for(run, tmp_path: Path) -> None:
    asked = ("--video", "--camera", "side", "--size", "64x48", "--fps", 1)
    result = run("export", ROLLOUT, "-o", tmp_path / "set", *asked)
    assert result.code == 0, result.err
    films = [path.relative_to(tmp_path / "set") for path in tmp_path.rglob("*.mp4")]
    assert films == [Path("videos/observation.images.side/chunk-000/file-000.mp4")]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-o", "a.xlsx"), "suffix '.xlsx' is not one of .parquet, .csv, .h5, .hdf5, .rrd"),
        (("-o", "a.h5", "--to", "pandas"), "suffix '.h5' is not one of .parquet, .csv, in which"),
        (("-o", "a.csv", "--to", "parquet"), "suffix '.csv' is not one of .parquet, in which"),
        (("-o", "a", "--to", "csv"), "suffix '' is not one of .csv, in which csv is written"),
        (("-o", "a", "--to", "hdf"), "unknown format 'hdf'; did you mean hdf5?"),
        (("-o", "a.h5", "--fps", "30"), "are for LeRobot data sets, not for hdf5"),
        (("-o", "a.h5", "--video"), "are for LeRobot data sets, not for hdf5"),
        (("-o", "a", "--camera", "view"), "add --video"),
        (("-o", "a", "--fps", "0"), "0 frames a second; give 1 to 1000"),
        (("-o", "a", "--video", "--size", "65x48"), "takes even sizes, give 66x48"),
        (("-o", "a", "--video", "--size", "big"), "size 'big' is not WIDTHxHEIGHT"),
        (("-o", "a", "--video", "--camera", "nose"), "unknown camera 'nose'"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("export", ROLLOUT, *words)
    assert (result.code, result.out) == (2, "")
    assert result.err.count("\n") == 1
    assert said in result.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "library", "extra"),
    [("a.h5", "h5py", "export"), ("a.csv", "pandas", "export"), ("a.parquet", "pyarrow", "export"),
     ("set", "pandas", "export"), ("a.rrd", "rerun", "rerun")],
)  # fmt: skip
def test_a_missing_extra_is_told_before_anything_is_read(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, library: str, extra: str
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    result = run("export", "nowhere.npz", "-o", tmp_path / name)
    assert (result.code, result.out) == (2, "")
    assert result.err.endswith(f"; run: pip install 'handsim[{extra}]'\n")
    assert result.err.count("\n") == 1


def test_neither_import_nor_help_need_the_extras() -> None:
    code = (
        "import sys, contextlib\n"
        "for name in ('pandas', 'pyarrow', 'h5py', 'rerun'): sys.modules[name] = None\n"
        "import handsim; handsim.to_frame, handsim.write_hdf5, handsim.write_lerobot\n"
        "handsim.write_rerun\n"
        "sys.argv = ['handsim', 'export', '--help']\n"
        "from handsim.cli import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "LeRobot" in done.stdout

"""`handsim recordings cut`: the folder, the table, the notes and the errors."""

import json
from pathlib import Path

import numpy as np
import pytest
import typer

from handsim.cli.recordings.cutting import cut
from handsim.errors import FileError, InputError
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize

CERTAIN = ((0, 1.5), (1, 1.2), (1, 1.5), (0, 0.5), (0, 1.0))
UNDECIDED = ((0, 1.5), (0.5, 0.7), (0.5, 1.8), (1, 0.7), (1, 1.8), (0, 0.5), (0, 1.0))


def recording(name: str, legs) -> Recording:
    parts, at = [], 0.0
    for target, seconds in legs:
        x = np.linspace(0, 1, round(100 * seconds))
        parts.append(at + (target - at) * x**3 * (10 - 15 * x + 6 * x**2))
        at = target
    q = np.outer(np.concatenate(parts), np.full(22, 0.6))
    return Recording(name, np.arange(len(q)) / 100, q, 1, "s", "cup", "cup-drink", HandSize())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    both = RecordingSet((recording("a", CERTAIN), recording("b", UNDECIDED)))
    write_recordings(both, tmp_path / "raw")
    return tmp_path / "raw"


def run(*words: object) -> None:
    app = typer.Typer()
    app.command()(cut)
    app([str(word) for word in words], standalone_mode=False)


def test_reaches_are_written_and_doubts_told(folder: Path, capsys) -> None:
    run(folder, "-o", folder.parent / "cut", "--plot", folder.parent / "cut.png")
    out, err = capsys.readouterr()
    assert [r.name for r in read_recordings(folder.parent / "cut")] == ["a-01"]
    assert (folder.parent / "cut.png").stat().st_size > 10_000
    assert "1.00  yes" in out and " no " in out
    assert "not cut: b from 1.52" in err and "or from" in err
    assert "file,start_s,end_s\nb.csv,1.52" in err
    assert "wrote 1 recording " in err


def test_json(folder: Path, capsys) -> None:
    run(folder, "-o", folder.parent / "cut", "--json")
    reaches = json.loads(capsys.readouterr().out)["reaches"]
    assert [(r["recording"], r["cut"]) for r in reaches] == [("a", True), ("b", False)]
    assert len(reaches[1]["second"]) == 2 and 0 <= reaches[1]["confidence"] < 0.7


def test_times_settle_what_is_doubtful(folder: Path, capsys) -> None:
    run(folder, "-o", folder.parent / "first")
    rows = capsys.readouterr().err.split("with --times:\n")[1].split("wrote")[0]
    (folder.parent / "times.csv").write_text(rows)
    run(folder, "-o", folder.parent / "cut", "--times", folder.parent / "times.csv")
    assert [r.name for r in read_recordings(folder.parent / "cut")] == ["a-01", "b-01"]
    assert "not cut" not in capsys.readouterr().err


def test_options(folder: Path) -> None:
    run(folder, "-o", folder.parent / "cut", "--longest-pause", "5", "--rest-speed", "0.05")
    assert len(read_recordings(folder.parent / "cut")) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--longest-pause", "nan"), "longest_pause_s"),
        (("--rest-speed", "7"), "rest_speed is 7; give 0.01 to 0.5"),
        (("--channel", "latch_rad"), "no channels"),
        (("--times", "no.csv"), "no.csv"),
        (("--plot", "cut.gif"), "suffix"),
    ],
)
def test_bad_input_writes_nothing(folder: Path, words, message: str) -> None:
    with pytest.raises((InputError, FileError), match=message):
        run(folder, "-o", folder.parent / "cut", *words)
    assert [entry.name for entry in folder.parent.iterdir()] == ["raw"]


def test_nothing_certain_and_the_folder_itself(tmp_path: Path) -> None:
    write_recordings(RecordingSet((recording("b", UNDECIDED),)), tmp_path / "raw")
    with pytest.raises(InputError, match="none of 1 reaches is certain"):
        run(tmp_path / "raw", "-o", tmp_path / "cut", "--plot", tmp_path / "cut.png")
    with pytest.raises(InputError, match="name another folder"):
        run(tmp_path / "raw", "-o", tmp_path / "x" / ".." / "raw")
    assert [entry.name for entry in tmp_path.iterdir()] == ["raw"]

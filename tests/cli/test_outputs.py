"""Outputs are looked at before anything else, and what was computed is shown though not stored."""

import errno
import os
from pathlib import Path

import pytest

from handsim.disk import refused
from handsim.grasping import rollout_file

NOWHERE = (
    "nowhere"  # an input that is not there: that outputs are checked before it is read is shown
)
FILES = {
    "learn": (("learn", NOWHERE), "c.npz"),
    "postures": (("postures", NOWHERE, "--task", "cube-raise"), "p.csv"),
    "drive": (("drive", NOWHERE, "--signal", NOWHERE), "p.csv"),
    "sweep": (("sweep", NOWHERE), "s.csv"),
    "render": (("render", NOWHERE), "m.mp4"),
    "report": (("report", NOWHERE), "r.html"),
    "inspect": (("hand", "inspect", NOWHERE), "s.png"),
    "check": (("object", "check", NOWHERE), "s.png"),
    "export": (("export", NOWHERE), "m.h5"),
    "map": (("recordings", "map", NOWHERE), "m.toml"),
    "calibrate": (("recordings", "calibrate", NOWHERE), "m.toml"),
}
OTHERS = {
    "info": (("recordings", "info", NOWHERE, "--plot"), "p.png"),
    "film": (("drive", "--signal", NOWHERE, "-o", "p.csv", "--video"), "m.mp4"),
    "plot": (("recordings", "cut", NOWHERE, "-o", "parts", "--plot"), "p.png"),
    "record": (("baseline", "record", "--controller", NOWHERE), "b.npz"),
    "html": (("baseline", "check", NOWHERE, "--html"), "b.html"),
}
FOLDERS = {
    "grasp": ("grasp", NOWHERE, "--task", "cube-raise"),
    "figures": ("figures", NOWHERE),
    "import": ("recordings", "import", NOWHERE, "--format", "csv"),
    "cut": ("recordings", "cut", NOWHERE),
    "set": ("export", NOWHERE),
}
COMMANDS = {
    **{name: ((*words, "-o"), file) for name, (words, file) in FILES.items()},
    **OTHERS,
    **{name: ((*words, "-o"), "made") for name, words in FOLDERS.items()},
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in, with a folder 'locked' in it that may not be written."""
    monkeypatch.chdir(tmp_path)
    locked = tmp_path / "locked"
    locked.mkdir()
    allowed = os.access

    def access(path: Path, mode: int) -> bool:  # root may write anywhere, whatever the mode is
        inside = Path(path).resolve() == locked and mode & os.W_OK
        return not inside and allowed(path, mode)

    monkeypatch.setattr(os, "access", access)
    return tmp_path


@pytest.mark.parametrize("where", ["locked", "missing"])
@pytest.mark.parametrize("command", COMMANDS)
def test_outputs_are_refused_before_inputs_are_read(run, folder: Path, command, where) -> None:
    words, name = COMMANDS[command]
    result = run(*words, folder / where / name)
    assert (result.code, result.out) == (2, "")
    assert result.err.count("\n") == 1
    assert str(folder / where) in result.err
    assert {"locked": "Permission denied", "missing": "create it first"}[where] in result.err
    assert [path.name for path in folder.iterdir()] == ["locked"]
    assert list((folder / "locked").iterdir()) == []


@pytest.mark.parametrize("words", [*FOLDERS.values(), ("hand", "build")])
def test_folders_that_are_files_or_locked_are_refused(run, folder: Path, words) -> None:
    (folder / "file").touch()
    assert "is a file" in run(*words, "-o", folder / "file").err
    if "recordings" not in words:  # which replace the folder, and so need its parent alone
        assert "Permission denied" in run(*words, "-o", folder / "locked").err


def test_a_baseline_that_cannot_be_updated_is_refused_before_the_work(run, folder: Path) -> None:
    from handsim.files import data_folder

    kept = folder / "locked" / "baseline.npz"
    kept.write_bytes((data_folder("assets") / "baseline.npz").read_bytes())
    asked = ("baseline", "check", kept, "--controller", NOWHERE, "--update", "new friction")
    assert "Permission denied" in run(*asked).err


def test_grasps_that_cannot_be_stored_are_shown(run, folder: Path, monkeypatch) -> None:
    tried: list[Path] = []

    def full(rollout: object, path: Path) -> None:
        tried.append(path)
        raise refused(path, OSError(errno.ENOSPC, "No space left on device"), "written")

    monkeypatch.setattr(rollout_file, "write_rollout", full)
    asked = ("grasp", "demonstrator", "--task", "cube-raise", "--trials", 1, "-o", "runs", "--json")
    result = run(*asked)
    assert result.code == 2
    assert len(result.json()["per_trial"]) == 2
    assert tried == [Path("runs/cube-raise.npz")]
    assert result.err.count("\n") == 1
    assert "runs/cube-raise.npz: cannot be written (No space left on device)" in result.err

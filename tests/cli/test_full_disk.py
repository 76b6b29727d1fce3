"""What was computed is told where it cannot be stored, and no half a file is left."""

import errno
import json
import os

import pytest

from handsim import files
from handsim.files import data_folder

EXPERIMENTS = data_folder("assets") / "experiments"


@pytest.fixture
def full_disk(monkeypatch):
    """Nothing can be put in its place any more, as where the disk is full."""

    def no_space(self, target):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self))

    monkeypatch.setattr(files.Path, "replace", no_space)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("learn -o c.npz --components 2 --json", "n_recordings"),
        (f"object check {data_folder('assets') / 'objects' / 'cube.obj'} -o p.png --json",
         "watertight"),
        ("recordings info --plot p.png --json", "recordings"),
    ],
    ids=["learn", "object check", "recordings info"],
)  # fmt: skip
def test_results_are_told_although_they_cannot_be_stored(
    run, full_disk, monkeypatch, tmp_path, command, said
):
    monkeypatch.chdir(tmp_path)
    result = run(*command.split())
    assert result.code == 2, result.err
    assert said in json.loads(result.out)
    last = result.err.splitlines()[-1]
    assert "cannot be written (No space left on device)" in last
    assert any(name in last for name in ("c.npz", "p.png"))
    assert not list(tmp_path.iterdir())

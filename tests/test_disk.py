"""What the system refuses is an error of one line: the file by its name, the need, the remedy."""

import errno
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from handsim import files
from handsim.disk import naming
from handsim.errors import FileError
from handsim.files import data_folder
from handsim.grasping.sweep.table import open_table
from handsim.hand.export import write_hand
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.types import MEDIAN_HAND
from handsim.viewing.film.video import write_image, write_video

EXPERIMENTS = data_folder("assets") / "experiments"
SPACE = 64 * 1024


@pytest.fixture(scope="module")
def full_disk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A disk of 64 kB of its own."""
    folder = tmp_path_factory.mktemp("disk")
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SPACE}", "handsim-test", str(folder)]
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        pytest.skip("only root can mount a small disk, on Linux")
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture
def disk(full_disk: Path) -> Path:
    """The same, empty."""
    for path in full_disk.iterdir():
        path.unlink()
    return full_disk


def big_archive(path: Path) -> None:
    noise = np.random.default_rng(0).random(40_000)
    files.write_archive(path, "thing", 1, {}, {"a": noise})


def video(path: Path) -> None:
    generator = np.random.default_rng(0)
    write_video((generator.integers(0, 255, (120, 160, 3), np.uint8) for _ in range(15)), path, 30)


def picture(path: Path) -> None:
    write_image(np.random.default_rng(0).integers(0, 255, (300, 300, 3), np.uint8), path)


def table(path: Path) -> None:
    with open_table(path, "sweep", ["text"], 2) as opened:
        opened.add(0, ["x" * 2 * SPACE])


WRITERS: dict[str, Callable[[Path], object]] = {
    "a.txt": lambda path: files.write_text(path, "x" * 2 * SPACE),
    "a.npz": big_archive,
    "a.mp4": video,
    "a.gif": video,
    "a.png": picture,
    "recordings": lambda path: write_recordings(read_recordings(EXPERIMENTS), path),
    "table.csv": table,
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_names_the_file_the_need_and_the_remedy(
    disk: Path, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    if name != "table.csv":  # rows are appended to the old one
        (disk / "other").write_text("kept")
    with pytest.raises(FileError, match="No space left on device") as raised:
        WRITERS[name](disk / name)
    said = str(raised.value)
    assert said.startswith(f"{disk / name}: ")
    free = re.search(r"it needs more than the (\S+) kB free in (.*): free some, or choose", said)
    assert free is not None
    assert 50 < float(free[1]) <= SPACE / 1000  # what the file took itself is free again
    assert free[2] == str(disk)
    assert "\n" not in said
    assert capfd.readouterr() == ("", ""), "an encoder adds nothing to it"
    left = {path.name for path in disk.iterdir()}
    assert left == ({"table.csv"} if name == "table.csv" else {"other"})


def test_a_row_that_finds_no_space_is_left_out_as_a_whole(disk: Path) -> None:
    with pytest.raises(FileError), open_table(disk / "t.csv", "s", ["text"], 2) as opened:
        opened.add(0, ["short"])
        opened.add(1, ["x" * 2 * SPACE])
    with open_table(disk / "t.csv", "s", ["text"], 2) as opened:
        assert [row["text"] for row in opened.rows()] == ["short"]


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (errno.ENOSPC, "it needs more than the .* free in .*: free some"),
        (errno.EDQUOT, "delete files of yours"),
        (errno.EROFS, "on another disk"),
        (errno.EACCES, "permissions"),
        (errno.EPERM, "permissions"),
        (errno.EIO, "may be failing"),
        (errno.EFBIG, "another disk"),
        (errno.ENAMETOOLONG, "shorter name"),
        (errno.EMFILE, "ulimit"),
        (errno.EISDIR, "name of a file"),
        (errno.ENOTDIR, "is a file and no folder"),
        (errno.ELOOP, "circle"),
        (errno.EBUSY, "wait"),
        (errno.ENOTCONN, "choose another"),
    ],
)
def test_every_refusal_has_its_remedy(tmp_path: Path, code: int, remedy: str) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with (
        pytest.raises(FileError, match=remedy) as raised,
        files.replacing(path) as temporary,
    ):
        temporary.write_text("half")
        raise OSError(code, os.strerror(code))
    assert str(raised.value).startswith(f"{path}: cannot be written ({os.strerror(code)}); ")
    assert [each.read_text() for each in tmp_path.iterdir()] == ["old"]


def test_what_is_refused_about_the_temporary_file_names_the_real_one(tmp_path: Path) -> None:
    with pytest.raises(FileError) as raised, files.replacing(tmp_path / "a.txt") as temporary:
        raise OSError(errno.EIO, "Input/output error", str(temporary))
    assert str(raised.value).startswith(f"{tmp_path / 'a.txt'}: ")
    assert temporary.name not in str(raised.value)


@pytest.mark.parametrize(
    "error",
    [
        FileNotFoundError(errno.ENOENT, "No such file", "/elsewhere"),
        BrokenPipeError(errno.EPIPE, "Broken pipe"),
        OSError("not of the system"),
    ],
)
def test_what_concerns_something_else_goes_through(tmp_path: Path, error: OSError) -> None:
    with pytest.raises(type(error)) as raised, naming(tmp_path / "a.txt"):
        raise error
    assert raised.value is error


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("x" * 300 + ".txt", "shorter name"),
        ("file/a.txt", "folder .* does not exist"),
        ("loop/a.txt", "does not exist|circle"),
        (".", "is a folder"),
    ],
)
def test_names_that_cannot_be_written(tmp_path: Path, name: str, words: str) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(FileError, match=words) as raised:
        files.write_text(tmp_path / name, "text")
    assert "\n" not in str(raised.value)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device /dev/full on this system")
@pytest.mark.parametrize("device", ["/dev/full", "/dev/null"])
def test_devices_are_never_replaced(device: str) -> None:
    with pytest.raises(FileError, match="is not a plain file; give the name of one"):
        files.check_target(Path(device))
    assert Path(device).is_char_device()


def test_a_folder_that_may_not_be_written_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(FileError, match=r"Permission denied\); change its permissions"):
        files.check_target(tmp_path / "a.txt")


def test_files_that_may_not_be_read_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not that they are cut off or of another encoding."""

    def denied(self: Path, *rest: object, **more: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    path = tmp_path / "a.npz"
    big_archive(path)
    monkeypatch.setattr(Path, "read_text", denied)
    monkeypatch.setattr(files.zipfile, "ZipFile", denied)
    for read in (files.read_text, lambda path: files.read_archive(path, "thing", 1)):
        with pytest.raises(
            FileError, match=r"be read \(Permission denied\); change its permissions"
        ):
            read(path)


def test_a_folder_for_the_hand_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "sub"):
        with pytest.raises(FileError, match=r"cannot be made .*; .*choose another") as raised:
            write_hand(MEDIAN_HAND, folder)
        assert str(raised.value).startswith(f"{folder}: ")


def test_new_files_have_the_usual_permissions_and_those_of_other_threads_stay(
    tmp_path: Path,
) -> None:
    """Asking for the permissions in use sets them for the whole process for a moment."""
    usual = os.umask(0o027)
    try:
        ends = threading.Barrier(4)

        def write(name: str) -> None:
            ends.wait(10)
            for _ in range(50):
                files.write_text(tmp_path / name, "text")

        threads = [threading.Thread(target=write, args=(f"{i}.txt",)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert {path.stat().st_mode & 0o777 for path in tmp_path.iterdir()} == {0o640}
        assert os.umask(0o027) == 0o027
    finally:
        os.umask(usual)


def handsim(*words: object, **streams: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from handsim.cli import main; main()", *map(str, words)]
    return subprocess.run(command, text=True, check=False, **streams)  # type: ignore[call-overload]


def test_grasps_on_a_full_disk(disk: Path) -> None:
    (disk / "filler").write_bytes(b"x" * (SPACE - 8192))
    done = handsim(
        "grasp", "demonstrator", "--task", "mouse-left-click", "-o", disk / "runs",
        capture_output=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert f"handsim: {disk / 'runs' / 'mouse-left-click.npz'}: cannot be written" in done.stderr
    assert "free some, or choose a folder on another disk" in done.stderr
    assert not list((disk / "runs").iterdir())
    (disk / "runs").rmdir()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device /dev/full on this system")
def test_results_that_cannot_be_written_to_standard_output() -> None:
    with Path("/dev/full").open("w") as full:
        done = handsim("recordings", "info", stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr.startswith("handsim: standard output: cannot be written (No space")
    assert done.stderr.count("\n") == 1

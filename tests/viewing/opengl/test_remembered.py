"""What renders is found out once a machine, and again when what it depends on changes."""

from collections.abc import Callable
from pathlib import Path

import pytest

from handsim.viewing.opengl import backend as gl
from handsim.viewing.opengl import remembered as memory
from handsim.viewing.opengl.backend import ProbeResult


class Machine:
    """A machine whose drivers, devices and versions are made up, and what is tried on it."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.patch, self.works, self.tried = patch, "osmesa", list[str]()
        self.drivers, self.devices = folder / "drivers", folder / "devices"
        self.drivers.mkdir()
        self.devices.mkdir()
        (self.drivers / "libEGL.so.1").write_bytes(b"one")
        (self.drivers / "libother.so.1").write_bytes(b"one")
        self.cache = folder / "cache"
        patch.setenv("XDG_CACHE_HOME", str(self.cache))
        patch.setenv("MUJOCO_GL", "")  # so that what is chosen is forgotten afterwards
        patch.setattr(memory, "_LIBRARIES", (str(self.drivers),))
        patch.setattr(memory, "_DEVICES", (str(self.devices),))
        patch.setattr(gl.platform, "system", lambda: "Linux")
        patch.setattr(gl, "probe", self.probe)

    def probe(self, backend: str, seconds: float = 0.3) -> ProbeResult:
        self.tried.append(backend)
        return ProbeResult(backend, backend == self.works, reason="no library")

    def next_command(self) -> tuple[str, int]:
        """The backend that a new process chooses, and how many it has to try for that."""
        self.tried.clear()
        self.patch.delenv("MUJOCO_GL", raising=False)
        gl._first_that_renders.cache_clear()
        chosen = gl.choose_backend()
        gl._first_that_renders.cache_clear()
        return chosen, len(self.tried)

    @property
    def files(self) -> list[Path]:
        return [path for path in self.cache.rglob("*") if path.is_file()]


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Machine:
    return Machine(tmp_path, monkeypatch)


def test_it_is_tried_once_a_machine(machine: Machine) -> None:
    assert machine.next_command() == ("osmesa", 2)
    assert [machine.next_command() for _ in range(2)] == [("osmesa", 0)] * 2
    assert len(machine.files) == 1


def another_library(machine: Machine) -> None:
    (machine.drivers / "libOSMesa.so.8").write_bytes(b"new")


def another_version_of_it(machine: Machine) -> None:
    (machine.drivers / "libEGL.so.1").write_bytes(b"longer")


def another_mujoco(machine: Machine) -> None:
    machine.patch.setattr(memory, "version", lambda package: "9.9")


def another_variable(machine: Machine) -> None:
    machine.patch.setenv("MUJOCO_EGL_DEVICE_ID", "3")


def another_device(machine: Machine) -> None:
    (machine.devices / "card7").symlink_to("/dev/null")


@pytest.mark.parametrize(
    "change",
    [another_library, another_version_of_it, another_mujoco, another_variable, another_device],
)
def test_it_is_tried_again_when_something_changed(
    machine: Machine, change: Callable[[Machine], None]
) -> None:
    machine.next_command()
    change(machine)
    machine.works = "egl"
    assert machine.next_command() == ("egl", 1)
    assert machine.next_command() == ("egl", 0)


def test_what_has_nothing_to_do_with_it_does_not_count(machine: Machine) -> None:
    machine.next_command()
    (machine.drivers / "libother.so.1").write_bytes(b"longer")
    machine.patch.setenv("EDITOR", "another")
    assert machine.next_command() == ("osmesa", 0)


@pytest.mark.parametrize(
    "damage", [b"", b"{", b"[1]", b'{"backend": 3}', b'{"backend": "rm -rf"}', b"\xff\xfe"]
)
def test_a_damaged_file_is_no_memory(machine: Machine, damage: bytes) -> None:
    machine.next_command()
    machine.files[0].write_bytes(damage)
    assert machine.next_command() == ("osmesa", 2)
    assert machine.next_command() == ("osmesa", 0)


def test_a_folder_that_cannot_be_made_costs_no_more_than_the_trial(machine: Machine) -> None:
    machine.cache.write_text("a file in its place")
    assert machine.next_command() == machine.next_command() == ("osmesa", 2)


def test_a_user_without_a_home_gets_no_folder(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert machine.next_command() == ("osmesa", 2)
    assert not list((tmp_path / "here").iterdir())


def test_what_renders_nothing_is_tried_each_time(machine: Machine) -> None:
    machine.works = "neither"
    for _ in range(2):
        with pytest.raises(gl.MissingToolError):
            machine.next_command()
        assert machine.tried == ["egl", "osmesa"]
    assert not machine.files


def test_what_does_not_open_any_more_is_forgotten(machine: Machine) -> None:
    machine.next_command()
    machine.works = "neither"
    error = gl.does_not_open("osmesa", RuntimeError("no device"))
    assert "no OpenGL backend renders" in str(error)
    assert not machine.files
    machine.works = "egl"
    assert machine.next_command() == ("egl", 1)

"""The wheel, installed where there is no checkout, does what the checkout does."""

import json
import os
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from .interpreters import ROOT, find_interpreter, stated_versions


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    call(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=ROOT)
    (path,) = folder.glob("*.whl")
    return path


def call(*command: object, cwd: Path) -> str:
    """Run a command with nothing of this environment but the path to programs."""
    environment = {name: os.environ[name] for name in ("PATH", "MUJOCO_GL") if name in os.environ}
    done = subprocess.run(
        [*map(str, command)], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def fresh_environment(folder: Path, interpreter: str = sys.executable) -> Path:
    """Make an environment; return the folder of its programs."""
    call(interpreter, "-m", "venv", "--without-pip", folder, cwd=folder.parent)
    return folder / "bin"


def interpreter_of(version: str) -> str:
    """A Python of a version such as 3.12."""
    return find_interpreter(version) or pytest.skip(f"there is no Python {version} here")


@pytest.fixture(scope="module")
def programs(wheel, tmp_path_factory) -> Path:
    """The wheel in an environment that shares the dependencies of this one, but no checkout."""
    folder = tmp_path_factory.mktemp("env")
    programs = fresh_environment(folder)
    python = programs / "python"
    options = ("--no-deps", "--no-index", "--quiet", "--disable-pip-version-check")
    call(sys.executable, "-m", "pip", "--python", python, "install", *options, wheel, cwd=folder)
    own = Path(call(python, "-c", "import sysconfig as s; print(s.get_path('purelib'))", cwd=folder)
               .strip())  # fmt: skip
    # A folder that a .pth file adds comes last, and .pth files in it (that of the checkout) are
    # not followed.
    (own / "shared.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return programs


def test_the_wheel_carries_models_and_assets_and_no_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for folder in ("handsim/_data/models/hand/", "handsim/_data/assets/experiments/"):
        assert any(name.startswith(folder) for name in names)
    for file in ("assets/controller.npz", "models/hand/right_hand.xml"):
        assert f"handsim/_data/{file}" in names
    assert "handsim/__init__.pyi" in names
    assert not [name for name in names if name.startswith("tests") or "__pycache__" in name]
    assert not [name for name in names if "/pictures/" in name], "nothing but the README shows them"


def test_the_source_archive_is_the_checkout(tmp_path):
    """What `make setup`, `make test` and `make docs` need is in it."""
    tracked = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if tracked.returncode or not (ROOT / ".git").exists():
        pytest.skip("no checkout of git")
    call(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path, cwd=ROOT)
    (path,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    files = {name for name in tracked.stdout.split("\0") if name and (ROOT / name).is_file()}
    assert files - held == set()
    assert not [name for name in held if "__pycache__" in name or name.startswith("docs/api/")]


def test_the_versions_stated_are_those_that_pip_lets_in() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert stated_versions() == ["3.11", "3.12", "3.13"]
    assert project["requires-python"] == f">={stated_versions()[0]}"


def test_this_interpreter_is_found_and_others_are_asked_for_their_version() -> None:
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    found = find_interpreter(version)
    assert found is None or call(found, "--version", cwd=ROOT).startswith(f"Python {version}.")
    assert find_interpreter("3.0") is None


def check_installed(programs: Path, folder: Path) -> None:
    where = call(programs / "python", "-c", "import handsim; print(handsim.__file__)", cwd=folder)
    assert str(ROOT) not in where
    handsim = programs / "handsim"
    grasp = ("grasp", "demonstrator", "--task", "cube-raise", "-o", "out", "--json")
    assert json.loads(call(handsim, *grasp, cwd=folder))["nominal_success"] is True
    small = ("--size", "64x48", "--postures", "2")
    call(handsim, "render", "out/cube-raise.npz", "-o", "sheet.png", *small, cwd=folder)
    assert (folder / "sheet.png").stat().st_size > 500
    call(handsim, "postures", "--task", "cube-raise", "-o", "postures.csv", cwd=folder)
    record = "from handsim.baseline.check import *; from handsim.baseline import *; import handsim;"
    record += "c = handsim.GraspController.load(handsim.data_folder('assets') / 'controller.npz');"
    record += "write_baseline(record_baseline(c), 'b.npz')"
    call(programs / "python", "-c", record, cwd=folder)
    said = json.loads(call(handsim, "baseline", "check", "b.npz", "--json", cwd=folder))
    assert said["ok"] is True
    assert said["answers"]


@pytest.mark.ci
@pytest.mark.slow
def test_installed_it_grasps_draws_and_checks(programs, tmp_path):
    check_installed(programs, tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("version", stated_versions())
def test_installed_with_its_own_dependencies(wheel, tmp_path, version):
    """As a user installs it: what pip brings along is enough."""
    programs = fresh_environment(tmp_path / "env", interpreter_of(version))
    options = ("--quiet", "--no-cache-dir", "--disable-pip-version-check")
    python = programs / "python"
    call(sys.executable, "-m", "pip", "--python", python, "install", *options, wheel, cwd=tmp_path)
    check_installed(programs, tmp_path)

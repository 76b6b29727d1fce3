"""What MUJOCO_GL may say is what MuJoCo itself takes."""

import importlib
import os
import platform
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from handsim.errors import UnknownNameError
from handsim.viewing.opengl.setting import BACKENDS, OFF, ON, check_import, named_backend

HERE = BACKENDS.get(platform.system(), ())


def mujoco_takes(said: str, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Run again what MuJoCo does with the variable when it is imported."""
    try:
        module = importlib.import_module("mujoco.rendering.classic.gl_context")
    except ImportError:  # before MuJoCo 4
        module = importlib.import_module("mujoco.gl_context")
    monkeypatch.setenv("MUJOCO_GL", said)
    try:
        runpy.run_path(str(module.__file__))
    except RuntimeError as error:
        return "invalid value" not in str(error)
    except (ImportError, AttributeError):  # taken, but its library is not here
        return True
    return True


@pytest.mark.parametrize("said", [*OFF, *ON, *HERE, "", " OFF ", "Egl", "cgl", "wgl", "nonsense"])
def test_it_is_taken_here_where_mujoco_takes_it(said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    taken = mujoco_takes(said, monkeypatch)
    monkeypatch.setenv("MUJOCO_GL", said)
    try:
        named_backend()
        assert taken
    except UnknownNameError:
        assert not taken


def test_what_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    for said, meant in (("", ""), ("1", ""), ("0", None), ("off", None), (" GLX ", "glx")):
        monkeypatch.setenv("MUJOCO_GL", said)
        assert named_backend() == meant
    monkeypatch.delenv("MUJOCO_GL")
    assert named_backend() == ""


def test_backends_of_other_systems_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "cgl")
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    with pytest.raises(UnknownNameError, match=r"in MUJOCO_GL 'cgl'; did you mean .*egl"):
        check_import()
    monkeypatch.setattr(platform, "system", lambda: "Darwin")
    assert named_backend() == "cgl"


def test_a_backend_that_keeps_mujoco_from_being_imported(tmp_path: Path) -> None:
    """A library that is not there stands for OSMesa's."""
    (tmp_path / "mujoco.py").write_text("None.glGetError")
    code = (
        "import sys\nfrom handsim.errors import MissingToolError\n"
        "from handsim.viewing.opengl.setting import check_import\n"
        "try:\n    check_import()\nexcept MissingToolError as error:\n    print(error)"
    )
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{code}"],
        env=os.environ | {"MUJOCO_GL": HERE[0]}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert f"MUJOCO_GL={HERE[0]} (its library is not installed)" in done.stdout
    assert "unset it, or set it to disable" in done.stdout
    assert done.stdout.count("\n") == 1

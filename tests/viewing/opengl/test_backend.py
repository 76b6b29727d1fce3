import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from handsim.errors import MissingToolError, RenderingError, UnknownNameError
from handsim.viewing.opengl import backend as gl
from handsim.viewing.opengl.backend import ProbeResult


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[pytest.MonkeyPatch]:
    """No backend chosen yet, whatever was chosen before this test."""
    monkeypatch.setenv("MUJOCO_GL", "")  # so that what is chosen is forgotten afterwards
    monkeypatch.delenv("MUJOCO_GL")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(gl.platform, "system", lambda: "Linux")
    gl._first_that_renders.cache_clear()
    yield monkeypatch
    gl._first_that_renders.cache_clear()


def probing(works: str | None, calls: list[str]) -> Callable[..., ProbeResult]:
    def probe(backend: str, seconds: float = 0.3) -> ProbeResult:
        calls.append(backend)
        return ProbeResult(backend, backend == works, reason="no library")

    return probe


def test_takes_the_first_that_renders_and_says_so_in_the_environment(
    fresh: pytest.MonkeyPatch,
) -> None:
    calls: list[str] = []
    fresh.setattr(gl, "probe", probing("osmesa", calls))
    assert gl.choose_backend() == "osmesa"
    assert calls == ["egl", "osmesa"]
    assert gl.os.environ["MUJOCO_GL"] == "osmesa"


def test_probes_once_a_process(fresh: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    fresh.setattr(gl, "probe", probing("egl", calls))
    for _ in range(3):
        fresh.delenv("MUJOCO_GL", raising=False)
        assert gl.choose_backend() == "egl"
    assert calls == ["egl"]


def test_environment_is_respected_without_probing(fresh: pytest.MonkeyPatch) -> None:
    fresh.setattr(gl, "probe", lambda *_: pytest.fail("probed"))
    fresh.setenv("MUJOCO_GL", "OSMesa")
    assert gl.choose_backend() == "osmesa"


def test_named_backend_without_its_library(fresh: pytest.MonkeyPatch) -> None:
    def no_library(name: str) -> None:
        raise AttributeError("'NoneType' object has no attribute 'glGetError'")

    fresh.setenv("MUJOCO_GL", "osmesa")
    fresh.setattr(gl, "probe", probing("egl", []))
    fresh.setattr(gl.importlib, "import_module", no_library)
    with pytest.raises(MissingToolError) as raised:
        gl.choose_backend()
    assert "'osmesa' does not open (its library is not installed)" in str(raised.value)
    assert "unset MUJOCO_GL to draw with egl, which renders here" in str(raised.value)
    assert str(raised.value).endswith(gl.install_command("osmesa"))


def test_unknown_name_in_the_environment(fresh: pytest.MonkeyPatch) -> None:
    fresh.setenv("MUJOCO_GL", "osmeza")
    with pytest.raises(UnknownNameError, match=r"MUJOCO_GL 'osmeza'; did you mean osmesa"):
        gl.choose_backend()


@pytest.mark.parametrize(
    ("manager", "root", "command"),
    [
        ("apt-get", 0, "apt-get update && apt-get install -y libosmesa6"),
        ("apt-get", 1000, "sudo apt-get update && sudo apt-get install -y libosmesa6"),
        ("dnf", 0, "dnf install -y mesa-libOSMesa"),
    ],
)
def test_nothing_renders_names_the_command(
    fresh: pytest.MonkeyPatch, manager: str, root: int, command: str
) -> None:
    fresh.setattr(gl, "probe", probing(None, []))
    fresh.setattr(gl.shutil, "which", lambda name: name if name == manager else None)
    fresh.setattr(gl.os, "geteuid", lambda: root)
    with pytest.raises(MissingToolError) as raised:
        gl.choose_backend()
    assert str(raised.value).endswith(f"run: {command}")
    assert "egl: no library; osmesa: no library" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_probe_really_renders(rendering: str) -> None:
    result = gl.probe(rendering, seconds=0.1)
    assert result.ok, result.reason
    assert result.driver
    assert result.frames_per_second is not None
    assert result.frames_per_second > 1


def test_probe_does_not_take_a_blank_frame_for_rendering(
    rendering: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    source = Path(gl.__file__).with_name("probe.py").read_text()
    scene = source.index("<mujoco>"), source.index("</mujoco>")
    (tmp_path / "probe.py").write_text(source[: scene[0]] + "<mujoco>" + source[scene[1] :])
    monkeypatch.setattr(gl, "__file__", str(tmp_path / "gl.py"))
    result = gl.probe(rendering, seconds=0.0)
    assert not result.ok
    assert "blank" in result.reason


def test_probe_reports_what_failed() -> None:
    result = gl.probe("cgl" if sys.platform == "linux" else "osmesa", seconds=0.0)
    assert not result.ok
    assert result.reason
    assert not result.driver


def test_probe_gives_up_on_a_driver_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl, "PROBE_TIMEOUT_S", 0.01)
    result = gl.probe("egl")
    assert not result.ok
    assert "no frame within" in result.reason


def test_probe_survives_a_driver_that_aborts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    script = tmp_path / "probe.py"
    script.write_text("import os; os.abort()")
    monkeypatch.setattr(gl, "__file__", str(tmp_path / "gl.py"))
    result = gl.probe("egl")
    assert not result.ok
    assert "died" in result.reason


def failing(name: str) -> None:
    raise RuntimeError("no device\nsecond line")


def test_backend_that_does_not_open_is_named_with_its_remedy(fresh: pytest.MonkeyPatch) -> None:
    fresh.setattr(gl, "probe", probing(None, []))
    fresh.setattr(gl, "_opened", failing)
    fresh.setenv("MUJOCO_GL", "egl")
    fresh.setattr(gl, "note_rendering", lambda: None)
    with (
        pytest.raises(
            MissingToolError, match=r"does not open \(no device\); unset MUJOCO_GL"
        ) as got,
        gl.gl_context(),
    ):
        pass
    assert "no OpenGL backend renders (egl: no library; osmesa: no library)" in str(got.value)
    assert str(got.value).endswith(gl.install_command("egl"))
    assert "\n" not in str(got.value)


@pytest.mark.parametrize("backend", ["glfw", "glx", " GLFW "])
def test_windows_without_a_display_are_refused_before_anything_is_drawn(
    fresh: pytest.MonkeyPatch, backend: str
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        fresh.delenv(variable, raising=False)
    if not sys.platform.startswith("linux"):
        pytest.skip("windows can be opened without a display server's name elsewhere")
    fresh.setattr(gl, "probe", probing("osmesa", []))
    fresh.setenv("MUJOCO_GL", backend)
    name = backend.strip().lower()
    with pytest.raises(MissingToolError, match=rf"'{name}' does not open .*DISPLAY") as raised:
        gl.choose_backend()
    assert "unset MUJOCO_GL to draw with osmesa, which renders here" in str(raised.value)
    assert str(raised.value).endswith("or start it where there is a display")


def test_a_window_that_does_not_open_is_no_context(fresh: pytest.MonkeyPatch) -> None:
    class Nothing:
        def __init__(self, *size: int) -> None:
            self._context = None

    fresh.setattr(gl, "_start_windows", lambda: None)
    fresh.setattr(gl, "note_rendering", lambda: None)
    fresh.setattr(gl, "probe", probing("egl", []))
    fresh.setenv("MUJOCO_GL", "glx")
    fresh.setattr("mujoco.glfw.GLContext", Nothing)
    with pytest.raises(MissingToolError, match=r"'glx' does not open \(no window"), gl.gl_context():
        pass


@pytest.mark.parametrize("word", ["off", "Disable", "0", "false", "disabled"])
def test_rendering_that_is_turned_off_says_so(fresh: pytest.MonkeyPatch, word: str) -> None:
    fresh.setattr(gl, "probe", probing("egl", []))
    fresh.setenv("MUJOCO_GL", word)
    with pytest.raises(
        RenderingError, match=rf"MUJOCO_GL={word} turns rendering off; unset .* egl"
    ):
        gl.choose_backend()


@pytest.mark.parametrize("word", ["on", "Enable", "1", "true", "enabled"])
def test_rendering_that_is_turned_on_leaves_the_choice_open(
    fresh: pytest.MonkeyPatch, word: str
) -> None:
    fresh.setattr(gl, "probe", probing("osmesa", []))
    fresh.setenv("MUJOCO_GL", word)
    assert gl.choose_backend() == "osmesa"
    assert gl.os.environ["MUJOCO_GL"] == "osmesa"


def test_choosing_costs_nothing_before_it_is_asked_for() -> None:
    code = "import sys, handsim.viewing.opengl.backend; sys.exit('mujoco' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("driver", "software"),
    [("llvmpipe (LLVM 15.0.6, 256 bits)", True), ("NVIDIA A100/PCIe/SSE2", False), ("", False)],
)
def test_software_drivers_are_told_apart(driver: str, software: bool) -> None:
    assert gl.is_software(driver) is software

"""The choice of an OpenGL backend that really renders on this machine.

On a machine without a display MuJoCo renders through EGL or through OSMesa, whichever is installed
and works. That cannot be told from the files present, and a failed attempt spoils the process it
is made in; so each backend renders a frame in a child process, and the first that does is used.
Nothing here is paid for by a command that does not render. What rendered is remembered
(`opengl.remembered`), so that the next command need not try again.
"""

import functools
import importlib
import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from handsim.errors import MissingToolError, RenderingError
from handsim.viewing.opengl.forking import check_not_forked, note_rendering
from handsim.viewing.opengl.remembered import forget, remember, remembered
from handsim.viewing.opengl.setting import VARIABLE, named_backend, reason_of

PROBE_TIMEOUT_S = 60.0
"""A driver that hangs is given up after this time [s]; a cold start takes about 1.5 s."""
SOFTWARE_DRIVERS = ("llvmpipe", "softpipe", "swrast", "software", "swiftshader")
_CANDIDATES = {"Linux": ("egl", "osmesa"), "Darwin": ("cgl",), "Windows": ("glfw",)}
_WINDOWED = ("glfw", "glx", "wgl")
_MODULES = {"glx": "glfw", "wgl": "glfw"}
_PACKAGES = {
    "apt-get": {"egl": "libegl1 libgl1-mesa-dri libopengl0", "osmesa": "libosmesa6"},
    "dnf": {"egl": "mesa-libEGL mesa-dri-drivers libglvnd-opengl", "osmesa": "mesa-libOSMesa"},
}
_INSTALL = {
    "apt-get": "{root}apt-get update && {root}apt-get install -y {package}",
    "dnf": "{root}dnf install -y {package}",
}


@dataclass(frozen=True)
class ProbeResult:
    """Result of rendering one frame in a child process.

    Attributes
    ----------
    backend
        The value of MUJOCO_GL that was tried.
    ok
        A frame that is not blank came back.
    driver
        GL_RENDERER of the driver; empty when nothing rendered.
    frames_per_second
        Small test scene, 320 x 240; None unless it was timed.
    reason
        Why nothing rendered; empty when it did.
    """

    backend: str
    ok: bool
    driver: str = ""
    frames_per_second: float | None = None
    reason: str = ""


def probe(backend: str, seconds: float = 0.3) -> ProbeResult:
    """Render with a backend in a child process, which takes 0.6 to 2 s.

    Parameters
    ----------
    backend
        Value for MUJOCO_GL.
    seconds
        How long to render for the frame rate [s]; 0 renders one frame and times nothing.
    """
    script = Path(__file__).with_name("probe.py")
    command = [sys.executable, "-P", str(script), backend, str(seconds)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=PROBE_TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return ProbeResult(backend, False, reason=f"gave no frame within {PROBE_TIMEOUT_S:.0f} s")
    lines = done.stdout.strip().splitlines()
    if not lines:
        last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
        return ProbeResult(backend, False, reason=f"the process that tried it died: {last[0]}")
    return ProbeResult(backend=backend, **json.loads(lines[-1]))


def choose_backend() -> str:
    """Return the backend to render with, and set MUJOCO_GL to it.

    A backend that MUJOCO_GL names is respected; call this before MuJoCo is imported, which fails
    when the one named there is not installed. Otherwise the first of EGL and OSMesa that renders a
    frame is taken; what rendered once on this machine is not tried again.

    Raises
    ------
    UnknownNameError
        If MUJOCO_GL says nothing that MuJoCo takes on this system.
    RenderingError
        If MUJOCO_GL turns rendering off, or this process was forked from one that has rendered.
    MissingToolError
        If nothing renders, or the backend that MUJOCO_GL names does not open, with the command
        that installs what is missing.
    """
    check_not_forked()
    wanted = named_backend()
    if wanted is None:
        said = os.environ[VARIABLE].strip()
        raise RenderingError(f"{VARIABLE}={said} turns rendering off; {_another()}")
    if wanted:
        try:
            importlib.import_module("mujoco")
            if wanted in _WINDOWED:
                _start_windows()
        except Exception as error:  # ImportError, AttributeError, RuntimeError, GLFWError
            raise does_not_open(wanted, error) from error
        return wanted
    chosen = _first_that_renders()
    os.environ[VARIABLE] = chosen
    return chosen


def does_not_open(backend: str, error: Exception) -> MissingToolError:
    """Return the error of a backend that cannot be rendered with here, and what can be done.

    Where it is remembered that it renders, that is forgotten.
    """
    forget(backend)
    _first_that_renders.cache_clear()
    remedy = (
        "start it where there is a display"
        if backend in _WINDOWED
        else f"run: {install_command(backend)}"
    )
    return MissingToolError(
        f"OpenGL backend '{backend}' does not open ({reason_of(error)}); {_another()}, or {remedy}"
    )


def _another() -> str:
    """Name the backend that would render here with MUJOCO_GL unset."""
    try:
        return f"unset {VARIABLE} to draw with {_first_that_renders()}, which renders here"
    except MissingToolError as error:
        return f"unset {VARIABLE}; of the others, {error}"


def _start_windows() -> None:
    """Check that there is a display to open a window on, as GLFW needs even where none is shown.

    Raises
    ------
    RuntimeError
        If there is none.
    """
    with _quiet_glfw() as glfw:
        if not glfw.init():
            _, text = glfw.get_error()
            words = text.decode() if isinstance(text, bytes) else str(text or "")
            raise RuntimeError(words or "there is no display")


@contextmanager
def _quiet_glfw() -> Generator[Any, None, None]:
    """Yield the GLFW module with its warnings turned off."""
    glfw: Any = importlib.import_module("glfw")
    usual, glfw.ERROR_REPORTING = glfw.ERROR_REPORTING, "ignore"
    try:
        yield glfw
    finally:
        glfw.ERROR_REPORTING = usual


@functools.cache
def _first_that_renders() -> str:
    reasons: list[str] = []
    candidates = _CANDIDATES.get(platform.system(), ("glfw",))
    known = remembered(candidates)
    if known is not None:
        return known
    for backend in candidates:
        result = probe(backend, seconds=0.0)
        if result.ok:
            remember(backend)
            return backend
        reasons.append(f"{backend}: {result.reason}")
    raise MissingToolError(
        f"no OpenGL backend renders ({'; '.join(reasons)}); run: {install_command(candidates[-1])}"
    )


class GLContext(Protocol):
    """The methods that MuJoCo's context classes have in common."""

    def make_current(self) -> None:
        """Direct what this thread draws to this context."""
        ...

    def free(self) -> None:
        """Give the context back to the driver."""
        ...


@contextmanager
def gl_context() -> Generator[GLContext, None, None]:
    """Open the process's OpenGL context, make it current, and free it at the end.

    Raises
    ------
    UnknownNameError, RenderingError, MissingToolError
        As in `choose_backend`, or if the context cannot be opened.
    """
    backend = choose_backend()
    note_rendering()
    try:
        context = _opened(backend)
        context.make_current()
    except Exception as error:  # ImportError, AttributeError, RuntimeError, GLError, OSError
        raise does_not_open(backend, error) from error
    try:
        yield context
    finally:
        context.free()


def _opened(backend: str) -> Any:
    """Return a new context of a backend; frames are drawn off screen, in buffers of their own."""
    if backend in ("egl", "osmesa"):  # else PyOpenGL may load for a backend set earlier
        os.environ["PYOPENGL_PLATFORM"] = backend
    # The class is taken from the backend's own module since mujoco.GLContext is fixed when
    # mujoco is imported, which may have been before a backend was chosen.
    module = importlib.import_module(f"mujoco.{_MODULES.get(backend, backend)}")
    if backend not in _WINDOWED:
        return module.GLContext(16, 16)
    with _quiet_glfw():
        context = module.GLContext(16, 16)
    if not context._context:  # GLFW returns nothing where it cannot open a window
        raise RuntimeError("no window can be opened on the display")
    return context


def driver_name() -> str:
    """Return GL_RENDERER of the context that is current, '' where it cannot be read."""
    with suppress(Exception):  # PyOpenGL raises many classes; the name is only a hint
        from OpenGL import GL

        name: Any = GL.glGetString(GL.GL_RENDERER)
        return name.decode() if isinstance(name, bytes) else ""
    return ""


def is_software(driver: str) -> bool:
    """Tell whether a driver draws on the CPU, where shadows cost more than all the rest."""
    return any(name in driver.lower() for name in SOFTWARE_DRIVERS)


def install_command(backend: str) -> str:
    """Return the command that installs a backend with this machine's package manager."""
    manager = next((name for name in _INSTALL if shutil.which(name)), "apt-get")
    package = _PACKAGES[manager].get(backend, "libgl1")
    root = "" if hasattr(os, "geteuid") and os.geteuid() == 0 else "sudo "
    return _INSTALL[manager].format(root=root, package=package)

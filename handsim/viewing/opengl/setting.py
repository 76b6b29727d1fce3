"""The value of the environment variable MUJOCO_GL.

MuJoCo reads it when it is imported. It takes the names of this system's backends and words that
turn rendering on or off, and refuses all other values.
"""

import importlib
import os
import platform

from handsim.errors import MissingToolError, UnknownNameError

VARIABLE = "MUJOCO_GL"
OFF = ("disable", "disabled", "off", "false", "0")
"""Words with which MuJoCo is imported without OpenGL."""
ON = ("enable", "enabled", "on", "true", "1")
"""Words that leave the choice of the backend to MuJoCo."""
BACKENDS = {
    "Linux": ("egl", "osmesa", "glfw", "glx"),
    "Darwin": ("cgl", "glfw"),
    "Windows": ("glfw", "wgl"),
}
"""Names of backends that MuJoCo takes on each system."""


def named_backend() -> str | None:
    """Return the backend that MUJOCO_GL names, '' where it leaves it open, None for rendering off.

    Raises
    ------
    UnknownNameError
        If it says nothing that MuJoCo takes on this system.
    """
    said = os.environ.get(VARIABLE, "").strip().lower()
    backends = BACKENDS.get(platform.system(), ("glfw",))
    if said in backends:
        return said
    if said in OFF:
        return None
    if said and said not in ON:
        raise UnknownNameError(f"OpenGL backend in {VARIABLE}", said, (*backends, OFF[0]))
    return ""


def check_import() -> None:
    """Check that MuJoCo can be imported with what MUJOCO_GL says, whether it renders or not.

    Raises
    ------
    UnknownNameError
        If it says nothing that MuJoCo takes on this system.
    MissingToolError
        If the backend that it names keeps MuJoCo from being imported, as OSMesa without its
        library does.
    """
    backend = named_backend()
    if not backend:
        return
    try:
        importlib.import_module("mujoco")
    except Exception as error:  # ImportError, AttributeError, RuntimeError
        raise MissingToolError(
            f"MuJoCo cannot be imported with {VARIABLE}={backend} ({reason_of(error)}); unset it, "
            f"or set it to {OFF[0]} where nothing is drawn"
        ) from error


def reason_of(error: Exception) -> str:
    """Return in one line why a backend does not open."""
    lines = str(error).strip().splitlines()
    # PyOpenGL looks up its functions in None when it has found no library.
    no_library = isinstance(error, AttributeError) or not lines
    return "its library is not installed" if no_library else lines[0]

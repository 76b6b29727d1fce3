"""Which backend renders on this machine, remembered from one command to the next.

To find out takes a process of its own and a second. The answer lies in the user's folder for such
things (``~/.cache/handsim`` on Linux), in a file that is named after all that it depends on as far
as can be told without trying. Where that changes, there is no such file, and it is tried again.
Where the folder cannot be written or the file is damaged, it is tried each time.
"""

import hashlib
import json
import os
import platform
import stat
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from handsim.errors import HandsimError
from handsim.viewing.opengl.setting import VARIABLE

_PACKAGES = ("handsim", "mujoco", "pyopengl", "glfw")
_VARIABLES = (
    "CUDA_", "DISPLAY", "DRI_", "EGL_", "GALLIUM_", "GBM_", "LD_", "LIBGL_", "MESA_", "MUJOCO_",
    "NVIDIA_", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR", "__EGL_", "__GL",
)  # fmt: skip
"""How the variables begin that drivers and their loaders read."""
_LIBRARIES = ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/usr/lib/{machine}-linux-gnu")
_NAMED = ("libEGL", "libGL", "libOSMesa", "libOpenGL", "libgallium", "libgbm", "libnvidia")
_DRIVERS = (
    *(f"{folder}/dri" for folder in _LIBRARIES),
    "/usr/share/glvnd/egl_vendor.d", "/etc/glvnd/egl_vendor.d",
)  # fmt: skip
"""Folders in which every file counts."""
_DEVICES = ("/dev", "/dev/dri")
_OF_GRAPHICS = ("card", "render", "nvidia", "dxg")


def remembered(candidates: tuple[str, ...]) -> str | None:
    """Return the backend that rendered here before, None where that is not known.

    Parameters
    ----------
    candidates
        Those that may be; another name in the file is not believed.
    """
    with suppress(OSError, ValueError, KeyError, TypeError):
        backend = json.loads(_file().read_text(encoding="utf-8"))["backend"]
        return backend if backend in candidates else None
    return None


def remember(backend: str) -> None:
    """Keep which backend renders here, where it can be kept."""
    from handsim.files import write_text

    with suppress(OSError, HandsimError):
        path = _file()
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, json.dumps({"backend": backend}) + "\n")


def forget(backend: str) -> None:
    """Let it be tried again, where it is this one that rendered before and does not any more."""
    with suppress(OSError):
        if remembered((backend,)) is not None:
            _file().unlink(missing_ok=True)


def _file() -> Path:
    """Return the file of this state of this machine.

    Raises
    ------
    OSError
        If the user has no home.
    """
    from platformdirs import user_cache_path

    try:
        folder = user_cache_path("handsim", appauthor=False)
    except RuntimeError as error:
        raise OSError(str(error)) from error
    if not folder.is_absolute():
        raise OSError(f"{folder}: the user has no home")
    key = hashlib.sha256("\n".join(_key()).encode(errors="surrogateescape")).hexdigest()
    return folder / "opengl" / f"{key[:24]}.json"


def _key() -> Iterator[str]:
    """Return a line for each thing on which it depends what renders."""
    yield " ".join((*platform.uname()[:5], sys.prefix, sys.version))
    yield str(os.getuid() if hasattr(os, "getuid") else "")
    for package in _PACKAGES:
        with suppress(PackageNotFoundError):
            yield f"{package} {version(package)}"
    for name in sorted(os.environ):
        if name.startswith(_VARIABLES) and name != VARIABLE:  # each attempt sets that one itself
            yield f"{name}={os.environ[name]}"
    own = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    for folder in (*filter(None, own), *_LIBRARIES):
        yield from _entries(folder, _NAMED)
    for folder in _DRIVERS:
        yield from _entries(folder, ("",))
    for folder in _DEVICES:
        yield from _entries(folder, _OF_GRAPHICS)


def _entries(folder: str, beginnings: tuple[str, ...]) -> Iterator[str]:
    """Return a line for each file and device of a folder whose name begins so."""
    try:
        files = Path(folder.format(machine=platform.machine())).iterdir()
        named = sorted(path for path in files if path.name.startswith(beginnings))
    except OSError:
        return
    for path in named:
        with suppress(OSError):
            state = path.stat()
            if stat.S_ISREG(state.st_mode):
                yield f"{path} {state.st_size} {state.st_mtime_ns}"
            else:  # the times of a device say nothing; whether this user may use it does
                yield f"{path} {state.st_rdev} {os.access(path, os.R_OK | os.W_OK)}"

"""Rendering in a process that was forked from one that has rendered: an error instead of a hang.

Threads and locks of an OpenGL driver are not carried over a fork. A child process that renders
waits for them forever and prints nothing. This module recognises such a child, so that it raises an
error that names the remedy.
"""

import os
import sys

from handsim.errors import RenderingError


class _Rendering:
    """Whether this process has opened OpenGL, and whether the one that it was forked from had."""

    def __init__(self) -> None:
        self.opened = False
        self.parent: int | None = None

    def forked(self) -> None:
        """Remember in a child process that OpenGL was open when it was forked."""
        # MuJoCo's own renderer, used without handsim, leaves this display open.
        display = getattr(sys.modules.get("mujoco.egl"), "EGL_DISPLAY", None)
        if self.opened or display is not None:
            self.parent = os.getppid()


_rendering = _Rendering()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_rendering.forked)


def note_rendering() -> None:
    """Remember that this process opens OpenGL."""
    _rendering.opened = True


def check_not_forked() -> None:
    """Check that OpenGL was not open when this process was forked.

    Raises
    ------
    RenderingError
        If it was.
    """
    if _rendering.parent is not None:
        raise RenderingError(
            f"process {os.getpid()} was forked from process {_rendering.parent}, which had "
            "rendered before, and would hang if it rendered too; start it by "
            "multiprocessing.get_context('spawn') or 'forkserver'"
        )

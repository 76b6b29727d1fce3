"""Keep MuJoCo's warnings from the terminal and from a log file for a while.

MuJoCo has one handler of warnings for the whole process, which every thread shares. So those
inside are counted: the first puts a handler that hears nothing in its place, the last one puts the
user's own back, in whatever order they leave.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import threading
import warnings
from collections.abc import Callable, Generator
from contextlib import ContextDecorator, contextmanager

import mujoco

Handler = Callable[[str], None]


class silent(ContextDecorator):  # noqa: N801, it is used as a function
    """Keep MuJoCo from telling the terminal and a log file what the outcome will tell.

    Any number of threads may be inside at once, and one of them more than once. A handler that is
    set meanwhile by somebody else is not touched on leaving.
    """

    def __enter__(self) -> None:
        """Begin to keep silent."""
        _quiet.enter()

    def __exit__(self, *error: object) -> None:
        """Let the user's own handler hear again."""
        _quiet.leave()


class _Quiet:
    """How many are inside, and whose handler waits to be put back."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._kept: Handler | None = None

    def enter(self) -> None:
        with self._lock:
            current = mujoco.get_mju_user_warning()
            if current is not _unheard:  # the first inside, or somebody has set one meanwhile
                self._kept = current
                mujoco.set_mju_user_warning(_unheard)
            self._inside += 1

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and mujoco.get_mju_user_warning() is _unheard:
                mujoco.set_mju_user_warning(self._kept)
                self._kept = None


def _unheard(text: str) -> None:
    """Hear a warning that the outcome of the run will tell."""


_quiet = _Quiet()


@contextmanager
def unheard_warnings() -> Generator[None]:
    """Keep MuJoCo's warnings about a user's file from the terminal and from a log file."""
    with silent(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def quiet_compile(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile a spec without a word to the terminal or a log file.

    Raises
    ------
    ValueError
        As MuJoCo has it.
    """
    with unheard_warnings():
        try:
            return spec.compile()
        except mujoco.FatalError as error:
            raise ValueError(str(error)) from error

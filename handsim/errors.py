"""Errors that handsim raises on purpose.

Each message is one line that names the value, the limit it broke and the remedy. Every class
also inherits the builtin that a caller would expect, so ``except ValueError`` keeps working.
What a simulation or an integration *finds* (an object dropped, a run that does not arrive) is a
result with a reason, never an exception.
"""

from collections.abc import Generator
from contextlib import contextmanager


class HandsimError(Exception):
    """Base of all errors raised on purpose; the command line prints it as one line."""


class InputError(HandsimError, ValueError):
    """A value given by the user is outside what can be worked with."""


class FileError(InputError):
    """A file or folder is missing, foreign, damaged or of a newer schema."""


class UnknownNameError(InputError, LookupError):
    """A name is not among the known ones; the message offers the nearest."""

    def __init__(self, kind: str, name: str, known: tuple[str, ...]) -> None:
        from difflib import get_close_matches

        near = get_close_matches(name, known, n=3, cutoff=0.4) or list(known[:3])
        super().__init__(f"unknown {kind} '{name}'; did you mean {', '.join(near)}?")
        self.kind = kind
        self.name = name
        self.known = known

    def __reduce__(self) -> tuple[type, tuple[str, str, tuple[str, ...]]]:
        """Let it come through from another process."""
        return type(self), (self.kind, self.name, self.known)


class RenderingError(HandsimError, RuntimeError):
    """Nothing can be drawn in this process, whatever is installed."""


class MissingToolError(HandsimError, RuntimeError):
    """Something outside Python is not installed; the message names the command that installs it."""


@contextmanager
def quiet_logs(*loggers: str) -> Generator[None, None, None]:
    """Keep libraries from logging, in many lines, what is raised as an error of one line.

    Parameters
    ----------
    *loggers
        Their names; those below them are silent too, unless they have a level of their own.
    """
    import logging

    levels = {name: logging.getLogger(name).level for name in loggers}
    for name in loggers:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)

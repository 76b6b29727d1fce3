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


_FINGERS = {
    "pinky": "little", "pinkie": "little", "pink": "little", "small": "little", "fifth": "little",
    "forefinger": "index", "pointer": "index", "pointing": "index", "long": "middle",
    "annular": "ring", "pollex": "thumb",
}  # fmt: skip
"""What else fingers are called; no likeness of letters leads from one name to the other."""


class UnknownNameError(InputError, LookupError):
    """A name is not among the known ones; the message offers the nearest.

    Parameters
    ----------
    kind
        What the name is of.
    name
    known
        All names that there are.
    listed_by
        The command that lists them, if one does.
    """

    def __init__(self, kind: str, name: str, known: tuple[str, ...], listed_by: str = "") -> None:
        near = _nearest(name, known) or list(known[:3])
        more = f" `{listed_by}` lists all" if listed_by else ""
        super().__init__(f"unknown {kind} '{name}'; did you mean {', '.join(near)}?{more}")
        self.kind = kind
        self.name = name
        self.known = known
        self.listed_by = listed_by

    def __reduce__(self) -> tuple[type, tuple[str, str, tuple[str, ...], str]]:
        """Let it come through from another process."""
        return type(self), (self.kind, self.name, self.known, self.listed_by)


def _nearest(name: str, known: tuple[str, ...]) -> list[str]:
    """Return up to three known names that are like a name, or mean the same finger."""
    import re
    from difflib import get_close_matches

    def usual(word: re.Match[str]) -> str:
        return _FINGERS.get(word[0].lower(), word[0])

    meant = re.sub(r"[^\W\d_]+", usual, name)
    if meant in known:
        return [meant]
    ways = ((name, 0.8), (meant, 0.4))  # known names may hold such words themselves
    found = (get_close_matches(said, known, n=3, cutoff=cutoff) for said, cutoff in ways)
    return next(filter(None, found), [])


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

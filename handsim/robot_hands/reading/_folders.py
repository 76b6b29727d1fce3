"""Which files a hand may name: those of the user's folders, and no others.

They are the folder of the hand's file and what is below it, the package that it belongs to, and
folders that the user gives. A link that leads out of them is not followed.
"""

from collections.abc import Sequence
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from handsim.errors import FileError, InputError

MOST_BYTES = 64 * 2**20
"""Largest file that is read."""
_LEVELS = 4
"""How far above the file a package is looked for."""
_KINDS_OF_FOLDERS = ("urdf", "mjcf", "xml", "xacro", "robot", "robots", "description", "model")
"""Folders that by custom lie beside those of the meshes, within one package."""


class UserFolders:
    """Finds files that a hand's file names.

    Parameters
    ----------
    file
        The hand's file.
    given
        Further folders that may be read: packages, or folders that hold packages.

    Raises
    ------
    InputError
        If one of them is no folder.
    """

    def __init__(self, file: Path, given: Sequence[Path] = ()) -> None:
        self._folder = file.parent.resolve()
        for folder in given:
            if not folder.is_dir():
                raise InputError(f"{folder}: no such folder; give one that holds meshes")
        self._given = [folder.resolve() for folder in given]
        above = [self._folder, *self._folder.parents][: _LEVELS + 1]
        package = next((each for each in above if (each / "package.xml").is_file()), None)
        own = self._folder
        if own.name.lower() in _KINDS_OF_FOLDERS and own.parent != own:
            own = own.parent
        if package is not None and package.parent != package:
            own = package
        self._roots = [self._folder, own, *self._given]
        self._above = above
        self.outside: list[str] = []
        """What was named but lies outside."""

    def find(self, reference: str, within: Sequence[str] = ()) -> Path | None:
        """Return the file that a reference names, or None.

        Parameters
        ----------
        reference
            A path, or one that begins with ``package://``, ``model://`` or ``file://``.
        within
            Folders that paths are relative to besides that of the file, such as a ``meshdir``.
        """
        kind, _, rest = reference.partition("://")
        if rest and kind in ("package", "model"):
            tried = self._in_package(unquote(rest))
        else:
            path = _plain(unquote(rest) if rest and kind == "file" else reference)
            tried = [self._folder / folder / path for folder in within]
            tried += [root / path for root in self._roots]
            tried += [self._folder / folder / path.name for folder in within]
        for path in tried:
            found = self._allowed(path)
            if found is not None:
                return found
        return None

    def read(self, path: Path) -> bytes:
        """Return a file's content; an error of one line where it is missing or too large."""
        try:
            size = path.stat().st_size
            if not path.is_file() or size > MOST_BYTES:
                raise FileError(
                    f"{path}: no file of at most {MOST_BYTES >> 20} MB; give a smaller one"
                )
            return path.read_bytes()
        except OSError as error:
            raise FileError(f"{path}: not readable ({error.strerror}); check it") from error

    def _in_package(self, reference: str) -> list[Path]:
        """Return where a file of a package may be: in folders given, or found above the file."""
        package, _, rest = reference.partition("/")
        path = _plain(rest)
        if package in ("", ".", "..") or _plain(package).name != package:
            return []
        tried: list[Path] = []
        for folder in self._given:
            tried += [folder / package / path, folder / path]
        for folder in self._above:
            for home in ([folder] if folder.name == package else []) + [folder / package]:
                if home.is_dir() and self._inside(home / path, home.resolve()):
                    self._roots.append(home.resolve())
                    tried.append(home / path)
        return tried + [root / path for root in self._roots]

    def _allowed(self, path: Path) -> Path | None:
        """Return the path without links if it is a file of the user's folders."""
        try:
            if not path.is_file():
                return None
            real = path.resolve()
        except (OSError, ValueError):  # names too long, or with a null byte
            return None
        if any(self._inside(real, root) for root in self._roots):
            return real
        self.outside.append(str(path))
        return None

    @staticmethod
    def _inside(path: Path, root: Path) -> bool:
        try:
            return path.resolve().is_relative_to(root)
        except (OSError, ValueError):
            return False


def _plain(text: str) -> Path:
    """Return a path without a drive, and with this system's separators."""
    return Path(PureWindowsPath(text).as_posix()) if "\\" in text else Path(text)

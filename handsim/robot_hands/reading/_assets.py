"""The meshes that a hand's file names, gathered in memory under names of their own.

MuJoCo is given these alone, so that it opens no file itself.
"""

from collections.abc import Sequence
from pathlib import Path, PurePath

from handsim.errors import FileError
from handsim.robot_hands.reading._folders import UserFolders
from handsim.robot_hands.reading._meshes import PLACEHOLDER, as_readable

MOST_IN_ALL = 512 * 2**20
"""Most bytes of all meshes together."""


class Assets:
    """Meshes by name, as MuJoCo takes them.

    Parameters
    ----------
    folders
        Where they may be.
    broken
        Names that are given a placeholder, whatever their file holds.
    convert
        Write all meshes anew, for those that MuJoCo's own parser does not take.

    Attributes
    ----------
    content
        Bytes by name.
    missing
        References that have a placeholder, and why.
    placeholders
        Names of the meshes that are placeholders.
    """

    def __init__(
        self, folders: UserFolders, broken: frozenset[str] = frozenset(), convert: bool = False
    ) -> None:
        self.folders = folders
        self.content: dict[str, bytes] = {}
        self.missing: dict[str, str] = {}
        self.placeholders: set[str] = set()
        self._broken, self._convert = broken, convert
        self._names: dict[str, str] = {}
        self._read: dict[Path, bytes] = {}

    def mesh(self, reference: str, within: Sequence[str] = (), scale: str = "") -> str:
        """Return the name under which a mesh is in `content`, a placeholder if need be."""
        key = f"{reference} {scale}"
        if key in self._names:
            return self._names[key]
        stem = f"{len(self._names)}_{PurePath(reference).stem}"[:80]
        content, suffix = self._load(reference, within, stem)
        name = f"{stem}.{suffix}"
        self.content[name] = content
        self._names[key] = name
        return name

    def _load(self, reference: str, within: Sequence[str], stem: str) -> tuple[bytes, str]:
        path = self.folders.find(reference, within)
        if path is None:
            return self._placeholder(reference, stem, "not found")
        if path not in self._read:
            self._read[path] = self.folders.read(path)
        if sum(map(len, self._read.values())) > MOST_IN_ALL:
            raise FileError(
                f"{path}: meshes of more than {MOST_IN_ALL >> 20} MB; give smaller ones"
            )
        if stem in self._broken:
            return self._placeholder(reference, stem, "no solid that can be read")
        kind = path.suffix.lstrip(".")
        made = as_readable(self._read[path], kind, self._convert)
        if made is None:
            return self._placeholder(reference, stem, f"no mesh that can be read as .{kind}")
        return made

    def _placeholder(self, reference: str, stem: str, reason: str) -> tuple[bytes, str]:
        self.missing[reference] = reason
        self.placeholders.add(stem)
        return PLACEHOLDER, "obj"

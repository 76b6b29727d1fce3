"""TOML files read section by section, so that a word that is not known is said and not ignored."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from handsim.errors import FileError
from handsim.files import read_text


class Section:
    """A table of a TOML file, with the words that it may have.

    Parameters
    ----------
    where
        What messages begin with, such as ``map.toml: [[column]] 3``.
    values
    known
        Keys that it may have.

    Raises
    ------
    FileError
        If it is no table, or has another key.
    """

    def __init__(self, where: str, values: Any, known: Sequence[str]) -> None:
        if not isinstance(values, dict):
            raise FileError(f"{where}: is no table; it has the keys {', '.join(known)}")
        self.where = where
        self.values = cast("Mapping[str, Any]", values)
        for key in self.values:
            if key not in known:
                raise FileError(f"{where}: key '{key}' is not known; use {', '.join(known)}")

    def __contains__(self, key: str) -> bool:
        """Whether a key is there."""
        return key in self.values

    def text(self, key: str, default: str = "", among: Sequence[str] = ()) -> str:
        """Return a text, one of some where they are given."""
        value = self.values.get(key, default)
        if not isinstance(value, str):
            raise FileError(f"{self.where}: {key} = {_shown(value)} is no text; put it in quotes")
        if among and value not in among:
            raise FileError(f"{self.where}: {key} = '{value}'; use one of {', '.join(among)}")
        return value

    def number(self, key: str, default: float) -> float:
        """Return a finite number."""
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e300:
            raise FileError(f"{self.where}: {key} = {_shown(value)} is no number in range")
        if not np.isfinite(value):
            raise FileError(f"{self.where}: {key} = {value} is not finite; correct it")
        return float(value)

    def column(self, key: str) -> str | int | None:
        """Return a column by its name in the header or its number from 1; None where not said."""
        value = self.values.get(key)
        if value is None or (isinstance(value, str) and value):
            return value
        if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
            return value
        raise FileError(
            f"{self.where}: {key} = {_shown(value)}; give the name of a column or its number from 1"
        )

    def pair(self, key: str) -> tuple[float, float]:
        """Return two finite numbers, NaN where not said."""
        value: Any = self.values.get(key, [np.nan, np.nan])
        if (
            not isinstance(value, list)
            or len(cast("list[Any]", value)) != 2
            or not all(isinstance(each, int | float) for each in cast("list[Any]", value))
            or any(abs(each) > 1e300 for each in cast("list[float]", value))
        ):
            raise FileError(f"{self.where}: {key} = {_shown(value)}; give two numbers in brackets")
        low, high = cast("list[float]", value)
        return float(low), float(high)

    def section(self, key: str, known: Sequence[str]) -> "Section":
        """Return a table in it, empty where it is not there."""
        return Section(f"{self.where} [{key}]", self.values.get(key, {}), known)

    def sections(self, key: str, known: Sequence[str]) -> list["Section"]:
        """Return the tables of an array."""
        values = self.values.get(key, [])
        if not isinstance(values, list):
            raise FileError(f"{self.where}: {key} is no array; write [[{key}]] above each")
        return [
            Section(f"{self.where} [[{key}]] {i}", value, known)
            for i, value in enumerate(cast("list[Any]", values), start=1)
        ]


def read_sections(path: Path, known: Sequence[str]) -> Section:
    """Read a TOML file.

    Raises
    ------
    FileError
        If it is missing, no TOML, or has other keys than ``known``.
    """
    text = read_text(path)
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise FileError(f"{path}: is no TOML ({reason}); correct that line") from error
    return Section(str(path), values, known)


def quoted(text: str) -> str:
    """Return a text as TOML has it between quotes."""
    escapes = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    safe = (escapes.get(c, c if c.isprintable() else f"\\U{ord(c):08X}") for c in text)
    return '"' + "".join(safe) + '"'


def brief(text: str, most: int = 40) -> str:
    """Return a text of a file as a message quotes it: short, and without odd characters."""
    safe = "".join(c if c.isprintable() else "?" for c in text[: most + 1])
    return safe if len(text) <= most else safe[: most - 3] + "..."


def _shown(value: object) -> str:
    return brief(str(value), 60)

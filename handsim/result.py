"""Answers that print well and convert to dictionaries."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


class Result:
    """Base of a ``@dataclass(frozen=True)`` that is the answer of a function.

    ``print`` shows a field a line, and `as_dict` gives what JSON can hold.
    """

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name: numbers, text, lists and dictionaries, as for JSON."""
        return {name: plain(value) for name, value in _fields(self).items()}

    def __str__(self) -> str:
        """Return a field a line; what is long is only counted."""
        return in_lines({name: _shown(value) for name, value in _fields(self).items()})


def in_lines(shown: Mapping[str, Any]) -> str:
    """Return values by name as text, one a line, with the values below each other."""
    width = max(map(len, shown), default=0)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in shown.items())


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: arrays and tuples as lists, dataclasses as mappings."""
    if isinstance(value, Result):
        return value.as_dict()
    if is_dataclass(value) and not isinstance(value, type):
        return {name: plain(each) for name, each in _fields(value).items()}
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value


def _fields(result: Any) -> dict[str, Any]:
    return {field.name: getattr(result, field.name) for field in fields(result)}


def _shown(value: Any) -> str:
    if isinstance(value, float | np.floating):
        return f"{value:.4g}"
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape}"
    if isinstance(value, list | tuple | Mapping):
        if not 1 <= len(value) <= 4:
            return f"{len(value)} entries"
        if isinstance(value, Mapping):
            text = ", ".join(f"{name} {_shown(each)}" for name, each in value.items())
        else:
            text = ", ".join(map(_shown, value))
        return text if len(text) <= 70 and "\n" not in text else f"{len(value)} entries"
    text = str(value)
    return text if len(text) <= 200 else f"text of {len(text)} characters"

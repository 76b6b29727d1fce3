"""Equality by content of things that hold arrays.

What a dataclass compares by itself raises as soon as an array is among its fields, and so does its
hash. Here arrays are equal when they have the same shape and numbers; NaN equals NaN, as two
results that lack the same number are the same.
"""

from dataclasses import fields
from typing import Any

import numpy as np


class ByContent:
    """Base of a ``@dataclass(frozen=True, eq=False)`` that is equal to another by its fields.

    Equal things have equal hashes, so that they can be kept in sets and as keys.
    """

    def __eq__(self, other: object) -> bool:
        """Whether the other is of the same class and all its fields are the same."""
        if type(other) is not type(self):
            return NotImplemented
        return self is other or all(map(_same, _values(self), _values(other)))

    def __hash__(self) -> int:
        """Hash what is compared."""
        return hash((type(self), *map(_key, _values(self))))


def _values(item: Any) -> list[Any]:
    return [getattr(item, field.name) for field in fields(item) if field.compare]


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    return bool(one == other)


def _key(value: Any) -> Any:
    if isinstance(value, dict):
        return frozenset(value.items())
    if not isinstance(value, np.ndarray):
        return value
    numbers = np.nan_to_num(np.asarray(value, dtype=float))
    return value.shape, (numbers + 0.0).tobytes()  # -0.0 equals 0.0

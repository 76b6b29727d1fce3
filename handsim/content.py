"""Equality by content of objects that hold arrays.

The comparison that a dataclass makes raises as soon as one of its fields is an array, and so does
its hash. Here arrays are equal when they have the same shape and numbers. NaN equals NaN: two
results that lack the same number are the same.
"""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, cast

import numpy as np


class ByContent:
    """Base of a ``@dataclass(frozen=True, eq=False)`` that is equal to another by its fields.

    Equal objects have equal hashes, so that they can be kept in sets and as keys.
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
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        one, other = cast(Mapping[Any, Any], one), cast(Mapping[Any, Any], other)
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(cast(Any, one), cast(Any, other), equal_nan=True)
    return bool(one == other)


def _key(value: Any) -> Any:
    if isinstance(value, Mapping):
        return frozenset((k, _key(v)) for k, v in cast(Mapping[Any, Any], value).items())
    if not isinstance(value, np.ndarray):
        return value
    numbers = np.nan_to_num(np.asarray(value, dtype=float))
    return numbers.shape, (numbers + 0.0).tobytes()  # -0.0 equals 0.0

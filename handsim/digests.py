"""Digests of numbers and text that do not depend on the last digits of the numbers.

Computed numbers (masses, mirrored vectors, sides of a prism) differ in their last bits between
processors and libraries. A digest of the bits would differ for the same object on two machines. So
would a digest of decimal digits, wherever a number lies half-way between two of them.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Protocol, cast

import numpy as np
import numpy.typing as npt

RELATIVE_BITS = 20
"""Bits that are kept of each number, about 6 digits."""
ABSOLUTE_BITS = 30
"""Bits below the largest number of an array beyond which nothing is kept, about 9 digits: what
should be 0 is seldom quite 0."""
# No number that a person or a formula would choose lies on these limits, where the last bit would
# decide: of steps at 0.382 instead of a half, of doubled steps at 0.81 instead of 1.
_OFF_STEP = 0.381966
_OFF_DOUBLING = 1.2345678


def rounded(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return numbers on steps so coarse that noise in the last bits is gone, of the same shape.

    A step is 1.2e-6 to 2.4e-6 of the number itself, and at least 1.2e-9 to 2.4e-9 of the largest
    number there: thousands of times what summing in another order makes, and of a length of 0.1 m
    less than a micrometre.
    """
    numbers = np.asarray(values, dtype=float)
    finite = np.where(np.isfinite(numbers), numbers, 0.0)
    exponents = np.frexp(_OFF_DOUBLING * finite)[1]
    largest = int(np.frexp(_OFF_DOUBLING * np.abs(finite).max(initial=0.0))[1])
    steps = np.maximum(exponents - RELATIVE_BITS, largest - ABSOLUTE_BITS)
    on_steps = np.ldexp(np.floor(np.ldexp(finite, -steps) + _OFF_STEP), steps)
    return np.where(np.isfinite(numbers), on_steps + 0.0, numbers)


def content_digest(*values: Any) -> str:
    """Return 16 hexadecimal digits that tell apart what differs by more than `rounded` leaves.

    Parameters
    ----------
    values
        Numbers, arrays, text, None, and sequences, mappings and dataclasses of them. Whole numbers
        and fractions of the same value are the same.
    """
    whole = hashlib.sha256()
    for value in values:
        _add(whole, value)
    return whole.hexdigest()[:16]


class _Hash(Protocol):
    """What hashlib's objects have, which it gives no public name."""

    def update(self, data: bytes, /) -> None: ...


def _add(whole: _Hash, value: Any) -> None:
    """Add a value with its kind and length, so that no two values run together to the same."""
    if value is None or isinstance(value, str | bool):
        whole.update(f"{type(value).__name__} {value!r}\n".encode())
    elif is_dataclass(value):
        _add(whole, {field.name: getattr(value, field.name) for field in fields(value)})
    elif isinstance(value, Mapping):
        mapping = cast(Mapping[str, Any], value)
        whole.update(f"mapping {len(mapping)}\n".encode())
        for name in sorted(mapping):
            _add(whole, name)
            _add(whole, mapping[name])
    elif isinstance(value, list | tuple) and not _numeric(cast(Sequence[Any], value)):
        sequence = cast(Sequence[Any], value)
        whole.update(f"sequence {len(sequence)}\n".encode())
        for each in sequence:
            _add(whole, each)
    else:
        numbers = rounded(cast(npt.ArrayLike, value))
        whole.update(f"numbers {numbers.shape}\n".encode() + numbers.astype("<f8").tobytes())


def _numeric(values: Sequence[Any]) -> bool:
    """Return whether a sequence is a row of numbers, or of rows of numbers of one length."""
    first = values[0] if values else None
    if isinstance(first, list | tuple):
        n = len(cast(Sequence[Any], first))
        rows = [cast(Sequence[Any], row) for row in values if isinstance(row, list | tuple)]
        return len(rows) == len(values) and all(len(row) == n > 0 and _numeric(row) for row in rows)
    return bool(values) and all(
        isinstance(each, int | float) and not isinstance(each, bool) for each in values
    )

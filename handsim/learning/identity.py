"""What a controller is, told apart by numbers that the last bit does not change.

Every array is rounded to a millionth of the power of two above its greatest entry: of angles and
of the obstacle's coefficients. Learning repeats to the bit, and what is computed beside it to
1e-12 or better, far below that; what a movement or a grasp can show begins far above it, at
a thousandth of a degree.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

BITS = 20
"""Binary digits that count, of each array's greatest entry."""


def rounded(array: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Return numbers as multiples of 2^-20 of the power of two above the greatest.

    The result is flat; its last entry is the exponent of that power.
    """
    x = np.asarray(array, dtype=float).ravel()
    exponent = int(np.frexp(np.abs(x).max(initial=0.0))[1])
    return np.append(np.rint(np.ldexp(x, BITS - exponent)), exponent).astype(np.int64)


def content_digest(settings: Mapping[str, Any], arrays: Mapping[str, npt.ArrayLike]) -> str:
    """Return a SHA-256 of settings, as they are, and of arrays, rounded; in hexadecimal."""
    whole = hashlib.sha256(json.dumps(dict(settings), sort_keys=True).encode())
    for name in sorted(arrays):
        shape = np.shape(arrays[name])
        whole.update(f"{name}{shape}".encode() + rounded(arrays[name]).tobytes())
    return whole.hexdigest()

"""How alike the objects of recordings are: what is known of an object decides who is asked.

Objects are known by name, or by numbers such as their size, which recordings carry in further
columns ``object_...`` of ``experiments.csv``. With numbers, an object never grasped before is
served by its likes. Where nothing is known the object is guessed from the destination: people close
the hand around different things differently.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from handsim.errors import InputError
from handsim.reproducible import dots, exp, mean, total
from handsim.types import Array

PREFIX = "object_"
"""How columns of ``experiments.csv`` begin that hold numbers about the object."""
Grasped = str | Mapping[str, float]
"""An object: its name, or numbers by the names of their columns."""
_TINY = 1e-9


def object_numbers(extra: Mapping[str, str]) -> dict[str, float]:
    """Return the numbers about an object among further columns of ``experiments.csv``."""
    found: dict[str, float] = {}
    for name, text in extra.items():
        if name.startswith(PREFIX):
            try:
                number = float(text)
            except ValueError:
                continue
            if isfinite(number):
                found[name] = number
    return found


@dataclass(frozen=True, eq=False)
class Likeness:
    """Likeness of the objects of N recordings, from ``other`` to 1.

    Parameters
    ----------
    names
        Of their objects.
    numbers
        Columns known for all of them.
    values : (N, len(numbers))
        In units of their spread over the recordings.
    middle, scale : (len(numbers),)
        Mean and spread of the columns.
    other
        Likeness of two objects that have nothing in common.
    """

    names: tuple[str, ...]
    numbers: tuple[str, ...]
    values: Array
    middle: Array
    scale: Array
    other: float

    @classmethod
    def of(
        cls, names: Sequence[str], numbers: Sequence[Mapping[str, float]], other: float
    ) -> "Likeness":
        """Return the likeness of objects by names, and by the numbers that all of them have."""
        common = [key for key in numbers[0] if all(key in each for each in numbers)]
        table = np.array([[each[key] for key in common] for each in numbers]).reshape(
            len(names), len(common)
        )
        middle = mean(table)
        deviation = table - middle
        scale = np.sqrt(mean(deviation * deviation))
        varied = scale > _TINY * (1.0 + np.abs(middle))
        kept = tuple(key for key, use in zip(common, varied, strict=True) if use)
        middle, scale = middle[varied], scale[varied]
        return cls(tuple(names), kept, deviation[:, varied] / scale, middle, scale, other)

    @property
    def among(self) -> Array:
        """Likeness (N, N) of the recordings' objects."""
        if self.numbers:
            return self._by_numbers(self.values)
        names = np.array(self.names)
        return self._mixed((names[:, None] == names[None]).astype(float))

    def to(self, grasped: Grasped | None, nearness: Array) -> Array:
        """Return the likeness (N,) of an object to those of the recordings.

        Parameters
        ----------
        grasped
            None if nothing is known.
        nearness : (N,)
            Weights by which the object is guessed from the recordings then.

        Raises
        ------
        InputError
            If numbers are given that the recordings do not have, or not all that they have.
        """
        if isinstance(grasped, str) and grasped in self.names:
            return self.among[self.names.index(grasped)]
        if grasped is None or isinstance(grasped, str):
            weights = nearness + _TINY
            return total(weights[:, None] * self.among) / total(weights)
        if not self.numbers:
            raise InputError(
                f"numbers of an object ({', '.join(grasped)}), but the recordings have none; "
                f"give its name, or columns {PREFIX}... in experiments.csv"
            )
        missing = [key for key in self.numbers if not isfinite(grasped.get(key, np.nan))]
        if missing:
            raise InputError(f"an object without {missing[0]}; give {', '.join(self.numbers)}")
        values = (np.array([grasped[key] for key in self.numbers]) - self.middle) / self.scale
        return self._by_numbers(values[None])[0]

    def _by_numbers(self, values: Array) -> Array:
        apart = values[:, None] - self.values[None]
        return self._mixed(exp(-0.5 * dots(apart, apart)))

    def _mixed(self, same: Array) -> Array:
        return self.other + (1.0 - self.other) * same

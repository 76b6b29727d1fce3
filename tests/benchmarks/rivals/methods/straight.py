"""The straight line, passed with minimum jerk: what is known without learning anything."""

from collections.abc import Sequence
from typing import Self

import numpy as np

from ..protocol import Motion, Movement, Query, Rival, timed


class StraightLine(Rival):
    """The segment from start to destination (Flash and Hogan 1985 for its timing)."""

    argument = "the distance falls"

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn nothing."""
        return self

    def predict(self, query: Query) -> Motion:
        """Return the segment."""
        return timed(np.array([query.start, query.goal]), query.duration)

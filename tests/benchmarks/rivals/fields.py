"""Rivals that are fields: a velocity at each place, followed to the destination."""

from collections.abc import Callable, Sequence

import numpy as np

from handsim.navigation.flow import STEP, follow
from handsim.navigation.paths import arc_length
from handsim.types import Array

from .protocol import Motion, Query, Rival, timed

_SLOWEST = 1e-3  # least speed on a path, relative to its greatest: a standstill would take for ever
MANY_STEP = 2.0 * STEP  # of many roll-outs at once, of which only the ends count


Field = Callable[[Array, Array], Array]
"""Maps places (N, d) and destinations (N, d) to velocities (N, d)."""


class FieldRival(Rival):
    """A rival that knows a velocity at each place."""

    def field(self, name: str) -> Field:
        """Return the velocities on the way to an object of that name."""
        raise NotImplementedError

    def speeds(self, path: Array, query: Query) -> Array | None:
        """Return speeds (m,) on a path (m, d), but for a factor; None for minimum jerk."""
        return None

    def predict(self, query: Query) -> Motion:
        """Follow the field."""
        field = self.field(query.object)
        found = follow(_directions(field), query.start[None], query.goal[None])[0]
        return self._timed(found.points, query)

    def predict_all(self, queries: Sequence[Query]) -> list[Motion]:
        """Follow the fields from all starts at once, in steps of 2 deg."""
        motions: dict[int, Motion] = {}
        for name in dict.fromkeys(query.object for query in queries):
            field = self.field(name)
            chosen = [i for i, query in enumerate(queries) if query.object == name]
            starts = np.array([queries[i].start for i in chosen])
            goals = np.array([queries[i].goal for i in chosen])
            found = follow(_directions(field), starts, goals, MANY_STEP)
            for i, path in zip(chosen, found, strict=True):
                motions[i] = self._timed(path.points, queries[i])
        return [motions[i] for i in range(len(queries))]

    def _timed(self, path: Array, query: Query) -> Motion:
        """Pass the path at the field's speeds, all scaled to end at the duration asked for."""
        speed = self.speeds(path, query) if len(path) > 2 else None
        if speed is None:
            return timed(path, query.duration)
        # The speed at the destination is zero: what is left from 4 deg on is passed at the last.
        speed[-1] = speed[-2]
        slowness = 1.0 / np.maximum(speed, _SLOWEST * speed.max())
        steps = np.diff(arc_length(path)) * 0.5 * (slowness[1:] + slowness[:-1])
        time = np.append(0.0, np.cumsum(steps))
        return Motion(path, time * (query.duration / time[-1]))


def _directions(field: Field) -> Field:
    return lambda z, goals: unit(field(z, goals))


def unit(vectors: Array) -> Array:
    """Return vectors (N, d) of length 1, or shorter where they are next to nothing."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)

"""One movement as all exports take it: named quantities over time, with units and frames."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from handsim.grasping.rollout.record import Rollout
from handsim.learning.controller import PostureSequence
from handsim.recordings.recording import Recording
from handsim.types import Array, HandSize

Kind = Literal["rollout", "recording", "postures"]

TURN: tuple[str, ...] = ("qw", "qx", "qy", "qz")
"""How the columns of a quaternion end."""


@dataclass(frozen=True, eq=False)
class Quantity:
    """Something measured or commanded over time.

    Attributes
    ----------
    name
        Such as ``joints`` or ``contact_force``.
    columns : k names
        Unique in their episode, without units.
    units : k
        ``rad``, ``rad/s``, ``m``, ``N``; empty where there is none, or the column's name says it.
    values : (n, k)
    what
        In words.
    frame
        In which frame it is: ``world``, or empty where there is no choice.
    """

    name: str
    columns: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    what: str
    frame: str = ""

    @property
    def turns(self) -> bool:
        """Whether it is a quaternion."""
        return len(self.columns) == len(TURN) and all(
            column.endswith(end) for column, end in zip(self.columns, TURN, strict=True)
        )

    def at(self, rows: Array, time: Array) -> "Quantity":
        """Return it at other times (m,), given those that it has (n,).

        Linear between two samples; of orientations along the shortest turn.
        """
        if not self.turns:
            columns = [np.interp(rows, time, each) for each in self.values.T]
            return replace(self, values=np.stack(columns, axis=1))
        from scipy.spatial.transform import Rotation, Slerp

        turns = Rotation.from_quat(self.values, scalar_first=True)
        values = Slerp(time, turns)(np.clip(rows, time[0], time[-1])).as_quat(scalar_first=True)
        same = np.einsum("ij,ij->i", values, self.values[_nearest(rows, time)]) >= 0
        return replace(self, values=np.where(same[:, None], values, -values))


def _nearest(rows: Array, time: Array) -> Any:
    return np.abs(rows[:, None] - time[None]).argmin(axis=1)


@dataclass(frozen=True, eq=False)
class Episode:
    """One movement.

    Attributes
    ----------
    name
        Unique among those that are exported together.
    kind
        What it was: a simulated grasp, a person's movement, or postures alone.
    task, sentence
        Name of the task, empty if there is none, and what it asks for.
    time : (n,) [s]
        Increasing.
    quantities
        In order.
    facts
        What else is known of the movement as a whole, as JSON can hold it.
    phases
        Names, and when each begins [s].
    success
        How a simulated grasp was judged; None for what was not.
    hand
        Size and side of the hand.
    rollout
        The simulated grasp itself.
    """

    name: str
    kind: Kind
    task: str
    sentence: str
    time: Array
    quantities: tuple[Quantity, ...]
    facts: Mapping[str, Any]
    phases: tuple[tuple[str, float], ...] = ()
    success: bool | None = None
    hand: HandSize = field(default_factory=HandSize)
    rollout: Rollout | None = None

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of that name, None where it has none."""
        return next((each for each in self.quantities if each.name == name), None)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])


Shown = Rollout | Recording | PostureSequence | Episode
"""What one movement may be given as."""

"""What every grasp has to show, whatever the task: that it is one, with a person's strength.

A hand that knocks, leans, crushes or merely touches can move things, too. These rules tell it from
a hand that holds. Their limits were written down before any grasp was tuned to them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.tasks.task import Task
from handsim.tasks.traces import GraspTraces
from handsim.types import Array, Mask

Reason = Literal[
    "missed", "slipped", "tilted", "penetrated", "not arrived", "unstable", "pushed", "leaned",
    "crushed", "not opposed", "astray",
]  # fmt: skip
"""Why a run failed; docs/tasks.md says what each word means."""

MAX_PUSH = 0.010
"""Farthest that the object may move before the hand has closed on it [m]."""
MAX_PUSH_TURN_DEG = 10.0
"""Farthest that it may turn meanwhile [deg]."""
MAX_PENETRATION = 0.002
"""Deepest overlap of the hand with object or table [m]; a fingertip's flesh gives that much."""
MAX_FORCE = 60.0
"""Most that any finger may press, averaged over 0.1 s [N]; about half of what strong fingers can
(index 108, middle 111, ring 84 N, means of 120 adults)."""
MAX_MARGIN = 4.0
"""Most that a part of the hand may press on a lifted object in the hold, relative to the need.
People use 1.2 to 2 times the need (Westling and Johansson 1984, Exp. Brain Res. 53:277-284)."""
LEAST_PRESS = 0.2
"""A part that presses less than this does not take part [N]: the weight of some 20 g."""
OPPOSED_COSINE = -0.5
"""Greatest cosine of the angle between what the thumb and what the rest of the hand press."""
OPPOSED_SHARE = 0.95
"""Least share of the samples of action and of hold in which thumb and fingers are opposed."""

_THUMB = CONTACT_PARTS.index("thumb")
_OF_FINGERS = [CONTACT_PARTS.index(finger) for finger in FINGERS]


def working(task: Task) -> list[int]:
    """Return the columns of `CONTACT_PARTS` of fingers that press what moves and do not hold.

    Who clicks a mouse holds it with thumb, ring and little finger; what the index presses then is
    the click, and is no side of the grip.
    """
    pressing = {finger for each in task.rule.pressed for finger in each.fingers}
    return [
        CONTACT_PARTS.index(finger)
        for finger in FINGERS
        if finger in pressing - {"thumb", *task.grasp.fingers}
    ]


def opposed(traces: GraspTraces, aside: Sequence[int] = ()) -> Mask:
    """Return whether thumb and the rest of the hand press against each other, (n,).

    Both press with `LEAST_PRESS` or more, at 120 deg or more to each other. Parts of the columns
    ``aside`` do not count (`working`).
    """
    thumb = traces.press[:, _THUMB]
    rest = traces.press.sum(axis=1) - thumb - traces.press[:, list(aside)].sum(axis=1)
    size, other = np.linalg.norm(thumb, axis=1), np.linalg.norm(rest, axis=1)
    along = (thumb * rest).sum(axis=1)
    return (np.minimum(size, other) >= LEAST_PRESS) & (along <= OPPOSED_COSINE * size * other)


def opposed_share(traces: GraspTraces, aside: Sequence[int] = ()) -> float:
    """Return the lesser of the shares of action and of hold in which the hand is opposed."""
    held, start, hold = opposed(traces, aside), traces.first_acting, traces.first_holding
    parts = [part for part in (held[start:hold], held[hold:]) if len(part)]
    return min((float(part.mean()) for part in parts), default=0.0)


def pushed(traces: GraspTraces) -> tuple[float, float]:
    """Return how far the object was moved [m] and turned [deg] before the action."""
    before = slice(0, traces.first_acting + 1)
    turned = traces.turn(0, None)[before]
    return float(traces.way()[before].max()), float(np.rad2deg(turned.max()))


def table_force(traces: GraspTraces) -> float:
    """Return the most that hand and arm pressed on the table, averaged over 0.1 s [N]."""
    return float(traces.averaged(traces.table_force).max())


def finger_force(traces: GraspTraces) -> float:
    """Return the most that any finger pressed, averaged over 0.1 s [N]."""
    return float(traces.averaged(traces.force[:, _OF_FINGERS]).max())


def held_forces(traces: GraspTraces) -> Array:
    """Return the mean force of each part in the hold, (6,) [N]; 0 where there was no hold."""
    held = traces.force[traces.first_holding :]
    return held.mean(axis=0) if len(held) else np.zeros(len(CONTACT_PARTS))


@dataclass(frozen=True)
class Shown:
    """What a run shows of that which these rules ask for.

    Attributes
    ----------
    way, turned
        As `pushed` returns them, [m] and [deg].
    table, finger
        `table_force` and `finger_force` [N].
    forces : (6,) [N]
        `held_forces`.
    margin
        The greatest of them, relative to the need.
    overlap
        Deepest penetration [m].
    share
        `opposed_share`, without the fingers that are `working`.
    """

    way: float
    turned: float
    table: float
    finger: float
    forces: Array
    margin: float
    overlap: float
    share: float

    @classmethod
    def by(cls, traces: GraspTraces, task: Task) -> "Shown":
        """Measure a run."""
        forces = held_forces(traces)
        return cls(
            *pushed(traces),
            table_force(traces),
            finger_force(traces),
            forces,
            float(forces.max()) / traces.need,
            float(traces.penetration.max()),
            opposed_share(traces, working(task)),
        )


def broken(traces: GraspTraces, task: Task, shown: Shown) -> tuple[Reason, str] | None:
    """Return the first of these rules that a run breaks, as reason and sentence, or None."""
    rule = task.rule
    way, turned, share = shown.way, shown.turned, shown.share
    table, finger, margin, overlap = shown.table, shown.finger, shown.margin, shown.overlap
    checks: tuple[tuple[bool, Reason, str], ...] = (
        (
            overlap > MAX_PENETRATION,
            "penetrated",
            f"the hand overlaps by {1e3 * overlap:.1f} mm, more than {1e3 * MAX_PENETRATION:g}",
        ),
        (
            way > MAX_PUSH or turned > MAX_PUSH_TURN_DEG,
            "pushed",
            f"the object moved by {1e3 * way:.0f} mm and {turned:.0f} deg before the hand had "
            f"closed, more than {1e3 * MAX_PUSH:g} or {MAX_PUSH_TURN_DEG:g}",
        ),
        (
            table > rule.table_force,
            "leaned",
            f"{table:.0f} N on the table, more than {rule.table_force:g}",
        ),
        (
            finger > MAX_FORCE,
            "crushed",
            f"a finger pressed with {finger:.0f} N, more than {MAX_FORCE:g}",
        ),
        (
            share < OPPOSED_SHARE,
            "not opposed",
            f"thumb and fingers pressed against each other in {100 * share:.0f} % of action or "
            f"hold, less than {100 * OPPOSED_SHARE:g}",
        ),
        (
            rule.lifted and margin > MAX_MARGIN,
            "crushed",
            f"held with {margin:.1f} times the {traces.need:.1f} N needed, more than "
            f"{MAX_MARGIN:g}",
        ),
    )
    return next(((reason, detail) for wrong, reason, detail in checks if wrong), None)

"""Take the links of a robot hand out of one another, where a fitted movement leaves them so.

Only the stretches in which they are too deep are fitted again, all at once, between ends that stay,
with what overlaps counting twice as much each time.
"""

from collections.abc import Callable

import numpy as np

from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.movement_fit import Movement, fit
from handsim.retargeting.solving.residuals import Residuals
from handsim.retargeting.solving.self_contact import SelfContact
from handsim.types import Array, Index, Mask

DEEPEST = 0.0018
"""Overlap that is left alone [m]."""
ROUNDS = 20
"""How often stretches are fitted again at most."""
STUBBORN = 5
"""Each time after so many, what is left is begun anew, straight from one end to the other."""
_STEPS = 5
_BESIDE = 5
"""Postures on either side of those that overlap which may change with them."""


def untangled(
    residuals_of: Callable[[Index], Residuals],
    robot: RobotHand,
    contact: SelfContact,
    movement: Movement,
    start: Array,
) -> tuple[Array, Array]:
    """Return coordinates (n, m) within the largest steps, and how deep links overlap, (n,) [m].

    Parameters
    ----------
    residuals_of
        Returns what a fit of chosen postures leaves over.
    robot
    contact
        Finds where it runs into itself.
    movement
    start : (n, m)
    """
    x = kept_within(start, movement.steps)
    depth = contact.find(x).depth(len(x))
    best, least = x, depth
    weight = np.full(len(x), residuals_of(np.zeros(1, dtype=np.int64)).weights.contact)
    for i in range(ROUNDS):
        if least.max() < DEEPEST:
            break
        weight = np.where(depth > DEEPEST, 2 * weight, weight)
        x = x.copy()
        if i % STUBBORN == STUBBORN - 1:
            for first, last in _stretches(depth > DEEPEST):
                x[first:last] = _straight(x, first, last)
            weight = np.minimum(weight, 4 * weight.min())
        part, held = _part(_stretches(depth > DEEPEST), len(x))
        at = x[part]
        lower, upper = (np.where(held[:, None], at, end) for end in (robot.lower, robot.upper))
        near = contact.near_links(contact.find(at), at, weight[part])
        residuals = residuals_of(part)
        x[part], _ = fit(
            lambda at, residuals=residuals, near=near: residuals.at(at, near),
            at, lower, upper, movement.part(part), _STEPS,
        )  # fmt: skip
        kept = kept_within(x, movement.steps)
        moved = np.abs(kept - best).max(axis=1) > 0
        x, depth = kept, least.copy()
        depth[moved] = contact.find(x[moved]).depth(int(moved.sum()))
        if depth.max() < least.max():
            best, least = x, depth
    return best, least


def _straight(x: Array, first: int, last: int) -> Array:
    """Return a stretch as a straight way between its ends; at an end of the movement, held."""
    start = x[first] if first > 0 else x[last - 1]
    end = x[last - 1] if last < len(x) else x[first]
    return start + np.linspace(0, 1, last - first)[:, None] * (end - start)


def _part(stretches: list[tuple[int, int]], n: int) -> tuple[Index, Mask]:
    """Return the postures of stretches, in order, and which stay: ends but those of the movement.

    Parameters
    ----------
    stretches
        First and past-the-last posture of each; they do not touch.
    n
        Postures of the movement.
    """
    part = np.concatenate([np.arange(first, last) for first, last in stretches])
    ends = {end for first, last in stretches for end in (first, last - 1)} - {0, n - 1}
    return part, np.isin(part, list(ends))


def kept_within(x: Array, steps: Array) -> Array:
    """Return a movement of which no coordinate changes by more than it may."""
    kept = x.copy()
    for i, step in enumerate(steps, start=1):
        kept[i] = np.clip(kept[i], kept[i - 1] - step, kept[i - 1] + step)
    return kept


def _stretches(deep: Mask) -> list[tuple[int, int]]:
    """Return first and past-the-last posture of stretches around those that are marked."""
    reached = np.convolve(deep, np.ones(2 * _BESIDE + 1), mode="full")[
        _BESIDE : _BESIDE + len(deep)
    ]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (reached > 0.5).astype(int), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]

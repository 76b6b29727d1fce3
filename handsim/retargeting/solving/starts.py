"""Where the fit of a movement starts: the smoothest way among solutions of some postures."""

from collections.abc import Callable

import numpy as np

from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.movement_fit import fit
from handsim.retargeting.solving.residuals import Residuals
from handsim.retargeting.solving.self_contact import SelfContact
from handsim.types import Array, Index

MOST_KEYS = 8
"""Most postures of a movement that are solved from several starts."""
_STEPS = 8
_ROUNDS = 5
"""How often collisions of these postures are found."""
_SHALLOW = 0.0012
"""Overlap at which they are left alone [m]."""
_DRAWN = 2
"""Starts drawn at random, besides three that are not."""
_APART = 0.02
"""What a squared radian between keys counts beside the squared errors of a posture."""


def first_guess(
    residuals_of: Callable[[Index], Residuals],
    n: int,
    robot: RobotHand,
    contact: SelfContact,
) -> Array:
    """Return coordinates to start from, (n, m).

    Some postures are solved from several starts each, on their own. Of their solutions one is taken
    a posture so that the sum of costs and of distances from one to the next is least, by dynamic
    programming. Between them it is interpolated.

    Parameters
    ----------
    residuals_of
        Returns what a fit of the postures chosen leaves over.
    n
        Number of postures.
    robot
    contact
        Finds where it runs into itself.
    """
    lower, upper, reference = robot.lower, robot.upper, robot.reference
    keys = np.unique(np.linspace(0, n - 1, min(n, MOST_KEYS)).round().astype(np.int64))
    starts = _starts(lower, upper, reference)
    many = np.repeat(keys, len(starts))
    solved, cost = fit(
        residuals_of(many).at, np.tile(starts, (len(keys), 1)), lower, upper, None, _STEPS
    )
    solved = solved.reshape(len(keys), len(starts), -1)
    chosen = _smoothest(solved, cost.reshape(len(keys), len(starts)))
    alone = residuals_of(keys)
    weight = np.full(len(keys), alone.weights.contact)
    for _ in range(_ROUNDS):  # out of one another, each posture by itself
        contacts = contact.find(chosen)
        depth = contacts.depth(len(keys))
        if depth.max() < _SHALLOW:
            break
        near = contact.near_links(contacts, chosen, weight)
        chosen, _ = fit(
            lambda x, near=near: alone.at(x, near), chosen, lower, upper, None, _STEPS // 2
        )
        weight = np.where(depth > _SHALLOW, 1.5 * weight, weight)
    places = np.arange(n)
    return np.transpose([np.interp(places, keys, column) for column in chosen.T])


def _starts(lower: Array, upper: Array, reference: Array) -> Array:
    rng = np.random.default_rng(1)
    drawn = lower + rng.uniform(0.1, 0.9, (_DRAWN, len(lower))) * (upper - lower)
    fixed = [reference, (lower + upper) / 2, 0.75 * lower + 0.25 * upper]
    return np.clip(np.vstack([fixed, drawn]), lower, upper)


def _smoothest(solved: Array, cost: Array) -> Array:
    """Return one solution a key, (k, m), of solutions (k, s, m) and costs (k, s)."""
    total, came = cost[0].copy(), []
    for i in range(1, len(cost)):
        apart = np.sum((solved[i][:, None] - solved[i - 1][None]) ** 2, axis=2)
        through = total[None] + _APART * apart
        came.append(np.argmin(through, axis=1))
        total = cost[i] + np.min(through, axis=1)
    at = [int(np.argmin(total))]
    for back in reversed(came):
        at.append(int(back[at[-1]]))
    return solved[np.arange(len(cost)), at[::-1]]

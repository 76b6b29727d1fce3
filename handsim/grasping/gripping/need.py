"""The force that a grasp needs: the least on each side with which its contacts carry the load."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import threading
from contextlib import suppress
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.optimize import milp, nnls

from handsim.hand.kinematics import cross
from handsim.types import Array

LEAST = 1.0
"""A need is counted as at least this [N]: what people press the lightest things with."""
_ROUND, _TWISTS = 8, np.deg2rad([-45.0, 0.0, 45.0])
"""Directions of friction, and angles from friction to torsion, of a cone's edges."""
_MISSING = 1e3  # cost of load that contacts cannot carry, relative to that of their force

_SPARING = 1e-5  # weight of the sum of forces in least squares, in which it hardly costs any load
_CARRIED = 1e-6  # share of a load that may be missing where it counts as carried


def _cone() -> Array:
    """Return the edges of a cone of unit friction and torsion, (n, 3): along, across, about."""
    round_, twist = np.meshgrid(2 * np.pi * np.arange(_ROUND) / _ROUND, _TWISTS)
    flat = np.cos(twist)
    edges = np.stack([flat * np.cos(round_), flat * np.sin(round_), np.sin(twist)], axis=-1)
    return np.vstack([edges.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])


_CONE = _cone()


class HandContacts(NamedTuple):
    """Contacts of hand and object.

    Attributes
    ----------
    points, normals : (n, 3) [m], (n, 3)
        Places, and unit normals along which the hand pushes the object.
    friction, torsion : (n,), (n,) [m]
        Coefficients of sliding and torsional friction.
    """

    points: Array
    normals: Array
    friction: Array
    torsion: Array


class _Spare(threading.local):
    """A state of the model that was asked for last, in each thread another."""

    state: tuple[mujoco.MjModel, mujoco.MjData] | None = None


_spare = _Spare()


def spare_state(model: mujoco.MjModel) -> mujoco.MjData:
    """Return a state of a model as it is at first, for a thread to compute in until it asks again.

    To make one takes as long as several steps; searches judge thousands of runs of one model.
    """
    if _spare.state is None or _spare.state[0] is not model:
        _spare.state = model, mujoco.MjData(model)
    data = _spare.state[1]
    mujoco.mj_resetData(model, data)
    return data


def contacts_at(model: mujoco.MjModel, data: mujoco.MjData) -> HandContacts:
    """Return the contacts of hand and object in a state that MuJoCo has placed all things of."""
    contact = data.contact
    root = model.body_rootid[model.geom_bodyid[contact.geom]]
    object_id, hand = model.body("object").id, model.body_rootid[model.body("forearm").id]
    first, second = root.T
    held = ((first == hand) & (second == object_id)) | ((first == object_id) & (second == hand))
    # MuJoCo's normal points from the first geom to the second.
    sign = np.where(second[held] == object_id, 1.0, -1.0)
    return HandContacts(
        contact.pos[held],
        sign[:, None] * contact.frame[held, :3],
        contact.friction[held, 0],
        contact.friction[held, 2],
    )


def least_grip(contacts: HandContacts, centre: Array, force: Array) -> float:
    """Return the least normal force a side that carries a load, not counted below `LEAST` [N].

    It is half of the least sum of normal forces with which friction and torsion at the contacts
    balance the load, found by linear programming: in a grip of two sides, that of either.

    Parameters
    ----------
    contacts
    centre : (3,) [m]
        The object's centre of mass, at which the load acts: off-centre contacts have its torque
        to withstand as well.
    force : (3,) [N]
        What the hand has to push the object with: against gravity, and to accelerate it.

    Notes
    -----
    Friction and torsion share one elliptic cone, as in the simulation, which edges approximate
    from inside; the need comes out up to 8 % too large. Load that the contacts cannot carry at all
    counts as carried by nobody.
    """
    if not len(contacts.points):
        return LEAST
    wrenches = _edges(contacts, centre)
    n, load = wrenches.shape[1], np.concatenate([force, np.zeros(3)])
    # Most things need less than they are counted to need: least squares see it ten times as fast,
    # but may give up.
    sparing = np.vstack([wrenches, np.full(n, _SPARING)])
    with suppress(RuntimeError):
        pushes, _ = nnls(sparing, np.append(load, 0.0))
        missing = float(np.linalg.norm(wrenches @ pushes - load))
        if missing <= _CARRIED * float(np.linalg.norm(load)) and pushes.sum() < 1.99 * LEAST:
            return LEAST
    balance = np.hstack([wrenches, np.eye(6), -np.eye(6)])
    cost = np.concatenate([np.ones(n), np.full(12, _MISSING)])
    # No number has to be whole: this is the same linear program as `linprog` solves, set up faster.
    found = milp(cost, constraints=(balance, load, load))
    return LEAST if found.x is None else max(LEAST, 0.5 * float(found.x[:n].sum()))


def _edges(contacts: HandContacts, centre: Array) -> Array:
    """Return wrenches (6, n) [N], [N m] of unit normal forces along the edges of all cones."""
    normals = contacts.normals
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = cross(normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = cross(normals, first)
    along, about = (
        _CONE[:, :2] * contacts.friction[:, None, None],
        _CONE[:, 2] * (contacts.torsion[:, None]),
    )
    force = normals[:, None] + along[..., :1] * first[:, None] + along[..., 1:] * second[:, None]
    lever = (contacts.points - centre)[:, None]
    torque = cross(lever, force) + about[..., None] * normals[:, None]
    wrenches = np.concatenate([force, torque], axis=-1).astype(float)
    return wrenches.reshape(-1, 6).T

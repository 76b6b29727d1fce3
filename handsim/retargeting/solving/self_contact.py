"""Where a robot hand would run into itself, in many postures, by MuJoCo's own collision shapes.

MuJoCo finds the nearest points of all pairs of shapes that are within a margin; how their distance
changes with the joints follows from the Jacobians of those points.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.hand.kinematics import cross
from handsim.retargeting.robot_hand import RobotHand
from handsim.types import Array, Index, Mask

MARGIN = 0.0025
"""Distance at which two shapes are looked at [m]."""
BUILT_IN = 0.001
"""Links that overlap by more in the reference posture are drawn so; they are not looked at [m]."""
OFTEN = 0.5
"""So are those that overlap in more than this part of postures drawn at random."""
_DRAWN = 200
MOST = 16
"""Most contacts of one posture that are kept, the deepest."""
AGREEING = 0.8
"""Least cosine of the normals of two contacts that push two links the same way."""
_PLANE = mujoco.mjtGeom.mjGEOM_PLANE.value


@dataclass(frozen=True)
class Contacts:
    """Pairs of links that are near or in each other.

    Attributes
    ----------
    posture : (c,)
        Which of the postures.
    first, second : (c,)
        Bodies.
    point : (c, 3)
        Midway between them, in the world [m].
    normal : (c, 3)
        Unit vector from the first to the second.
    distance : (c,)
        Negative where they overlap [m].
    """

    posture: Index
    first: Index
    second: Index
    point: Array
    normal: Array
    distance: Array

    def depth(self, n: int) -> Array:
        """Return the deepest overlap of each of n postures, (n,) [m]; 0 where there is none."""
        deepest = np.zeros(n)
        np.maximum.at(deepest, self.posture, -self.distance)
        return np.maximum(deepest, 0.0)


@dataclass(frozen=True)
class NearLinks:
    """Distances of links that are near each other, linear about the postures they were found in.

    Attributes
    ----------
    posture : (c,)
        Which of the postures.
    place : (c, m)
        Coordinates of the posture.
    distance : (c,) [m]
    rates : (c, m)
        How the distance changes with the coordinates [m/rad].
    weight : (c,)
        How much an overlap counts.
    """

    posture: Index
    place: Array
    distance: Array
    rates: Array
    weight: Array

    def distance_at(self, x: Array) -> Array:
        """Return the distances at coordinates (n, m), (c,) [m]."""
        moved = x[self.posture] - self.place
        return self.distance + np.einsum("cm,cm->c", self.rates, moved)


def _agreeing(contacts: Contacts, nbody: int) -> Contacts:
    """Leave out contacts that would push two links otherwise than their deepest does.

    Links are often made of several shapes. Where two of them are deep in each other, the shortest
    way out of one shape leads further into another.
    """
    pair = (contacts.posture * nbody + contacts.first) * nbody + contacts.second
    order = np.lexsort((contacts.distance, pair))
    leads = np.flatnonzero(np.diff(pair[order], prepend=-1))
    of = np.repeat(order[leads], np.diff(np.append(leads, len(order))))
    same = np.sum(contacts.normal[order] * contacts.normal[of], axis=1) > AGREEING
    kept = np.sort(order[same])
    return Contacts(*(getattr(contacts, name)[kept] for name in Contacts.__annotations__))


class SelfContact:
    """Finds contacts of one robot hand with itself.

    Parameters
    ----------
    robot

    Attributes
    ----------
    pairs_left_out
        Names of links that overlap by construction, two each.
    """

    def __init__(self, robot: RobotHand) -> None:
        self._robot = robot
        self._model = copy.copy(robot.model)
        self._data = mujoco.MjData(self._model)
        model = self._model
        own = {body for body in range(model.nbody) if self._is_own(body)}
        for g in range(model.ngeom):
            if int(model.geom_bodyid[g]) not in own or model.geom_type[g] == _PLANE:
                model.geom_contype[g] = model.geom_conaffinity[g] = 0
        model.geom_margin[:] = MARGIN
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT.value)
        self._allowed: Mask = self._not_neighbours()
        self._qpos = model.jnt_qposadr[robot.joint_ids]
        self._moved_by: Mask = np.array([robot.links.moved_by(b) for b in range(model.nbody)])
        self.pairs_left_out: list[tuple[str, str]] = []
        self._leave_out_built_in()

    def find(self, x: Array) -> Contacts:
        """Return the contacts in postures of coordinates (n, m)."""
        model, data = self._model, self._data
        found: list[tuple[Array, ...]] = []
        for i, positions in enumerate(self._robot.joint_positions(x)):
            data.qpos[self._qpos] = positions
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            count = data.ncon
            if not count:
                continue
            contact = data.contact
            bodies = model.geom_bodyid[contact.geom[:count]]
            distance = contact.dist[:count]
            kept = np.flatnonzero(self._allowed[bodies[:, 0], bodies[:, 1]])
            if len(kept) > MOST:
                kept = kept[np.argsort(distance[kept])[:MOST]]
            if len(kept):
                found.append(
                    (
                        np.full(len(kept), i),
                        bodies[kept],
                        contact.pos[kept],
                        contact.frame[kept, :3],
                        distance[kept],
                    )
                )
        if not found:
            none = np.empty(0, dtype=np.int64)
            return Contacts(none, none, none, np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
        parts = [np.concatenate(part) for part in zip(*found, strict=True)]
        posture, bodies, point, normal, distance = parts
        return _agreeing(
            Contacts(posture, bodies[:, 0], bodies[:, 1], point, normal, distance), model.nbody
        )

    def near_links(self, contacts: Contacts, x: Array, weight: Array) -> NearLinks:
        """Return how distances change with the coordinates.

        Parameters
        ----------
        contacts
            As found at ``x``, (n, m).
        x
        weight : (n,)
            How much an overlap counts in each posture.
        """
        robot, at = self._robot, contacts.posture
        links, frames, slopes = robot.links, robot.link_frames(x), robot.joint_map.slopes(x)
        anchor, axis = frames.anchor[at], frames.axis[at]
        arm = cross(axis, contacts.point[:, None] - anchor)
        shift = np.where(links.slides[:, None], axis, arm)
        along = (shift @ contacts.normal[..., None])[..., 0]
        moved = self._moved_by.astype(float)
        change = (moved[contacts.second] - moved[contacts.first]) * along
        each = slopes if slopes.ndim == 2 else slopes[at]
        rates = (change[:, None] @ each)[:, 0]
        return NearLinks(at, x[at], contacts.distance, rates, weight[at])

    def _is_own(self, body: int) -> bool:
        """Tell whether a body is part of the hand: carried by the palm's group, or that itself."""
        model = self._model
        palm = int(model.body_weldid[self._robot.palm_body])
        at = body
        while at >= 0:
            if int(model.body_weldid[at]) == palm:
                return True
            if at == 0:
                return False
            at = int(model.body_parentid[at])
        return False

    def _not_neighbours(self) -> Mask:
        """Return which pairs of bodies may touch: those that no joint connects directly."""
        model = self._model
        weld = model.body_weldid
        above = weld[model.body_parentid[weld]]
        one, other = weld[:, None], weld[None, :]
        adjacent = (one == other) | (above[:, None] == other) | (above[None, :] == one)
        return ~adjacent

    def _leave_out_built_in(self) -> None:
        """Leave out pairs that overlap by construction."""
        robot = self._robot
        rng = np.random.default_rng(0)
        drawn = robot.lower + rng.random((_DRAWN, len(robot.lower))) * (robot.upper - robot.lower)
        counts = np.zeros((self._model.nbody,) * 2)
        contacts = self.find(drawn)
        deep = contacts.distance < -BUILT_IN
        seen = {
            (int(i), int(a), int(b))
            for i, a, b in zip(
                contacts.posture[deep], contacts.first[deep], contacts.second[deep], strict=True
            )
        }
        for _, a, b in seen:
            counts[a, b] += 1
        start = np.clip(robot.reference, robot.lower, robot.upper)
        at_start = self.find(start[None])
        for a, b, d in zip(at_start.first, at_start.second, at_start.distance, strict=True):
            if d < -BUILT_IN:
                counts[a, b] = _DRAWN
        for a, b in np.argwhere(counts > OFTEN * _DRAWN):
            self._allowed[a, b] = self._allowed[b, a] = False
            self.pairs_left_out.append((self._model.body(a).name, self._model.body(b).name))

"""How the hand presses on the object: normal force per part of the hand, and deepest overlap.

One simulation's contacts are read from its state (`ContactLog`). A batch has no contacts to look
at, only arrays of fixed size, so that its models carry contact sensors (`ContactSensors`).
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.joints import FINGERS
from handsim.simulation.rollout import CONTACT_PARTS

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

SLOTS = 12
"""Contacts of the object with one sensor's part of the hand that are looked at."""
_FIELDS = (
    mujoco.mjtConDataField.mjCONDATA_FOUND,
    mujoco.mjtConDataField.mjCONDATA_FORCE,
    mujoco.mjtConDataField.mjCONDATA_DIST,
)
_WIDTH, _NORMAL, _DISTANCE = 5, 1, 4
"""Numbers a slot: contacts found, force (normal first) and distance."""


def parts_of_geoms(model: mujoco.MjModel) -> Index:
    """Return the column of `CONTACT_PARTS` for each geom of the hand, -1 elsewhere."""
    parts = np.full(model.ngeom, -1)
    forearm_root = model.body_rootid[model.body("forearm").id]
    for geom in range(model.ngeom):
        body = model.geom_bodyid[geom]
        if model.body_rootid[body] == forearm_root:
            parts[geom] = _part(model.body(body).name)
    return parts


class ContactLog:
    """Keeps the contacts of one simulation, sample after sample, and adds them up at the end."""

    def __init__(self, data: mujoco.MjData) -> None:
        self._data = data
        self._counts: list[int] = []
        self._geoms: list[Index] = []
        self._distances: list[Array] = []
        self._addresses: list[npt.NDArray[np.int32]] = []
        self._forces: list[Array] = []

    def keep(self) -> None:
        """Keep what touches now."""
        data = self._data
        self._counts.append(data.ncon)
        if data.ncon:
            contact = data.contact
            address = contact.efc_address.copy()
            self._geoms.append(contact.geom.copy())
            self._distances.append(contact.dist.copy())
            self._addresses.append(address)
            # A contact without a force has no address, but -1; what that picks is left out below.
            self._forces.append(data.efc_force[address])

    def totals(self, parts: Index, of_object: npt.NDArray[np.bool_]) -> tuple[Array, Array]:
        """Return forces on the object (n, 6) [N] and the deepest overlap with it (n,) [m].

        Parameters
        ----------
        parts, of_object : (n_geom,)
            As `parts_of_geoms` gives them, and whether a geom is the object's.
        """
        n = len(self._counts)
        force, depth = np.zeros((n, len(CONTACT_PARTS))), np.zeros(n)
        if not self._geoms:
            return force, depth
        sample = np.repeat(np.arange(n), self._counts)
        first, second = np.concatenate(self._geoms).T
        normal, distance = np.concatenate(self._forces), np.concatenate(self._distances)
        part = np.maximum(parts[first], parts[second])
        held = (part >= 0) & (of_object[first] | of_object[second])
        held &= np.concatenate(self._addresses) >= 0
        np.add.at(force, (sample[held], part[held]), normal[held])
        np.maximum.at(depth, sample[held], -distance[held])
        return force, depth


def replace_sensors(spec: mujoco.MjSpec) -> None:
    """Leave no sensors but of contact: one a finger, and one a body of palm and forearm.

    Nothing moves otherwise by it.
    """
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    for body, part in _touching_bodies(spec):
        whole = part in FINGERS
        kind = mujoco.mjtObj.mjOBJ_XBODY if whole else mujoco.mjtObj.mjOBJ_BODY
        spec.add_sensor(
            name=body,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=kind,
            objname=body,
            reftype=mujoco.mjtObj.mjOBJ_XBODY,
            refname="object",
            intprm=[sum(1 << int(field) for field in _FIELDS), 0, SLOTS],
        )


class ContactSensors:
    """Reads the sensors of `replace_sensors` of many simulations at once.

    Parameters
    ----------
    model
        Any of theirs: sensors have the same places in all.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._parts = [_part(model.sensor(i).name) for i in range(model.nsensor)]

    def totals(self, sensordata: Array) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
        """Return forces (N, 6) [N], overlaps (N,) [m] and whether a sensor had too few slots (N,).

        Parameters
        ----------
        sensordata : (N, n_sensordata)
        """
        shape = (len(sensordata), len(self._parts), SLOTS, _WIDTH)
        slots = sensordata.reshape(shape)
        by_sensor = np.zeros(shape[:2])
        for i in range(SLOTS):  # in the order of the contacts, as a sum over them would be
            by_sensor += slots[:, :, i, _NORMAL]
        force = np.zeros((len(sensordata), len(CONTACT_PARTS)))
        for i, part in enumerate(self._parts):
            force[:, part] += by_sensor[:, i]
        depth = np.maximum(0.0, -slots[:, :, :, _DISTANCE].min(axis=(1, 2)))
        return force, depth, (slots[:, :, 0, 0].max(axis=1) > SLOTS)


def _touching_bodies(spec: mujoco.MjSpec) -> Iterator[tuple[str, str]]:
    """Yield bodies that stand for a part of the hand: a finger's first, and all of the palm's."""
    for body in spec.body("forearm").find_all(mujoco.mjtObj.mjOBJ_BODY):
        finger = _finger(body.name)
        if finger not in FINGERS:
            yield body.name, "palm"
        elif _finger(body.parent.name) != finger:
            yield body.name, finger
    yield "forearm", "palm"


def _part(body: str) -> int:
    """Column of `CONTACT_PARTS` for a body of the hand."""
    finger = _finger(body)
    return CONTACT_PARTS.index(finger if finger in FINGERS else "palm")


def _finger(body: str) -> str:
    """First word of a body's name; of those that belong to a finger, its name."""
    return body.partition("_")[0]

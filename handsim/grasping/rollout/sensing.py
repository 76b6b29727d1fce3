"""What is seen of object and palm: their poses, and how the hand presses on the object.

A scene that is simulated has sensors for it, for these come as one array, of one simulation as of
a batch, and need to be computed only when they are read.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.types import Array

SLOTS = 8
"""Contacts with the object of a finger, or of a body of the palm, that its sensor can tell; up to
4 were seen in grasps of all tasks."""

_POSES = (
    ("object_pos", "object", mujoco.mjtSensor.mjSENS_FRAMEPOS, mujoco.mjtObj.mjOBJ_BODY),
    ("object_quat", "object", mujoco.mjtSensor.mjSENS_FRAMEQUAT, mujoco.mjtObj.mjOBJ_XBODY),
    ("object_origin", "object", mujoco.mjtSensor.mjSENS_FRAMEPOS, mujoco.mjtObj.mjOBJ_XBODY),
    ("object_x", "object", mujoco.mjtSensor.mjSENS_FRAMEXAXIS, mujoco.mjtObj.mjOBJ_XBODY),
    ("object_y", "object", mujoco.mjtSensor.mjSENS_FRAMEYAXIS, mujoco.mjtObj.mjOBJ_XBODY),
    ("object_z", "object", mujoco.mjtSensor.mjSENS_FRAMEZAXIS, mujoco.mjtObj.mjOBJ_XBODY),
    ("palm_pos", "palm", mujoco.mjtSensor.mjSENS_FRAMEPOS, mujoco.mjtObj.mjOBJ_XBODY),
    ("palm_quat", "palm", mujoco.mjtSensor.mjSENS_FRAMEQUAT, mujoco.mjtObj.mjOBJ_XBODY),
)
"""Poses in the world: name, body, kind, and whether of its centre of mass or of its frame."""
_FIELDS = (
    mujoco.mjtConDataField.mjCONDATA_FOUND,
    mujoco.mjtConDataField.mjCONDATA_FORCE,
    mujoco.mjtConDataField.mjCONDATA_DIST,
)
_MARK = "seen_"
_WIDTH, _NORMAL, _DISTANCE = 5, 1, 4
"""Numbers a slot: contacts found, force (normal first) and distance."""


def add_senses(spec: mujoco.MjSpec) -> None:
    """Give a scene the sensors that `Senses` reads; it moves as before."""
    for name, body, kind, of in _POSES:
        spec.add_sensor(name=_MARK + name, type=kind, objtype=of, objname=body)
    for body, part in _touching_bodies(spec):
        whole = part in FINGERS
        spec.add_sensor(
            name=_MARK + body,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_XBODY if whole else mujoco.mjtObj.mjOBJ_BODY,
            objname=body,
            reftype=mujoco.mjtObj.mjOBJ_XBODY,
            refname="object",
            intprm=[sum(1 << int(field) for field in _FIELDS), 0, SLOTS],
        )


class Senses:
    """Reads the sensors of `add_senses`, of many samples or simulations at once.

    Parameters
    ----------
    model
        A scene; those of one shape have their sensors in the same places.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        first = model.sensor(_MARK + _POSES[0][0]).id
        names = [model.sensor(i).name.removeprefix(_MARK) for i in range(first, model.nsensor)]
        starts, sizes = model.sensor_adr[first:], model.sensor_dim[first:]
        ends = starts + sizes - starts[0]
        self.first = int(starts[0])
        """Where these sensors begin among all."""
        n = len(_POSES)
        self.n_poses = int(ends[n - 1])
        """How many numbers the poses are, which come first."""
        self._poses = {
            name: slice(end - size, end)
            for name, size, end in zip(names[:n], sizes.tolist(), ends.tolist(), strict=False)
        }
        self.height = slice(2, 3)
        """Where the height of the object's centre of mass is, the first pose's z."""
        self._parts = [_part(body) for body in names[n:]]

    def poses(self, sensed: Array) -> dict[str, Array]:
        """Return poses by name, (N, 3) [m] or (N, 4), from readings (N, n_poses or more)."""
        return {name: sensed[:, place].copy() for name, place in self._poses.items()}

    def counts(self, sensed: Array) -> Array:
        """Return how many contacts each sensor found, (..., n_sensors), as a view."""
        return sensed[..., self.n_poses :: SLOTS * _WIDTH]

    def contacts(self, sensed: Array) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
        """Return forces (N, 6) [N], overlaps (N,) [m] and whether a sensor had too few slots (N,).

        Parameters
        ----------
        sensed : (N, ...)
            Readings from `first` on.

        Returns
        -------
        Normal forces on the object summed up for each part of the hand (`CONTACT_PARTS`), and how
        deep hand and object overlap at most.
        """
        shape = (len(sensed), len(self._parts), SLOTS, _WIDTH)
        slots = sensed[:, self.n_poses :].reshape(shape)
        by_sensor = slots[:, :, 0, _NORMAL].copy()
        for i in range(1, SLOTS):  # in the order of the contacts, as a sum over them would be
            by_sensor += slots[:, :, i, _NORMAL]
        force = np.zeros((len(sensed), len(CONTACT_PARTS)))
        for i, part in enumerate(self._parts):
            force[:, part] += by_sensor[:, i]
        depth = np.maximum(0.0, -slots[:, :, :, _DISTANCE].min(axis=(1, 2)))
        return force, depth, self.counts(sensed).max(axis=1) > SLOTS


def contacts_of(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, float]:
    """Return what `Senses.contacts` does of one simulation, however many contacts there are."""
    force, contact = np.zeros(len(CONTACT_PARTS)), data.contact
    root = model.body_rootid[model.geom_bodyid[contact.geom]]
    object_id, forearm = model.body("object").id, model.body("forearm").rootid
    first, second = root.T
    held = ((first == object_id) & (second == forearm)) | (
        (first == forearm) & (second == object_id)
    )
    held &= contact.efc_address >= 0
    for pair, roots, address in zip(
        contact.geom[held], root[held], contact.efc_address[held], strict=True
    ):
        body = model.geom_bodyid[pair[roots == forearm][0]]
        force[_part(model.body(body).name)] += data.efc_force[address]
    return force, max(0.0, -float(contact.dist[held].min(initial=0.0)))


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

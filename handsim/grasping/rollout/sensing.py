"""Sensors of object and palm: their poses, and how the hand presses on the object.

A scene gets MuJoCo's own sensors for them. Their values come as one array, of one simulation or of
a batch, and are computed only where they are needed.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator, Sequence
from operator import add
from typing import NamedTuple

import mujoco
import numpy as np

from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.tasks.task import Pressed
from handsim.types import Array, Mask

SLOTS = 8
"""Contacts with the object that the sensor of a finger, or of a body of the palm, has room for. In
grasps of all tasks there were at most 4."""
NO_SENSORS = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
"""Bit of a model's ``opt.disableflags`` that keeps sensors from being computed."""

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
"""Poses in the world: name, body, type of the sensor, and whether the pose is that of the body's
centre of mass (``BODY``) or of its frame (``XBODY``)."""
_FOUND, _FORCE, _DIST, _NORM = (
    1 << int(field)
    for field in (
        mujoco.mjtConDataField.mjCONDATA_FOUND,
        mujoco.mjtConDataField.mjCONDATA_FORCE,
        mujoco.mjtConDataField.mjCONDATA_DIST,
        mujoco.mjtConDataField.mjCONDATA_NORMAL,
    )
)
_NEAREST, _TOGETHER = 1, 3  # MuJoCo's ways to reduce contacts to one: "mindist", "netforce"
_HELD = "held"
"""Where the object's centre of mass is in the palm's frame."""
_CARRIED = "carried"
"""What hand and arm press the object with altogether, in the world."""
_PREFIX = "seen_"
"""Of the names of these sensors."""
_NOTHING = (0.0, 0.0, 0.0)
_WIDTH, _PUSH, _DISTANCE, _DIRECTION = 8, 1, 4, slice(5, 8)
"""A slot has 8 numbers: contacts found, force (3, the normal one first), distance, normal (3)."""


def add_sensors(spec: mujoco.MjSpec, pressed: Sequence[Pressed] = ()) -> None:
    """Give a scene the sensors that `Sensors` reads; how it moves stays the same.

    Parameters
    ----------
    spec
    pressed
        Bodies of the object whose forces from single fingers are wanted.
    """
    for name, body, kind, frame in _POSES:
        spec.add_sensor(name=_PREFIX + name, type=kind, objtype=frame, objname=body)
    for body, part in _touching_bodies(spec):
        whole = part in FINGERS
        spec.add_sensor(
            name=_PREFIX + body,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_XBODY if whole else mujoco.mjtObj.mjOBJ_BODY,
            objname=body,
            reftype=mujoco.mjtObj.mjOBJ_XBODY,
            refname="object",
            intprm=[_FOUND | _FORCE | _DIST | _NORM, 0, SLOTS],
        )
    spec.add_sensor(
        name=_PREFIX + _HELD,
        type=mujoco.mjtSensor.mjSENS_FRAMEPOS,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        objname="object",
        reftype=mujoco.mjtObj.mjOBJ_XBODY,
        refname="palm",
    )
    spec.add_sensor(
        name=_PREFIX + _CARRIED,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_XBODY,
        objname="forearm",
        reftype=mujoco.mjtObj.mjOBJ_XBODY,
        refname="object",
        intprm=[_FORCE, _TOGETHER, 1],
    )
    _add_contact(spec, "table_force", "forearm", "table", _FORCE, _TOGETHER)
    _add_contact(spec, "table_overlap", "forearm", "table", _DIST, _NEAREST)
    for i, each in enumerate(pressed):
        for finger in each.fingers:
            first = next(body for body, part in _touching_bodies(spec) if part == finger)
            _add_contact(spec, f"pressed_{i}_{finger}", first, each.body, _FORCE, _TOGETHER)


def _add_contact(
    spec: mujoco.MjSpec, name: str, body: str, touched: str, fields: int, reduced: int
) -> None:
    """Add a sensor of all contacts of a body and its children with a body or the table."""
    table = touched == "table"
    spec.add_sensor(
        name=_PREFIX + name,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_XBODY,
        objname=body,
        reftype=mujoco.mjtObj.mjOBJ_GEOM if table else mujoco.mjtObj.mjOBJ_BODY,
        refname=touched,
        intprm=[fields, reduced, 1],
    )


class Touch(NamedTuple):
    """How hand and object touch, at one time or many.

    Attributes
    ----------
    force : (..., 6) [N]
        Normal forces on the object, summed up for each part of the hand (`CONTACT_PARTS`).
    press : (..., 6, 3) [N]
        The same forces as vectors in the world.
    penetration : (...,) [m]
        Deepest overlap of hand and object.
    """

    force: Array
    press: Array
    penetration: Array


class Sensors:
    """Where the sensors of `add_sensors` are, and what their values mean.

    Values are those of many samples or simulations at once: (..., n_values), from `first` on.

    Parameters
    ----------
    model
        A scene; models of one shape have their sensors in the same places.

    Attributes
    ----------
    first
        Where these sensors begin in MuJoCo's ``sensordata``.
    n_poses
        How many of their values are poses, which come first.
    height
        Which value is the height of the object's centre of mass [m].
    """

    height = 2

    def __init__(self, model: mujoco.MjModel) -> None:
        first = model.sensor(_PREFIX + _POSES[0][0]).id
        names = [model.sensor(i).name.removeprefix(_PREFIX) for i in range(first, model.nsensor)]
        starts, sizes = model.sensor_adr[first:], model.sensor_dim[first:]
        ends = starts + sizes - starts[0]
        n = len(_POSES)
        self.first, self.n_poses = int(starts[0]), int(ends[n - 1])
        self._poses = {
            name: slice(end - size, end)
            for name, size, end in zip(names[:n], sizes.tolist(), ends.tolist(), strict=False)
        }
        held, table = names.index(_HELD), names.index("table_force")
        self._parts = [_part(body) for body in names[n:held]]
        self._fingers = [self._parts.index(CONTACT_PARTS.index(finger)) for finger in FINGERS]
        self._slots = slice(self.n_poses, int(starts[held] - starts[0]))
        self._counts = slice(self._slots.start, self._slots.stop, SLOTS * _WIDTH)
        self._held = slice(self._slots.stop, self._slots.stop + 3)
        self._carried = self._held.stop + 2
        places = self._slots.start + SLOTS * _WIDTH * np.array(self._fingers)
        pushes = places + _PUSH
        self._felt = np.r_[places, pushes, pushes + _WIDTH, self._held.start : self._carried + 1]
        self._pushes = [slice(first, first + SLOTS * _WIDTH, _WIDTH) for first in pushes.tolist()]
        self._table_force, self._table_overlap = self._carried + 3, self._carried + 4
        numbers = [name.split("_")[1] for name in names[table + 2 :]]
        self._pressed = [
            [int(ends[table + 2 + i]) for i, each in enumerate(numbers) if each == number]
            for number in sorted(set(numbers))
        ]

    def poses(self, values: Array) -> dict[str, Array]:
        """Return poses by name, (n, 3) [m] or (n, 4), from values (n, n_poses or more)."""
        return {name: values[:, place].copy() for name, place in self._poses.items()}

    def posed(self, values: Array) -> list[float]:
        """Return the numbers of `poses` of one simulation (n_values,), in a row; for loops."""
        return values[: self.n_poses].tolist()

    @property
    def n_pressed(self) -> int:
        """How many bodies are watched for the fingers that press them."""
        return len(self._pressed)

    def n_contacts(self, values: Array) -> Array:
        """Return how many contacts each contact sensor found, (..., n_sensors), as a view."""
        return values[..., self._slots][..., :: SLOTS * _WIDTH]

    def contacts(self, values: Array) -> tuple[Touch, Mask]:
        """Return how hand and object touch, and whether a sensor had too few slots, (...,)."""
        shape, rows = values.shape[:-1], values.reshape(-1, values.shape[-1])
        n, found = len(rows), self.n_contacts(rows)
        force, depth = np.zeros((n, len(CONTACT_PARTS))), np.zeros(n)
        press = np.zeros((*force.shape, 3))
        for sensor, most in enumerate(found.max(axis=0).tolist()):
            if not most:  # slots of contacts that there are not are 0
                continue
            first, part = self._slots.start + sensor * SLOTS * _WIDTH, self._parts[sensor]
            end = first + int(min(SLOTS, most)) * _WIDTH
            slots = rows[:, first:end].reshape(n, -1, _WIDTH)
            vectors = slots[:, :, _PUSH, None] * slots[:, :, _DIRECTION]
            pushed, pressed = slots[:, 0, _PUSH].copy(), vectors[:, 0]
            for slot in range(1, slots.shape[1]):  # in the order of the contacts
                pushed += slots[:, slot, _PUSH]
                pressed += vectors[:, slot]
            force[:, part] += pushed
            press[:, part] += pressed
            depth = np.maximum(depth, -slots[:, :, _DISTANCE].min(axis=1))
        crowded = found.max(axis=1) > SLOTS
        touch = Touch(force.reshape(*shape, -1), press.reshape(*shape, -1, 3), depth.reshape(shape))
        return touch, crowded.reshape(shape)

    def touching(self, values: Array) -> tuple[list[float], list[tuple[float, float, float]]]:
        """Return forces (6,) and presses (6, 3) [N], as of `Touch`, of one simulation; for loops.

        Parameters
        ----------
        values : (n_values,)
            Contacts beyond a sensor's slots do not count.
        """
        force = [0.0] * len(CONTACT_PARTS)
        press = [_NOTHING] * len(CONTACT_PARTS)
        first = self._slots.start
        for found, part in zip(values[self._counts].tolist(), self._parts, strict=True):
            if found:
                end = first + int(min(found, SLOTS)) * _WIDTH
                numbers = values[first:end].tolist()
                total, (a, b, c) = force[part], press[part]
                for slot in range(0, len(numbers), _WIDTH):
                    push, (x, y, z) = numbers[slot + _PUSH], numbers[slot + 5 : slot + 8]
                    total += push
                    a, b, c = a + push * x, b + push * y, c + push * z
                force[part], press[part] = total, (a, b, c)
            first += SLOTS * _WIDTH
        return force, press

    def felt(self, values: Array) -> tuple[list[list[float]], list[list[float]]]:
        """Return `finger_forces` (n, 5), and `held`, two other numbers and `carried` (n, 6)."""
        n, rows = len(FINGERS), values.take(self._felt, axis=1).tolist()
        forces: list[list[float]] = []
        for i, row in enumerate(rows):
            each = list(map(add, row[n : 2 * n], row[2 * n : 3 * n]))
            if max(row[:n]) > 2.0:  # seldom; slots of contacts that there are not are 0
                each = [
                    _in_pairs(*values[i, place].tolist()) if found > 2.0 else force
                    for found, force, place in zip(row, each, self._pushes, strict=False)
                ]
            forces.append(each)
        return forces, [row[3 * n :] for row in rows]

    def finger_forces(self, values: Array) -> list[list[float]]:
        """Return the normal forces of the fingers on the object (n, 5) [N]; for loops."""
        return self.felt(values)[0]

    def held(self, values: Array) -> Array:
        """Return where the object's centre of mass is in the palm's frame (n, 3) [m]."""
        return values[:, self._held].copy()

    def carried(self, values: Array) -> Array:
        """Return the force with which hand and arm carry the object, upwards (n,) [N]."""
        return values[:, self._carried]

    def table(self, values: Array) -> tuple[Array, Array]:
        """Return what the hand presses on the table (...,) [N], and its overlap with it [m]."""
        overlap = np.maximum(0.0, -values[..., self._table_overlap])
        return np.abs(values[..., self._table_force]), overlap

    def pressed(self, values: Array) -> Array:
        """Return the greatest force of the fingers that each rule names on its body, (..., n)."""
        forces = np.zeros((*values.shape[:-1], self.n_pressed))
        for i, ends in enumerate(self._pressed):
            for end in ends:
                force = np.sqrt((values[..., end - 3 : end] ** 2).sum(axis=-1))
                forces[..., i] = np.maximum(forces[..., i], force)
        return forces


def _in_pairs(*numbers: float) -> float:
    """Return a sum of eight in one order: the same bits, however many simulations there are."""
    a, b, c, d, e, f, g, h = numbers
    return ((a + b) + (c + d)) + ((e + f) + (g + h))


def contacts_of(model: mujoco.MjModel, data: mujoco.MjData) -> Touch:
    """Return how hand and object touch in one simulation, however many contacts there are."""
    force, press = np.zeros(len(CONTACT_PARTS)), np.zeros((len(CONTACT_PARTS), 3))
    contact = data.contact
    root = model.body_rootid[model.geom_bodyid[contact.geom]]
    object_id, forearm = model.body("object").id, model.body("forearm").rootid
    first, second = root.T
    held = ((first == object_id) & (second == forearm)) | (
        (first == forearm) & (second == object_id)
    )
    held &= contact.efc_address >= 0
    for pair, roots, address, frame in zip(
        contact.geom[held],
        root[held],
        contact.efc_address[held],
        contact.frame[held],
        strict=True,
    ):
        body = model.geom_bodyid[pair[roots == forearm][0]]
        part, push = _part(model.body(body).name), data.efc_force[address]
        force[part] += push
        # MuJoCo's normal points from the first geom to the second.
        press[part] += push * (frame[:3] if roots[0] == forearm else -frame[:3])
    depth = max(0.0, -float(contact.dist[held].min(initial=0.0)))
    return Touch(force, press, np.array(depth))


def _touching_bodies(spec: mujoco.MjSpec) -> Iterator[tuple[str, str]]:
    """Yield bodies with a contact sensor and their part: each finger's first, all of the palm's."""
    for body in spec.body("forearm").find_all(mujoco.mjtObj.mjOBJ_BODY):
        finger = _finger(body.name)
        if finger not in FINGERS:
            yield body.name, "palm"
        elif _finger(body.parent.name) != finger:
            yield body.name, finger
    yield "forearm", "palm"


def _part(body: str) -> int:
    """Return the column of `CONTACT_PARTS` for a body of the hand."""
    finger = _finger(body)
    return CONTACT_PARTS.index(finger if finger in FINGERS else "palm")


def _finger(body: str) -> str:
    """Return the first word of a body's name, which is the finger's where it belongs to one."""
    return body.partition("_")[0]

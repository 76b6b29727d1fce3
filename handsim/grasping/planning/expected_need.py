"""The force that a planned grasp will need, from where thumb and fingers are to press.

A grip that knows the weight alone loses what is held beside its centre of mass: a hammer turns, and
a pen. People know where a thing's weight is when they have lifted it once.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.gripping.need import HandContacts, least_grip
from handsim.hand.mjcf import FRICTION
from handsim.objects.mjcf import surface_of
from handsim.objects.object import GraspObject, TriangleMesh
from handsim.physics import GRAVITY
from handsim.tasks.task import Task
from handsim.types import Array

FINGER_SPACING = 0.020
"""Between neighbouring fingers that press side by side [m]: about a finger's breadth."""


def expected_need(task: Task, friction: float = FRICTION[0]) -> float:
    """Return the least force a side that carries a task's object, wherever it is turned to [N].

    Parameters
    ----------
    task
        Its grasp says where thumb and fingers press, its steps how the object is turned.
    friction
        Sliding friction of the hand.
    """
    contacts = _pressing(task, friction)
    centre, mass = centre_of_mass(task.object), task.object.mass
    loads = [mass * GRAVITY * up for up in _upwards(task)]
    return max(least_grip(contacts, centre, load) for load in loads)


def centre_of_mass(grasp_object: GraspObject) -> Array:
    """Return an object's centre of mass in its own frame, with all hinges at 0, (3,) [m]."""
    pieces = [*grasp_object.pieces, *(p for link in grasp_object.links for p in link.pieces)]
    masses = np.array([piece.mass for piece in pieces])
    meshes = [surface_of(piece) for piece in pieces]
    return masses @ np.array([_centroid(mesh) for mesh in meshes]) / masses.sum()


def _centroid(mesh: TriangleMesh) -> Array:
    """Return the centroid of a closed mesh of uniform density, (3,) [m]."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return (volumes[:, None] * (a + b + c) / 4.0).sum(axis=0) / volumes.sum()


def _pressing(task: Task, friction: float) -> HandContacts:
    """Return the contacts of thumb and fingers as the grasp has them, object frame."""
    grasp = task.grasp
    across = np.array(grasp.opposition) / np.linalg.norm(grasp.opposition)
    row = np.cross(across, grasp.approach)
    row /= np.linalg.norm(row)
    middle = np.array(grasp.point)
    fingers = [finger for finger in grasp.fingers if finger != "thumb"]
    places = FINGER_SPACING * (np.arange(len(fingers)) - (len(fingers) - 1) / 2)
    half = 0.5 * grasp.width * across
    points = [middle - half, *(middle + half + place * row for place in places)]
    normals = [across, *(-across for _ in fingers)]
    n = len(points)
    torsion = FRICTION[1] * friction / FRICTION[0]
    return HandContacts(
        np.array(points), np.array(normals), np.full(n, friction), np.full(n, torsion)
    )


def _upwards(task: Task) -> Iterator[Array]:
    """Yield which way is up for the object, at first and after each step, (3,)."""
    turn = Rotation.from_euler("z", np.deg2rad(task.yaw_deg))
    yield turn.inv().apply([0.0, 0.0, 1.0])
    for step in task.steps:
        if step.angle_deg and not step.flex:
            added = np.deg2rad(step.angle_deg) * np.array(step.axis)
            turn = Rotation.from_rotvec(added) * turn
            yield turn.inv().apply([0.0, 0.0, 1.0])

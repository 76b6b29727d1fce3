"""The 13 objects of Table I, put into MuJoCo scenes.

Contact is between convex pieces (geom group 3); what is seen, and what carries mass and inertia,
are watertight meshes (group 2) read from ``assets/objects``. MuJoCo integrates each mesh's
inertia exactly.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping
from types import MappingProxyType

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.errors import InputError, UnknownNameError
from handsim.objects.catalogue import OBJECTS
from handsim.objects.mesh_import import object_from_mesh
from handsim.objects.meshes.shipped_mesh import points_of, read_mesh, surface_of
from handsim.objects.object import Collider, GraspObject, Hinge, Piece
from handsim.physics import CONTACT_SOLREF
from handsim.types import Array

__all__ = [
    "OBJECTS",
    "add_object",
    "centre_of_mass",
    "object_by_name",
    "object_from_mesh",
    "points_of",
    "read_mesh",
    "surface_of",
]

VISUAL_GROUP, COLLISION_GROUP = 2, 3
"""Geom groups as in mujoco_menagerie: 2 is drawn, 3 takes part in contact."""

TABLE_FRICTION = (0.5, 0.005, 1e-4)
"""Sliding, torsional [m] and rolling [m] friction of object on table. Sliding: dry wood, glass and
plastics on wood lie between 0.2 and 0.6 (engineering handbooks)."""

_KINDS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
}


def object_by_name(name: str) -> GraspObject:
    """Return one of the built-in objects.

    Raises
    ------
    UnknownNameError
        If there is none of that name; the nearest are offered.
    """
    if name not in OBJECTS:
        raise UnknownNameError("object", name, tuple(OBJECTS))
    return OBJECTS[name]


def add_object(
    spec: mujoco.MjSpec,
    grasp_object: GraspObject,
    *,
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    yaw: float = 0.0,
    start: Mapping[str, float] = MappingProxyType({}),
    mass_scale: float = 1.0,
) -> mujoco.MjsBody:
    """Add an object to a scene as body ``object`` with the free joint ``object_joint``.

    Parameters
    ----------
    pos, yaw
        Pose of the object frame in the world [m], [rad] about z.
    start
        Angles of hinges that do not start at 0, by name [rad].
    mass_scale
        Factor on all masses and inertias.

    Returns
    -------
    mujoco.MjsBody
        The main body.

    Raises
    ------
    InputError
        If ``mass_scale`` is not positive or ``start`` leaves the range of a hinge.
    UnknownNameError
        If ``start`` names a hinge that the object does not have.
    FileError
        If a mesh is missing or damaged.
    """
    if not (np.isfinite(mass_scale) and mass_scale > 0):
        raise InputError(f"mass scale {mass_scale:g} is not positive; 1 keeps the object's mass")
    hinges = {link.hinge.name: link.hinge for link in grasp_object.links}
    for name in start:
        if name not in hinges:
            raise UnknownNameError(f"hinge of '{grasp_object.name}'", name, tuple(hinges))
    quat = [np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]
    body = spec.worldbody.add_body(name="object", pos=pos, quat=quat)
    body.add_freejoint(name="object_joint")
    _add_shapes(spec, body, grasp_object.pieces, grasp_object.colliders, mass_scale)
    names = ["object", *hinges]
    for i, link in enumerate(grasp_object.links):
        child = body.add_body(name=link.hinge.name)
        _add_hinge(spec, child, link.hinge, start.get(link.hinge.name, 0.0))
        _add_shapes(spec, child, link.pieces, link.colliders, mass_scale)
        for other in names[: i + 1]:
            spec.add_exclude(bodyname1=other, bodyname2=link.hinge.name)
    return body


def centre_of_mass(grasp_object: GraspObject) -> Array:
    """Return the centre of mass of an object, hinges at 0, in the object frame, (3,) [m]."""
    spec = mujoco.MjSpec()
    add_object(spec, grasp_object)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.subtree_com[model.body("object").id].copy()


def _add_shapes(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    pieces: tuple[Piece, ...],
    colliders: tuple[Collider, ...],
    mass_scale: float,
) -> None:
    for i, piece in enumerate(pieces):
        name = piece.mesh if isinstance(piece.mesh, str) else f"{body.name}_{i}"
        mesh = surface_of(piece)
        spec.add_mesh(
            name=name,
            uservert=mesh.vertices.ravel(),
            userface=mesh.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT,
        )
        spec.add_material(
            name=name, rgba=piece.rgba, specular=piece.shine, shininess=0.2 + 0.7 * piece.shine
        )
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            material=name,
            mass=piece.mass * mass_scale,
            contype=0,
            conaffinity=0,
            group=VISUAL_GROUP,
        )
    for i, collider in enumerate(colliders):
        name = f"{body.name}_contact_{i}"
        contact = {
            "name": name,
            "mass": 0.0,
            "condim": 4,
            "friction": TABLE_FRICTION,
            "solref": CONTACT_SOLREF,
            "group": COLLISION_GROUP,
            "rgba": [0.2, 0.6, 0.3, 0.4],
        }
        if collider.kind == "hull":
            spec.add_mesh(name=name, uservert=points_of(collider).ravel())
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **contact)
        else:
            size = [*collider.size, 0.0, 0.0][:3]
            kind = _KINDS[collider.kind]
            body.add_geom(type=kind, size=size, pos=collider.pos, quat=collider.quat, **contact)


def _add_hinge(spec: mujoco.MjSpec, body: mujoco.MjsBody, hinge: Hinge, start: float) -> None:
    """Add the hinge, open at ``start`` [rad], and for a screw the slide that is coupled to it."""
    lower, upper = hinge.range_deg
    if not lower <= np.rad2deg(start) <= upper:
        raise InputError(
            f"hinge '{hinge.name}' cannot start at {np.rad2deg(start):g} deg;"
            f" its range is {lower:g} to {upper:g} deg"
        )
    unit = np.rad2deg if spec.compiler.degree else np.float64  # what the scene counts angles in
    axis, anchor = np.array(hinge.axis), np.array(hinge.anchor)
    turn = Rotation.from_rotvec(axis * start)
    body.quat = turn.as_quat(scalar_first=True)
    body.pos = anchor - turn.apply(anchor) + axis * hinge.pitch * start / (2 * np.pi)
    body.add_joint(
        name=hinge.name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=hinge.axis,
        pos=hinge.anchor,
        ref=unit(start),
        limited=True,
        range=unit(np.deg2rad(hinge.range_deg)),
        stiffness=hinge.stiffness,
        springref=unit(np.deg2rad(hinge.rest_deg)),
        damping=hinge.damping,
        frictionloss=hinge.friction,
        armature=1e-6,
        solref_limit=[0.004, 1.0],
    )
    if hinge.pitch:
        # Turn as a function of rise, not the reverse: MuJoCo estimates the softness of the
        # coupling from the first joint's inertia, and the reverse lets the link sink.
        slide = f"{hinge.name}_rise"
        body.add_joint(name=slide, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=hinge.axis, damping=0.1)
        coupling = spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            name=slide,
            name1=hinge.name,
            name2=slide,
            solref=[0.005, 1.0],
        )
        coupling.data[1] = 2 * np.pi / hinge.pitch  # turn per metre risen

"""Geoms of a model as coloured triangle meshes, for a web page."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from handsim.errors import InputError

if TYPE_CHECKING:
    import trimesh

SHOWN_GROUPS = 3
"""Geoms of the groups below this are drawn, as MuJoCo does; collision shapes have higher ones."""
_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)  # what MuJoCo gives a geom that leaves colour to its material


def visible_geoms(model: mujoco.MjModel) -> list[int]:
    """Return the ids of the geoms that are drawn."""
    return [
        geom
        for geom in range(model.ngeom)
        if model.geom_group[geom] < SHOWN_GROUPS and geom_colour(model, geom)[3] > 0
    ]


def geom_colour(model: mujoco.MjModel, geom: int) -> tuple[float, ...]:
    """Return red, green, blue and opacity of a geom, 0 to 1: its own, or its material's."""
    own, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    if material >= 0 and np.allclose(own, _DEFAULT_RGBA):
        own = model.mat_rgba[material]
    return tuple(float(part) for part in own)


def geom_mesh(model: mujoco.MjModel, geom: int) -> "trimesh.Trimesh":
    """Return the surface of a geom in its own frame [m].

    A plane becomes a thin box of its half sizes, 1 m where they are infinite.

    Raises
    ------
    InputError
        If it is of a kind that no model of this package has, such as a height field.
    """
    from trimesh import creation

    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    shape = mujoco.mjtGeom
    if kind == shape.mjGEOM_MESH.value:
        return _stored_mesh(model, int(model.geom_dataid[geom]))
    if kind in (shape.mjGEOM_SPHERE.value, shape.mjGEOM_ELLIPSOID.value):
        ball = creation.icosphere(subdivisions=3)
        ball.apply_scale(size if kind == shape.mjGEOM_ELLIPSOID.value else size[0])
        return ball
    if kind == shape.mjGEOM_CAPSULE.value:
        return creation.capsule(height=2 * size[1], radius=size[0])  # about its middle
    if kind == shape.mjGEOM_CYLINDER.value:
        return creation.cylinder(radius=size[0], height=2 * size[1])
    if kind == shape.mjGEOM_BOX.value:
        return creation.box(extents=2 * size)
    if kind == shape.mjGEOM_PLANE.value:
        sides = np.where(size[:2] > 0, size[:2], 1.0)
        return creation.box(extents=(*(2 * sides), 1e-4))
    raise InputError(f"geom {geom} is of a kind that has no mesh here; draw it with `render`")


def _stored_mesh(model: mujoco.MjModel, mesh: int) -> "trimesh.Trimesh":
    """Return a mesh of the model, in the frame that its geoms are placed by."""
    from trimesh import Trimesh

    first, n = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    first_face, n_faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    faces = model.mesh_face[first_face : first_face + n_faces]
    return Trimesh(model.mesh_vert[first : first + n], faces, process=True)

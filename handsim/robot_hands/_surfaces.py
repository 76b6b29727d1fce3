"""The surface of links as triangles, and where rays meet it."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Collection

import mujoco
import numpy as np

from handsim.types import Array

_SHAPES = mujoco.mjtGeom
_MOST_TRIANGLES = 40_000
"""Of one mesh; more are thinned out, which finds a surface all the same."""


def triangles_of(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    bodies: Collection[int],
    skipped: Collection[str] = (),
) -> Array:
    """Return the surface of bodies in the world, (n, 3, 3) [m]: triangles, corners, coordinates.

    What touches, if anything does; else what is seen.

    Parameters
    ----------
    model
    data
        With positions computed.
    bodies
    skipped
        Names of meshes that stand for missing ones.
    """
    own = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in bodies]
    touching = [g for g in own if model.geom_contype[g] or model.geom_conaffinity[g]]
    for geoms in (touching, own):
        parts = [_of_geom(model, data, g, skipped) for g in geoms]
        parts = [part for part in parts if len(part)]
        if parts:
            return np.concatenate(parts)
    return np.empty((0, 3, 3))


def _of_geom(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, skipped: Collection[str]
) -> Array:
    import trimesh.creation as make

    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == _SHAPES.mjGEOM_MESH.value:
        mesh = int(model.geom_dataid[geom])
        if model.mesh(mesh).name in skipped:
            return np.empty((0, 3, 3))
        first, n = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = model.mesh_face[first : first + n][:: max(1, n // _MOST_TRIANGLES)]
        local = model.mesh_vert[int(model.mesh_vertadr[mesh]) + faces].astype(float)
    elif kind == _SHAPES.mjGEOM_BOX.value:
        local = np.asarray(make.box(2 * size).triangles)
    elif kind in (_SHAPES.mjGEOM_SPHERE.value, _SHAPES.mjGEOM_ELLIPSOID.value):
        ball = np.asarray(make.icosphere(subdivisions=3).triangles)
        local = ball * (size if kind == _SHAPES.mjGEOM_ELLIPSOID.value else size[0])
    elif kind == _SHAPES.mjGEOM_CAPSULE.value:
        capsule = make.capsule(height=2 * size[1], radius=size[0], count=(24, 24))
        local = np.asarray(capsule.triangles)
        if len(local):  # trimesh has the origin at one end
            heights = local[..., 2]
            local = local - np.array([0.0, 0.0, (heights.min() + heights.max()) / 2])
    elif kind == _SHAPES.mjGEOM_CYLINDER.value:
        local = np.asarray(make.cylinder(radius=size[0], height=2 * size[1]).triangles)
    else:
        return np.empty((0, 3, 3))
    return local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]


def outermost(triangles: Array, origin: Array, direction: Array) -> float | None:
    """Return how far from a point along a ray the surface is met last, [m]; None if never.

    By Moeller and Trumbore (1997), for all triangles at once.

    Parameters
    ----------
    triangles : (n, 3, 3) [m]
    origin : (3,) [m]
    direction : (3,)
        Unit vector.
    """
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(direction, second)
    volume = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = origin - triangles[:, 0]
        u = np.einsum("ij,ij->i", apart, across) / volume
        turned = np.cross(apart, first)
        v = turned @ direction / volume
        far = np.einsum("ij,ij->i", second, turned) / volume
        met = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & np.isfinite(far)
    return float(far[met].max()) if met.any() else None

"""The meshes of the 13 objects, as ``assets/objects/make.py`` writes them."""

from functools import lru_cache

import numpy as np

from handsim.errors import FileError
from handsim.files import data_folder
from handsim.objects.object import Collider, Piece, TriangleMesh
from handsim.types import Array

_MIRROR = np.array([1.0, -1.0, 1.0])


@lru_cache(maxsize=64)
def surface_of(piece: Piece) -> TriangleMesh:
    """Return the surface of a piece, from its file where it has one."""
    mesh = read_mesh(piece.mesh) if isinstance(piece.mesh, str) else piece.mesh
    if not piece.mirrored:
        return mesh
    image = TriangleMesh(mesh.vertices * _MIRROR, mesh.faces[:, ::-1].copy())  # outside is outside
    image.vertices.flags.writeable = False
    image.faces.flags.writeable = False
    return image


def points_of(collider: Collider) -> Array:
    """Return the points of a hull, from its file where it has one, (n, 3) [m]."""
    if not collider.mesh:
        return np.array(collider.points)
    vertices = read_mesh(collider.mesh).vertices
    return vertices * _MIRROR if collider.mirrored else vertices


def read_mesh(name: str) -> TriangleMesh:
    """Read ``assets/objects/<name>.obj``: its ``v`` and ``f`` lines, triangles only.

    Raises
    ------
    FileError
        If the file is missing or is not what ``assets/objects/make.py`` writes.
    """
    path = data_folder("assets") / "objects" / f"{name}.obj"
    if not path.is_file():
        raise FileError(f"{path}: no such mesh; make it with python assets/objects/make.py")
    vertices, faces = [], []
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            mark, *values = line.split() or [""]
            if mark == "v":
                vertices.append([float(value) for value in values])
            elif mark == "f":
                faces.append([int(value) - 1 for value in values])
        mesh = TriangleMesh(
            np.array(vertices).reshape(-1, 3), np.array(faces, dtype=np.int32).reshape(-1, 3)
        )
    except ValueError as error:
        raise FileError(f"{path}: not a mesh of triangles ({error}); make it again") from error
    mesh.vertices.flags.writeable = False
    mesh.faces.flags.writeable = False
    return mesh

"""Objects from users' own mesh files.

A file is read as bytes that cannot refer to other files: no materials, no includes.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from handsim.errors import FileError, InputError, MissingToolError, quiet_logs
from handsim.objects._convex_pieces import decompose
from handsim.objects.object import Collider, GraspObject, Piece, TriangleMesh, hull

if TYPE_CHECKING:
    import trimesh

FORMATS = ("obj", "stl", "ply", "off")
"""Formats that hold one surface and name no other files."""

MAX_FILE_BYTES = 64 * 1024**2
SIZE_RANGE = (0.003, 1.0)
"""Longest side of an object that a hand can be asked to grasp [m]."""
MASS_RANGE = (1e-4, 20.0)
"""[kg]"""

MIN_FILL = 1e-6
"""Least volume of a solid, as a share of the cube over its longest side."""

CONVEX_FILL = 0.97
"""Share of its convex hull that a mesh fills to be taken for convex."""

MAX_HULL_POINTS = 128
"""Points of one convex piece; more make contact slower and no better."""


def object_from_mesh(
    path: Path | str,
    mass: float,
    *,
    scale: float = 1.0,
    name: str | None = None,
    colour: tuple[float, float, float, float] = (0.55, 0.60, 0.68, 1.0),
    seed: int = 0,
) -> GraspObject:
    """Make an object from a mesh file.

    The object stands on the table as the file has it, z up; the origin is put under the middle of
    its bounding box. Mass is spread evenly over the volume. A concave mesh is decomposed into
    convex pieces for contact, which needs ``coacd``.

    Parameters
    ----------
    path
        An ``.obj``, ``.stl``, ``.ply`` or ``.off`` file with one closed surface.
    mass
        [kg].
    scale
        Factor from the file's unit to metres: 0.001 for millimetres.
    name
        By default the file's name without suffix.
    colour
        Red, green, blue, opacity; 0 to 1.
    seed
        Of the decomposition.

    Raises
    ------
    FileError
        If the file is missing, of another format, damaged, too large or not watertight.
    InputError
        If mass or size cannot be right.
    MissingToolError
        If the mesh is concave and ``coacd`` is not installed.
    """
    path = Path(path)
    mesh = _read(path)
    low, high = MASS_RANGE
    if not low <= mass <= high:
        raise InputError(f"mass {mass:g} kg is outside {low:g} to {high:g} kg; give kilograms")
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"scale {scale:g} is not positive; 0.001 turns millimetres into metres")
    mesh.apply_scale(scale)
    longest = float(mesh.extents.max())
    if not SIZE_RANGE[0] <= longest <= SIZE_RANGE[1]:
        raise InputError(
            f"{path}: longest side is {longest:.3g} m, outside {SIZE_RANGE[0]:g} to"
            f" {SIZE_RANGE[1]:g} m; set the scale (0.001 if the file is in millimetres)"
        )
    (x0, y0, z0), (x1, y1, _) = mesh.bounds
    mesh.apply_translation([-(x0 + x1) / 2, -(y0 + y1) / 2, -z0])
    surface = TriangleMesh(
        np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int32)
    )
    return GraspObject(
        name=name or path.stem,
        front="as in the file",
        pieces=(Piece(surface, mass, colour),),
        colliders=_convex_pieces(mesh, path, seed),
        source=str(path),
    )


def _read(path: Path) -> "trimesh.Trimesh":
    import trimesh

    if not path.is_file():
        raise FileError(f"{path}: no such file; check the path")
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise FileError(f"{path}: format '{kind}' is not one of {', '.join(FORMATS)}; convert it")
    size = path.stat().st_size
    if size > MAX_FILE_BYTES:
        raise FileError(f"{path}: {size} bytes, more than {MAX_FILE_BYTES}; simplify the mesh")
    try:
        with path.open("rb") as stream, quiet_logs("trimesh"):
            mesh = trimesh.load_mesh(stream, file_type=kind, skip_materials=True)
            _check(mesh, path)
    except FileError:
        raise
    except Exception as error:  # every parser raises its own classes
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileError(f"{path}: not a readable mesh ({reason}); export it again") from error
    return mesh


def _check(mesh: "trimesh.Trimesh", path: Path) -> None:
    """Refuse what is not one solid, and turn it right side out."""
    if len(mesh.faces) == 0:
        raise FileError(f"{path}: holds no surface of triangles; export it again")
    if not np.isfinite(mesh.vertices).all():
        raise FileError(f"{path}: has vertices that are not finite numbers; export it again")
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        raise FileError(f"{path}: the mesh is not watertight; close its holes and export it again")
    volume = float(np.linalg.det(mesh.triangles).sum()) / 6  # of tetrahedra to the origin
    if abs(volume) < MIN_FILL * float(mesh.extents.max()) ** 3:
        raise FileError(f"{path}: the mesh encloses no volume; give it some thickness")
    if volume < 0:
        mesh.invert()


def _convex_pieces(mesh: "trimesh.Trimesh", path: Path, seed: int) -> tuple[Collider, ...]:
    if mesh.volume >= CONVEX_FILL * mesh.convex_hull.volume:
        return (_thinned(mesh.convex_hull.vertices),)
    try:
        pieces = decompose(mesh.vertices, mesh.faces, seed)
    except (InputError, MissingToolError) as error:
        raise type(error)(f"{path}: {error}") from error
    return tuple(hull(vertices) for vertices in pieces)


def _thinned(vertices: np.ndarray) -> Collider:
    """Return the hull of the vertices that lie outermost in evenly spread directions."""
    if len(vertices) <= MAX_HULL_POINTS:
        return hull(vertices)
    i = np.arange(MAX_HULL_POINTS) + 0.5
    z = 1 - 2 * i / len(i)
    turn = np.pi * (1 + 5**0.5) * i  # golden-angle spiral
    rim = np.sqrt(1 - z**2)
    directions = np.column_stack([rim * np.cos(turn), rim * np.sin(turn), z])
    return hull(vertices[np.unique((directions @ vertices.T).argmax(axis=1))])

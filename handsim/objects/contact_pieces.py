"""Convex pieces of users' objects, with which they touch: made here, or given ready."""

from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handsim.errors import FileError, InputError, MissingToolError
from handsim.objects._convex_pieces import decompose
from handsim.objects.meshes.mending import ClosedSurface, Solid
from handsim.objects.meshes.mesh_file import FORMATS, read_triangles
from handsim.objects.meshes.surface import signed_volume
from handsim.types import Array

CONVEX_FILL = 0.95
"""Share of its convex hull that a body fills to be taken for convex."""
MAX_HULL_POINTS = 128
"""Points of one convex piece; more make contact slower and no better."""
MAX_PIECES = 128
MISPLACED = 0.15
"""How far the box around ready pieces may differ from that of the mesh, as a share of its side."""


def contact_pieces(
    solid: Solid, path: Path, folder: Path | str | None, scale: float, seed: int
) -> list[Array]:
    """Return the corners of each convex piece, (n, 3) [m], in the axes of the file.

    Parameters
    ----------
    solid
        What the file holds, in its own unit.
    path
        The file, for messages.
    folder
        Of ready pieces; None decomposes what is concave.
    scale
        Metres in the file's unit.
    seed
        Of the decomposition.

    Raises
    ------
    FileError
        If ready pieces are missing, damaged or elsewhere, or pieces are too many.
    InputError, MissingToolError
        If a concave body cannot be decomposed.
    """
    if folder is not None:
        return _ready_pieces(solid, path, Path(folder), scale)
    clouds: list[Array] = []
    for body in solid.bodies:
        if not body.cavity:
            clouds += _convex_pieces(body, scale, path, seed)
    if len(clouds) > MAX_PIECES:
        raise FileError(
            f"{path}: {len(clouds)} convex pieces, more than {MAX_PIECES}; simplify the mesh"
        )
    return clouds


def _convex_pieces(body: ClosedSurface, scale: float, path: Path, seed: int) -> list[Array]:
    vertices = body.vertices * scale
    around = ConvexHull(vertices)
    if signed_volume(vertices, body.faces) >= CONVEX_FILL * around.volume:
        return [_thinned(vertices[around.vertices])]
    try:
        return [_thinned(each) for each in decompose(vertices, body.faces, seed)]
    except (InputError, MissingToolError) as error:
        raise type(error)(f"{path}: {error}") from error


def _ready_pieces(solid: Solid, path: Path, folder: Path, scale: float) -> list[Array]:
    """Read ready convex pieces and check that they lie where the mesh does."""
    if not folder.is_dir():
        raise FileError(f"{folder}: no such folder; --pieces names one of convex meshes")
    files = sorted(
        each
        for each in folder.iterdir()
        if each.suffix.lower().lstrip(".") in FORMATS and each.resolve() != path.resolve()
    )
    named = [each for each in files if each.stem.lower().startswith(("contact", "piece", "convex"))]
    files = named or files
    if not 0 < len(files) <= MAX_PIECES:
        raise FileError(
            f"{folder}: {len(files)} meshes in it beside the object's own; 1 to {MAX_PIECES} convex"
            " pieces are expected, best named contact0.stl, contact1.stl and so on"
        )
    clouds: list[Array] = []
    for each in files:
        triangles = read_triangles(each)
        corners = triangles.vertices[np.unique(triangles.faces)] * scale
        try:
            corners = corners[ConvexHull(corners).vertices]
        except QhullError as error:
            raise FileError(f"{each}: the piece is flat; give it some thickness") from error
        clouds.append(_thinned(corners))
    whole, parts = solid.surface[0] * scale, np.concatenate(clouds)
    side = np.ptp(whole, axis=0).max()
    off = max(
        np.abs(whole.min(axis=0) - parts.min(axis=0)).max(),
        np.abs(whole.max(axis=0) - parts.max(axis=0)).max(),
    )
    if off > MISPLACED * side:
        raise FileError(
            f"{folder}: the pieces end {1000 * off:.3g} mm from where the mesh ends, more than"
            f" {100 * MISPLACED:g} % of its longest side; give them in the frame and unit of {path}"
        )
    return clouds


def _thinned(vertices: Array) -> Array:
    """Return the vertices that lie outermost in evenly spread directions, where they are many."""
    if len(vertices) <= MAX_HULL_POINTS:
        return vertices
    i = np.arange(MAX_HULL_POINTS) + 0.5
    z = 1 - 2 * i / len(i)
    turn = np.pi * (1 + 5**0.5) * i  # golden-angle spiral
    rim = np.sqrt(1 - z**2)
    directions = np.column_stack([rim * np.cos(turn), rim * np.sin(turn), z])
    return vertices[np.unique((directions @ vertices.T).argmax(axis=1))]

"""Objects from users' own mesh files.

What can safely be mended is, and said (`meshes.mending`); the unit is guessed where none is given
(`meshes.units`); the object is set down on its most stable side, or as it is asked to be
(`meshes.resting`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import FileError, InputError
from handsim.objects.contact_pieces import contact_pieces
from handsim.objects.meshes.mending import mend
from handsim.objects.meshes.mesh_file import FORMATS, read_triangles
from handsim.objects.meshes.resting import RestingPose, Up, resting_poses, turn_up
from handsim.objects.meshes.surface import centroid, signed_volume
from handsim.objects.meshes.units import UNITS, guess_unit
from handsim.objects.object import GraspObject, Piece, TriangleMesh, Vec3, hull
from handsim.types import Array

__all__ = ["FORMATS", "OwnObject", "object_from_mesh", "read_object"]

SIZE_RANGE = (0.003, 1.0)
"""Longest side of an object that a hand can be asked to grasp [m]."""
MASS_RANGE = (1e-4, 20.0)
"""[kg]"""
DENSITY = 1000.0
"""Mass over volume where no mass is given [kg/m^3]: water's, and about that of plastics."""
SNAP = np.deg2rad(10.0)
"""How far from a way to rest the way up that is asked for may be, to be taken for it [rad]."""
GREY = (0.55, 0.60, 0.68, 1.0)


@dataclass(frozen=True)
class OwnObject:
    """An object from a file, and what was found out about it.

    Attributes
    ----------
    object
        Ready to be grasped, standing as its ``resting`` pose says.
    watertight
        Whether every edge of the file's own surface has two faces.
    mended, guessed
        What was done to it, and what was assumed: a phrase for each.
    scale
        Metres in the file's unit.
    size : (3,) [m]
        Of the box around it as it stands.
    volume
        Of the material [m^3].
    resting
        Ways to rest, the most stable first.
    up
        What points up now, in the axes of the file.
    """

    object: GraspObject
    watertight: bool
    mended: tuple[str, ...]
    guessed: tuple[str, ...]
    scale: float
    size: Vec3
    volume: float
    resting: tuple[RestingPose, ...]
    up: Vec3

    def standing(self, pose: RestingPose) -> GraspObject:
        """Return the object resting another way."""
        turn = turn_up(pose.up) * turn_up(self.up).inv()
        return _turned(self.object, turn)


def object_from_mesh(
    path: Path | str,
    mass: float,
    *,
    scale: float = 1.0,
    name: str | None = None,
    colour: tuple[float, float, float, float] = GREY,
    seed: int = 0,
    up: Up | None = "z",
    pieces: Path | str | None = None,
) -> GraspObject:
    """Make an object from a mesh file.

    The object stands on the table as the file has it, z up; the origin is put under the middle of
    its bounding box. Mass is spread evenly over the volume. A concave mesh is decomposed into
    convex pieces for contact, which needs ``coacd``.

    Parameters
    ----------
    path
        An ``.obj``, ``.stl``, ``.ply`` or ``.off`` file. Small faults are mended; `read_object`
        says how.
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
    up
        Axis of the file that points up; None sets it on its most stable side.
    pieces
        Folder of ready convex pieces, in the frame and unit of the mesh.

    Raises
    ------
    FileError
        If the file is missing, of another format, damaged, too large or cannot be mended.
    InputError
        If mass or size cannot be right.
    MissingToolError
        If the mesh is concave and ``coacd`` is not installed.
    """
    own = read_object(
        path, mass=mass, scale=scale, name=name, colour=colour, seed=seed, up=up, pieces=pieces
    )
    return own.object


def read_object(
    path: Path | str,
    *,
    mass: float | None = None,
    scale: float | None = None,
    up: Up | None = None,
    pieces: Path | str | None = None,
    name: str | None = None,
    colour: tuple[float, float, float, float] = GREY,
    seed: int = 0,
) -> OwnObject:
    """Read an object and say what was mended and guessed.

    Parameters
    ----------
    path, pieces, name, colour, seed
        As in `object_from_mesh`.
    mass
        [kg]; by default that of water of its volume.
    scale
        Factor from the file's unit to metres; by default guessed from the size.
    up
        Axis of the file that points up; by default it stands on its most stable side.

    Raises
    ------
    FileError, InputError, MissingToolError
        As in `object_from_mesh`.
    """
    path = Path(path)
    triangles = read_triangles(path)
    _check_given(mass, scale)
    try:
        solid = mend(triangles)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    vertices, faces = solid.surface
    guessed: list[str] = []
    if scale is None:
        scale = _guessed_scale(vertices, faces, mass, guessed)
    vertices = vertices * scale
    longest = float(np.ptp(vertices, axis=0).max())
    if not SIZE_RANGE[0] <= longest <= SIZE_RANGE[1]:
        raise InputError(
            f"{path}: longest side is {longest:.3g} m, outside {SIZE_RANGE[0]:g} to"
            f" {SIZE_RANGE[1]:g} m; set the scale (0.001 if the file is in millimetres)"
        )
    volume = signed_volume(vertices, faces)
    if mass is None:
        mass = float(np.clip(np.round(DENSITY * volume, 4), *MASS_RANGE))
        guessed.append(f"mass {mass:.3g} kg: {DENSITY:g} kg/m3 of {1e6 * volume:.3g} cm3")
    clouds = contact_pieces(solid, path, pieces, scale, seed)
    centre = centroid(vertices, faces)
    try:
        resting = resting_poses(np.concatenate(clouds), centre)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    way = _way_up(up, resting, path, guessed)
    made = GraspObject(
        name=name or path.stem,
        front="as in the file",
        pieces=(Piece(_triangle_mesh(vertices, faces), mass, colour),),
        colliders=tuple(hull(cloud) for cloud in clouds),
        source=str(path),
    )
    made = _turned(made, turn_up(way))
    surface = made.pieces[0].mesh
    assert isinstance(surface, TriangleMesh)
    width, depth, height = np.ptp(surface.vertices, axis=0).tolist()
    return OwnObject(
        made, solid.watertight, solid.mended, tuple(guessed), scale,
        (width, depth, height), volume, resting, way,
    )  # fmt: skip


def _check_given(mass: float | None, scale: float | None) -> None:
    low, high = MASS_RANGE
    if mass is not None and not low <= mass <= high:
        raise InputError(f"mass {mass:g} kg is outside {low:g} to {high:g} kg; give kilograms")
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise InputError(f"scale {scale:g} is not positive; 0.001 turns millimetres into metres")


def _guessed_scale(
    vertices: Array, faces: "np.ndarray", mass: float | None, guessed: list[str]
) -> float:
    longest = float(np.ptp(vertices, axis=0).max())
    guess = guess_unit(longest, signed_volume(vertices, faces), mass)
    metres = UNITS[guess.other][0]
    other = f", or {1000 * longest * metres:.3g} mm if it is in {guess.other}"
    doubt = f" (sure to {100 * guess.share:.0f} %{other})" if guess.share < 0.98 else ""
    guessed.append(
        f"unit {guess.name}: longest side {longest:.3g} in the file,"
        f" {1000 * longest * guess.scale:.3g} mm{doubt}; --scale sets it"
    )
    return guess.scale


def _way_up(up: Up | None, resting: Sequence[RestingPose], path: Path, guessed: list[str]) -> Vec3:
    """Return what is to point up, in the axes of the file."""
    if up is None:
        if resting:
            guessed.append(f"up {resting[0].name}: how it rests most steadily; --up sets another")
            return resting[0].up
        guessed.append("up +z: it rests on no side, and will roll")
        return (0.0, 0.0, 1.0)
    asked = np.eye(3)["xyz".index(up)]
    for pose in resting:
        off = float(np.arccos(np.clip(asked @ pose.up, -1.0, 1.0)))
        if off < np.deg2rad(0.2):
            break
        if off <= SNAP:
            guessed.append(f"turned by {np.rad2deg(off):.1f} deg to rest with {up} up")
            return pose.up
    else:
        guessed.append(f"with {up} up it rests on no side: it will tip over or roll")
    x, y, z = asked.tolist()
    return (x, y, z)


def _triangle_mesh(vertices: Array, faces: "np.ndarray") -> TriangleMesh:
    return TriangleMesh(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int32))


def _turned(made: GraspObject, turn: Rotation) -> GraspObject:
    """Return an object turned and set on the table, its origin under the middle of its box."""
    piece = made.pieces[0]
    assert isinstance(piece.mesh, TriangleMesh)
    vertices = _exactly(turn, piece.mesh.vertices)
    (x0, y0, z0), (x1, y1, _) = vertices.min(axis=0), vertices.max(axis=0)
    shift = np.array([-(x0 + x1) / 2, -(y0 + y1) / 2, -z0])
    surface = TriangleMesh(vertices + shift, piece.mesh.faces)
    colliders = tuple(
        hull(_exactly(turn, np.array(each.points)) + shift) for each in made.colliders
    )
    return replace(made, pieces=(replace(piece, mesh=surface),), colliders=colliders)


def _exactly(turn: Rotation, points: Array) -> Array:
    """Turn points; a turn of right angles is free of rounding."""
    matrix = turn.as_matrix()
    whole = np.round(matrix)
    return points @ (whole if np.abs(matrix - whole).max() < 1e-9 else matrix).T

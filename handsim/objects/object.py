"""What a graspable object is: visual meshes with mass, convex collision pieces, hinges.

Object frame: origin at the centre of the resting footprint, z up, the object's front along +x.
Every mesh, collision piece and hinge of an object is given in this one frame; hinged links turn
about their anchor.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from handsim.content import ByContent
from handsim.types import Array

Vec3 = tuple[float, float, float]
Kind = Literal["box", "cylinder", "capsule", "sphere", "hull"]

CLEARANCE = 0.0003
"""Height of a round base above the table on which its feet stand [m]."""


@dataclass(frozen=True)
class Collider:
    """One convex piece that takes part in contact and has no mass.

    Attributes
    ----------
    kind
        A MuJoCo primitive, or ``hull`` for the convex hull of ``points``.
    size
        Half sizes as MuJoCo counts them [m]; empty for a hull.
    pos, quat
        Pose in the object frame [m], (w, x, y, z).
    points
        The points of a hull, in the object frame [m].
    mesh
        Name of a mesh file whose vertices are the points of a hull instead.
    mirrored
        Whether that file is read as its mirror image across y = 0.
    """

    kind: Kind
    size: tuple[float, ...]
    pos: Vec3 = (0.0, 0.0, 0.0)
    quat: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    points: tuple[Vec3, ...] = ()
    mesh: str | None = None
    mirrored: bool = False


@dataclass(frozen=True, eq=False)
class TriangleMesh(ByContent):
    """A closed surface: vertices (n, 3) [m] and triangles (m, 3), counter-clockwise outside."""

    vertices: Array
    faces: npt.NDArray[np.int32]


@dataclass(frozen=True)
class Piece:
    """One visual mesh of uniform density; it carries mass and inertia.

    Attributes
    ----------
    mesh
        Name of the file in ``assets/objects`` without ``.obj``, or the surface itself.
    mass
        [kg]; a hollow shell with works inside is taken as uniformly dense.
    rgba
        Colour and opacity, 0 to 1.
    shine
        Specular reflection, 0 to 1.
    mirrored
        Whether the surface is the mirror image of ``mesh`` across y = 0.
    """

    mesh: str | TriangleMesh
    mass: float
    rgba: tuple[float, float, float, float]
    shine: float = 0.3
    mirrored: bool = False


@dataclass(frozen=True)
class Hinge:
    """The joint that carries a link: a hinge, or a screw when ``pitch`` is not 0.

    Attributes
    ----------
    name
        Joint name; the link's body has the same.
    axis, anchor
        Unit vector and point on it, in the object frame [m].
    range_deg
        Ends of travel [deg]; 0 is the pose in which the meshes are drawn.
    stiffness, rest_deg
        Return spring [N m/rad] and the angle at which it is slack [deg].
    damping, friction
        [N m s/rad], [N m].
    pitch
        Advance along the axis per turn [m].
    """

    name: str
    axis: Vec3
    anchor: Vec3
    range_deg: tuple[float, float]
    stiffness: float = 0.0
    rest_deg: float = 0.0
    damping: float = 1e-3
    friction: float = 0.0
    pitch: float = 0.0


@dataclass(frozen=True)
class Link:
    """A rigid part of an object that moves on a hinge."""

    hinge: Hinge
    pieces: tuple[Piece, ...]
    colliders: tuple[Collider, ...]


@dataclass(frozen=True)
class GraspObject:
    """An everyday object as it stands or lies on the table.

    Attributes
    ----------
    name
        As in Table I of the paper, lower case with hyphens.
    front
        What points along +x.
    pieces, colliders
        The main body's meshes and collision pieces.
    links
        Parts on hinges.
    symmetry
        Axis about which a turn cannot be seen, if any.
    source
        Where sizes and masses come from.
    handed
        Whether its left and right are not alike, so that a left hand takes its mirror image.
    """

    name: str
    front: str
    pieces: tuple[Piece, ...]
    colliders: tuple[Collider, ...]
    source: str
    links: tuple[Link, ...] = ()
    symmetry: Literal["x", "z"] | None = None
    handed: bool = False

    @property
    def mass(self) -> float:
        """Mass of all parts [kg]."""
        linked = (piece for link in self.links for piece in link.pieces)
        return sum(piece.mass for piece in (*self.pieces, *linked))


def box(sides: Vec3, centre: Vec3, turn_x: float = 0.0) -> Collider:
    """Return a box of full ``sides`` [m], turned about x by ``turn_x`` [rad]."""
    x, y, z = sides
    quat = (float(np.cos(turn_x / 2)), float(np.sin(turn_x / 2)), 0.0, 0.0)
    return Collider("box", (x / 2, y / 2, z / 2), centre, quat)


def drum(radius: float, bottom: float, top: float, n: int = 32) -> Collider:
    """Return an upright prism of ``n`` sides, round on average, between two heights [m].

    It stands in for a cylinder: MuJoCo's contact of a cylinder with a plane loses all digits when
    the cylinder stands upright to within rounding, and now and then reports millimetres of depth.
    """
    angles = (np.arange(n) + 0.5) * 2 * np.pi / n
    reach = radius * 2 / (1 + np.cos(np.pi / n))
    rim = np.column_stack([np.cos(angles), np.sin(angles)]) * reach
    return hull([(x, y, z) for z in (bottom, top) for x, y in rim])


def feet(radius: float, n: int = 6) -> tuple[Collider, ...]:
    """Return the points on which a round base stands, on a circle of ``radius`` [m].

    Balls of 1 mm radius; what they carry begins at `CLEARANCE` above the table.
    """
    angles = np.arange(n) * 2 * np.pi / n
    ball = 0.001
    return tuple(
        Collider("sphere", (ball,), (float(radius * x), float(radius * y), ball))
        for x, y in zip(np.cos(angles), np.sin(angles), strict=True)
    )


def rod(start: Vec3, end: Vec3, radius: float, kind: Kind = "capsule") -> Collider:
    """Return a capsule or cylinder between two points [m]."""
    a, b = np.array(start), np.array(end)
    along = (b - a) / np.linalg.norm(b - a)
    quat = _turn_z_onto(along)
    x, y, z = (a + b) / 2
    return Collider(
        kind, (radius, float(np.linalg.norm(b - a)) / 2), (float(x), float(y), float(z)), quat
    )


def hull(points: npt.ArrayLike) -> Collider:
    """Return the convex hull of points (n, 3) [m]."""
    rows = tuple((float(x), float(y), float(z)) for x, y, z in np.asarray(points))
    return Collider("hull", (), points=rows)


def hull_of(mesh: str) -> Collider:
    """Return the convex hull of a mesh file of ``assets/objects``."""
    return Collider("hull", (), mesh=mesh)


def prism_along_x(
    start: float, end: float, height: float, flat: float, corner: float | None = None
) -> Collider:
    """Return a six-sided prism about a line along x, one of its flats downwards.

    Parameters
    ----------
    start, end
        Along x [m].
    height
        Of its axis [m].
    flat, corner
        Distance of the flats and of the corners from the axis [m]; nearer corners are cut off.
    """
    sharp = flat / np.cos(np.pi / 6)
    reach = min(corner or sharp, sharp)
    tilt = np.arccos(flat / reach)  # from a flat's normal to either end of the flat
    around = [side + turn for side in np.arange(6) * np.pi / 3 for turn in (-tilt, tilt)]
    return hull(
        [
            (x, reach * np.sin(angle), height - reach * np.cos(angle))
            for x in (start, end)
            for angle in around
        ]
    )


def ring(
    inner: Sequence[float], outer: Sequence[float], heights: Sequence[float], n: int
) -> tuple[Collider, ...]:
    """Return the wall of a hollow vessel about z as ``n`` convex staves.

    Parameters
    ----------
    inner, outer
        Radii at the two ``heights`` [m]. The outer corners lie so far out that the facets' mean
        radius is the wall's.
    """
    half = np.pi / n
    swell = 2 / (1 + np.cos(half))
    staves = []
    for middle in 2 * half * np.arange(n):
        points = [
            (radius * swell * np.cos(angle), radius * swell * np.sin(angle), height)
            for radii in (inner, outer)
            for radius, height in zip(radii, heights, strict=True)
            for angle in (middle - half, middle + half)
        ]
        staves.append(hull(points))
    return tuple(staves)


def _turn_z_onto(direction: Array) -> tuple[float, float, float, float]:
    """Return the shortest turn of the z axis onto a unit vector, (w, x, y, z)."""
    x, y, z = direction
    if z < -1 + 1e-12:
        return (0.0, 1.0, 0.0, 0.0)
    quat = np.array([1 + z, -y, x, 0.0])
    w, i, j, k = quat / np.linalg.norm(quat)
    return (float(w), float(i), float(j), float(k))

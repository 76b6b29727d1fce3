"""Closed bodies of a file's triangles: what can safely be mended is, what cannot is refused.

Mended are vertices that do not quite meet, triangles given twice, triangles and whole bodies that
are turned inside out, and small holes. What is done is said. Nothing is guessed about large
openings or about surfaces that are no boundary of a solid.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import KDTree

from handsim.errors import InputError
from handsim.objects.meshes.mesh_file import Triangles
from handsim.objects.meshes.surface import (
    EdgeTable,
    area,
    boundary_loops,
    merged,
    patches,
    signed_volume,
    turned_alike,
    winding,
)
from handsim.types import Array, Index
from handsim.wording import number_of

EXACT, SEAM = 1e-7, 2e-4
"""Distances within which vertices are one at any rate, and where an edge is open; shares of the
longest side. Writers of files round to six digits or more."""
MAX_HOLE = 0.25
"""Widest hole that is closed, as a share of the longest side."""
FEW_CORNERS = 4
"""Holes of so many corners are closed however long: one or two triangles are missing, of which long
walls have as long ones, and there is next to nothing to guess."""
MAX_PATCHED = 0.05
"""Most of the surface that may be added to close holes, as a share."""
MIN_FILL = 1e-6
"""Least volume of a solid, as a share of the cube over its longest side."""
SPECK = 1e-5
"""Volume of a body that is left out, as a share of the largest one's."""
MAX_BODIES = 64
"""More are a scene and no thing."""


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """One closed surface, triangles counter-clockwise seen from outside the material.

    Attributes
    ----------
    vertices : (n, 3), faces : (m, 3)
    cavity
        Whether it bounds a hollow inside another one.
    """

    vertices: Array
    faces: Index
    cavity: bool = False


@dataclass(frozen=True, eq=False)
class Solid:
    """What a file holds once it is mended.

    Attributes
    ----------
    bodies
        Closed surfaces, cavities among them.
    watertight
        Whether every edge of the file's own surface has two faces.
    mended
        What was done, a phrase for each.
    """

    bodies: tuple[ClosedSurface, ...]
    watertight: bool
    mended: tuple[str, ...]

    @property
    def surface(self) -> tuple[Array, Index]:
        """All bodies as one surface: vertices (n, 3) and faces (m, 3)."""
        starts = np.cumsum([0, *(len(each.vertices) for each in self.bodies)])
        return (
            np.concatenate([each.vertices for each in self.bodies]),
            np.concatenate(
                [each.faces + start for each, start in zip(self.bodies, starts, strict=False)]
            ),
        )


def mend(triangles: Triangles) -> Solid:
    """Return the closed bodies of a surface.

    Raises
    ------
    InputError
        If it cannot be closed, or encloses nothing; the message names the cause and the remedy,
        and not the file.
    """
    size = triangles.longest_side
    if size <= 0:
        raise InputError("all its vertices are in one place; export it again")
    done: list[str] = []
    vertices, faces, watertight = _joined(triangles, size, done)
    faces = _once(faces, done)
    if len(faces) < 4:
        raise InputError("the mesh encloses no volume; give it some thickness")
    patch = patches(faces)
    faces, n_turned, one_sided = turned_alike(faces, patch)
    edges = EdgeTable.of(faces, patch)
    if one_sided.any():
        raise InputError(
            "the surface has one side only, like a Moebius strip: it has no inside; model it as a"
            " closed solid"
        )
    if n_turned:
        done.append(f"{number_of(n_turned, 'triangle')} turned the way round of their neighbours")
    if edges.count.max() > 2:
        raise InputError(
            f"more than two triangles meet at {number_of(int((edges.count > 2).sum()), 'edge')}: "
            "the surface touches or crosses itself; make it one solid (boolean union) and export it"
            " again"
        )
    faces, patch, vertices = _closed(vertices, faces, patch, size, done)
    bodies = _nested(_bodies(vertices, faces, patch, size, done), size, done)
    return Solid(tuple(bodies), watertight, tuple(done))


def _joined(triangles: Triangles, size: float, done: list[str]) -> tuple[Array, Index, bool]:
    """Return the surface with vertices merged, farther apart ones where it is open.

    The third is whether every edge has two faces as it is given.
    """
    vertices, faces = merged(triangles.vertices, triangles.faces, EXACT * size)
    faces = _with_area(faces)
    if len(faces) == 0:
        raise InputError("the mesh encloses no volume; give it some thickness")
    edges = EdgeTable.of(faces)
    watertight, n_open = bool((edges.count == 2).all()), int(edges.open.sum())
    if n_open == 0:
        return vertices, faces, watertight
    wider, joined = merged(vertices, faces, SEAM * size)
    joined = _with_area(joined)
    n_left = int(EdgeTable.of(joined).open.sum()) if len(joined) else n_open
    if n_left >= n_open:
        return vertices, faces, watertight
    done.append(f"seams closed: {number_of(n_open - n_left, 'edge')} whose ends did not quite meet")
    return wider, joined, False


def _with_area(faces: Index) -> Index:
    """Return the triangles with three different corners."""
    a, b, c = faces.T
    return faces[(a != b) & (b != c) & (c != a)]


def _once(faces: Index, done: list[str]) -> Index:
    """Return each triangle once; a flap whose two sides are both given goes altogether."""
    _, first, group, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    if count.max() == 1:
        return faces
    n_more = len(faces) - len(first)
    if n_more > len(faces) / 4:
        done.append(f"double shell: {number_of(n_more, 'triangle')} given twice, taken once")
        return faces[np.sort(first)]
    done.append(f"{number_of(n_more, 'triangle')} given more than once, a flap without thickness")
    return faces[(count[group.ravel()] % 2) == 1]


def _closed(
    vertices: Array, faces: Index, patch: Index, size: float, done: list[str]
) -> tuple[Index, Index, Array]:
    """Return the surface with its small holes closed, each by a fan about its middle."""
    if not EdgeTable.of(faces, patch).open.any():
        return faces, patch, vertices
    whole = area(vertices, faces)
    added, owner, middles, widest, guessed = [faces], [patch], [vertices], 0.0, 0.0
    n_holes, n, patched = 0, len(vertices), 0.0
    for number in np.unique(patch[np.nonzero(EdgeTable.of(faces, patch).open)[0] // 3]).tolist():
        for loop in boundary_loops(faces[patch == number]):
            n_holes += 1
            fan, middle = _fan(vertices, loop, n)
            points = vertices[loop]
            spokes = np.linalg.norm(points - points.mean(axis=0), axis=1)
            width = 2 * float(spokes.max())
            widest, guessed = max(widest, width), max(guessed, width * (len(loop) > FEW_CORNERS))
            added.append(fan)
            owner.append(np.full(len(fan), number))
            if len(middle):
                middles.append(middle)
                n += 1
            patched += _fan_area(points)
    if guessed > MAX_HOLE * size or patched > MAX_PATCHED * whole:
        raise InputError(
            f"the mesh is not watertight: {number_of(n_holes, 'hole')}, the widest"
            f" {100 * widest / size:.0f} % of the longest side across, and"
            f" {100 * patched / whole:.0f} % of the surface in all; up to {100 * MAX_HOLE:g} % and"
            f" {100 * MAX_PATCHED:g} % are closed here, larger ones may be meant: close them, or"
            " give a bare surface some thickness, and export it again"
        )
    wide = f"the widest {100 * guessed / size:.1f} % of the longest side across"
    done.append(
        f"{number_of(n_holes, 'small hole')} closed, {wide if guessed else 'of a triangle or two'}"
    )
    return np.concatenate(added), np.concatenate(owner), np.vstack(middles)


def _fan(vertices: Array, loop: list[int], n: int) -> tuple[Index, Array]:
    """Return triangles that close a loop, and the vertex ``n`` that they need, if any."""
    back = loop[::-1]  # neighbours run along an edge in opposite ways
    if len(back) < 3:
        return np.empty((0, 3), dtype=np.int64), np.empty((0, 3))
    if len(back) == 3:
        return np.array([back], dtype=np.int64), np.empty((0, 3))
    following = [*back[1:], back[0]]
    fan = np.array([[n, a, b] for a, b in zip(back, following, strict=True)], dtype=np.int64)
    return fan, vertices[loop].mean(axis=0, keepdims=True)


def _fan_area(points: Array) -> float:
    """Return the area of a fan about the middle of a loop (n, 3)."""
    spokes = points - points.mean(axis=0)
    return float(np.linalg.norm(np.cross(spokes, np.roll(spokes, -1, axis=0)), axis=1).sum() / 2)


def _bodies(
    vertices: Array, faces: Index, patch: Index, size: float, done: list[str]
) -> list[ClosedSurface]:
    """Return the bodies that enclose something, all right side out, the largest first."""
    order = np.argsort(patch, kind="stable")
    bounds = np.searchsorted(patch[order], np.arange(int(patch.max()) + 2))
    parts = [faces[order[a:b]] for a, b in pairwise(bounds)]
    volumes = np.array([signed_volume(vertices, part) for part in parts])
    largest = np.abs(volumes).max()
    if largest < MIN_FILL * size**3:
        raise InputError("the mesh encloses no volume; give it some thickness")
    kept = [i for i in np.argsort(-np.abs(volumes)) if abs(volumes[i]) >= SPECK * largest]
    if len(kept) < len(parts):
        done.append(f"{number_of(len(parts) - len(kept), 'speck')} left out")
    if len(kept) > MAX_BODIES:
        raise InputError(
            f"{len(kept)} separate bodies, more than {MAX_BODIES}: a scene rather than a thing;"
            " export one thing"
        )
    bodies: list[ClosedSurface] = []
    for i in kept:
        used, numbers = np.unique(parts[i], return_inverse=True)
        own = numbers.reshape(-1, 3)
        inward = bool(volumes[i] < 0)
        bodies.append(ClosedSurface(vertices[used], own[:, ::-1] if inward else own, inward))
    return bodies


def _nested(bodies: list[ClosedSurface], size: float, done: list[str]) -> list[ClosedSurface]:
    """Tell bodies from hollows by what lies inside what; ``cavity`` comes in as turned inward."""
    found: list[ClosedSurface] = []
    n_solid = n_turned = 0
    for i, body in enumerate(bodies):
        around = [other for j, other in enumerate(bodies) if j != i and _inside(body, other)]
        hollow = len(around) % 2 == 1
        if hollow:
            apart = min(KDTree(each.vertices).query(body.vertices)[0].min() for each in around)
            turned = "" if body.cavity else ", and turned inward"
            done.append(
                f"double shell: a surface inside another, {100 * apart / size:.1f} % of the longest"
                f" side apart, taken as a hollow{turned}"
            )
        else:
            n_solid += 1
            n_turned += body.cavity
        faces = body.faces[:, ::-1] if hollow else body.faces
        found.append(ClosedSurface(body.vertices, faces, hollow))
    if n_turned:
        which = (
            "turned right side out" if n_solid == 1 else f"{n_turned} of {n_solid} bodies turned"
        )
        done.append(f"inside out: {which}")
    if n_solid > 1:
        done.append(f"{n_solid} bodies taken as one rigid thing")
    return found


def _inside(body: ClosedSurface, other: ClosedSurface) -> bool:
    """Return whether a body lies inside another, by three of its vertices."""
    low, high = other.vertices.min(axis=0), other.vertices.max(axis=0)
    if (body.vertices < low).any() or (body.vertices > high).any():
        return False
    some = body.vertices[np.linspace(0, len(body.vertices) - 1, 3).astype(int)]
    return all(winding(other.vertices, other.faces, point) > 0.5 for point in some)

"""Make the watertight meshes of the 13 objects: ``python -m handsim.hand.object_meshes DIR``.

Solids are built with manifold3d (whose results are closed by construction), checked with trimesh
and written as Wavefront OBJ with coordinates rounded to 1 micrometre and a canonical order of
vertices and faces, so that the same code gives the same bytes.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from manifold3d import CrossSection, Manifold

from handsim.errors import InputError
from handsim.files import write_text
from handsim.hand.grasp_object import Array

SEGMENTS = 64
"""Facets of a round surface: 0.04 mm off a circle of 32 mm radius."""


def lathe(profile: Sequence[tuple[float, float]], segments: int = SEGMENTS) -> Manifold:
    """Revolve a closed outline of (radius, height) [m] about the z axis."""
    return _outline(profile).revolve(segments)


def rounded_box(sides: Sequence[float], centre: Sequence[float], radius: float) -> Manifold:
    """Return a box of full ``sides`` [m] with edges rounded by ``radius``."""
    ball = Manifold.sphere(radius, 16)
    half = np.array(sides) / 2 - radius
    corners = [ball.translate(half * (x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return Manifold.batch_hull(corners).translate(centre)


def _outline(points: Sequence[tuple[float, float]]) -> CrossSection:
    return CrossSection([np.array(points, dtype=float)])


def tall_glass() -> dict[str, Manifold]:
    """Straight glass with a thick base and a rounded rim."""
    rim = [
        (0.0309 + 0.0011 * np.cos(a), 0.1439 + 0.0011 * np.sin(a)) for a in np.linspace(0, np.pi, 9)
    ]
    profile = [
        (0, 0),
        (0.030, 0),
        (0.032, 0.003),
        *rim,
        (0.0298, 0.013),
        (0.027, 0.010),
        (0, 0.010),
    ]
    return {"tall_glass": lathe(profile)}


def cube() -> dict[str, Manifold]:
    """Wooden cube with 2 mm edges."""
    return {"cube": rounded_box((0.055,) * 3, (0, 0, 0.0275), 0.002)}


def jar() -> dict[str, Manifold]:
    """Jar with a shoulder and neck, its contents, and the lid."""
    outside = [(0, 0), (0.033, 0), (0.036, 0.004), (0.036, 0.076), (0.0345, 0.082), (0.0315, 0.085)]
    inside = [(0.029, 0.101), (0.029, 0.084), (0.033, 0.078), (0.033, 0.008), (0.030, 0.005)]
    glass = [*outside, (0.0315, 0.101), *inside, (0, 0.005)]
    coffee = [(0, 0.0052), (0.0298, 0.0052), (0.0328, 0.0082), (0.0328, 0.068), (0, 0.070)]
    lid = [(0, 0.1012), (0.0318, 0.1012), (0.0318, 0.088), (0.0345, 0.088), (0.0345, 0.102)]
    lid += [(0.0325, 0.104), (0.028, 0.104), (0.0275, 0.1034), (0, 0.1034)]
    return {"jar_glass": lathe(glass), "jar_coffee": lathe(coffee), "jar_lid": lathe(lid)}


MAKERS: tuple[Callable[[], dict[str, Manifold]], ...] = (tall_glass, cube, jar)


def surface(solid: Manifold) -> tuple[Array, Array]:
    """Return vertices rounded to 1 micrometre and triangles, both in canonical order."""
    mesh = solid.to_mesh64()
    points = np.round(np.asarray(mesh.vert_properties)[:, :3], 6) + 0.0
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    faces = index.ravel()[np.asarray(mesh.tri_verts, dtype=int)]
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    faces = faces[distinct]
    first = faces.argmin(axis=1)
    faces = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices, faces[np.lexsort(faces.T[::-1])]


def obj_text(name: str, vertices: Array, faces: Array) -> str:
    """Return a closed surface as a Wavefront OBJ file.

    Raises
    ------
    InputError
        If the surface is not watertight or not outward oriented.
    """
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if not (mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0):
        raise InputError(f"mesh '{name}' is not watertight; close its holes")
    rows = [f"# {name}, metres, z up"]
    rows += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in vertices]
    rows += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(rows) + "\n"


def all_meshes() -> dict[str, str]:
    """Return the text of every mesh file by its name without suffix."""
    solids = {name: solid for maker in MAKERS for name, solid in maker().items()}
    return {name: obj_text(name, *surface(solid)) for name, solid in solids.items()}


def main() -> None:
    """Write all meshes into the folder named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in all_meshes().items():
        write_text(folder / f"{name}.obj", text)


if __name__ == "__main__":
    main()

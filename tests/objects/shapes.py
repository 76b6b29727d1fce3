"""Surfaces that users bring, made up: whole and damaged."""

from pathlib import Path

import numpy as np
import trimesh

from handsim.objects.meshes.mesh_file import Triangles


def box(x: float = 0.04, y: float = 0.05, z: float = 0.06, at: tuple = (0, 0, 0)) -> Triangles:
    """A box about ``at``, every side two triangles."""
    return of(trimesh.creation.box((x, y, z)).apply_translation(at))


def of(mesh: trimesh.Trimesh) -> Triangles:
    return Triangles(np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=np.int64))


def ball(radius: float = 0.03, n: int = 3) -> Triangles:
    return of(trimesh.creation.icosphere(n, radius))


def together(*parts: Triangles) -> Triangles:
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return Triangles(
        np.vstack([part.vertices for part in parts]),
        np.vstack([part.faces + start for part, start in zip(parts, starts, strict=False)]),
    )


def turned(part: Triangles, rows: slice = slice(None)) -> Triangles:
    """Some triangles the other way round."""
    faces = part.faces.copy()
    faces[rows] = faces[rows][:, ::-1]
    return Triangles(part.vertices, faces)


def without(part: Triangles, *rows: int) -> Triangles:
    return Triangles(part.vertices, np.delete(part.faces, rows, axis=0))


def soup(part: Triangles) -> Triangles:
    """Every triangle with corners of its own, as in a file of STL."""
    return Triangles(
        part.vertices[part.faces].reshape(-1, 3), np.arange(3 * len(part.faces)).reshape(-1, 3)
    )


def moebius(n: int = 40) -> Triangles:
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rows = []
    for side in (-0.01, 0.01):
        reach = 0.05 + side * np.cos(angle / 2)
        rows.append(
            np.column_stack(
                [reach * np.cos(angle), reach * np.sin(angle), side * np.sin(angle / 2)]
            )
        )
    vertices = np.stack(rows, axis=1).reshape(-1, 3)
    faces = []
    for i in range(n):
        a, b = 2 * i, 2 * i + 1
        c, d = (a + 2, b + 2) if i < n - 1 else (1, 0)
        faces += [[a, c, b], [b, c, d]]
    return Triangles(vertices, np.array(faces))


def saved(part: Triangles, path: Path) -> Path:
    trimesh.Trimesh(part.vertices, part.faces, process=False).export(path)
    return path

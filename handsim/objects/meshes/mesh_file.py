"""Triangles of a mesh file.

A file is read as bytes that cannot refer to other files: no materials, no includes, no buffers.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handsim.errors import FileError, quiet_logs
from handsim.types import Array, Index

FORMATS = ("obj", "stl", "ply", "off")
"""Formats that hold surfaces and name no other files."""
MAX_FILE_BYTES = 64 * 1024**2
MAX_FACES = 1_000_000
MAX_COORDINATE = 1e6
"""Greatest coordinate in the file's unit: a metre in micrometres."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """A surface as a file has it: vertices (n, 3) in its own unit, and faces (m, 3)."""

    vertices: Array
    faces: Index

    @property
    def longest_side(self) -> float:
        """Of the bounding box, in the file's unit."""
        return float(np.ptp(self.vertices[np.unique(self.faces)], axis=0).max())


def read_triangles(path: Path) -> Triangles:
    """Read a mesh file.

    Raises
    ------
    FileError
        If the file is missing, of another format, damaged or too large.
    """
    if not path.is_file():
        raise FileError(f"{path}: no such file; check the path")
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise FileError(f"{path}: format '{kind}' is not one of {', '.join(FORMATS)}; convert it")
    size = path.stat().st_size
    if size > MAX_FILE_BYTES:
        raise FileError(f"{path}: {size} bytes, more than {MAX_FILE_BYTES}; simplify the mesh")
    try:
        vertices, faces = _loaded(path, kind)
    except Exception as error:  # every parser raises its own classes
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FileError(f"{path}: not a readable mesh ({reason[:120]}); export it again") from error
    if len(faces) == 0:
        raise FileError(f"{path}: holds no surface of triangles; export it again")
    if len(faces) > MAX_FACES:
        raise FileError(f"{path}: {len(faces)} triangles, more than {MAX_FACES}; simplify the mesh")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FileError(
            f"{path}: a triangle names vertex {faces.max()} of {len(vertices)}; export it again"
        )
    used = vertices[np.unique(faces)]
    if not np.isfinite(used).all():
        raise FileError(f"{path}: has vertices that are not finite numbers; export it again")
    if np.abs(used).max() > MAX_COORDINATE:
        raise FileError(
            f"{path}: a coordinate of {np.abs(used).max():.3g} is beyond {MAX_COORDINATE:g};"
            " export it near its origin"
        )
    return Triangles(np.nan_to_num(vertices), faces)


def _loaded(path: Path, kind: str) -> tuple[Array, Index]:
    import trimesh

    with path.open("rb") as stream, quiet_logs("trimesh"), np.errstate(all="ignore"):
        mesh: Any = trimesh.load_mesh(stream, file_type=kind, skip_materials=True, process=False)
        vertices = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
        return vertices, np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)

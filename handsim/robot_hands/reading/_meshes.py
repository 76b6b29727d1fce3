"""Meshes of any format as MuJoCo reads them, and a speck in place of those that it cannot read."""

import io

import numpy as np

from handsim.errors import quiet_logs

PLACEHOLDER = (
    b"v 0 0 0\nv 0.002 0 0\nv 0 0.002 0\nv 0 0 0.002\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
)
"""A tetrahedron of 2 mm: drawn in place of a mesh that is missing, so that all names remain."""
_READ_BY_TRIMESH = ("stl", "obj", "ply", "off", "glb", "dae", "3mf")
_STL_FACES = 200_000
"""Most faces of an STL file that MuJoCo reads."""
_MOST_FACES = 2_000_000


def as_readable(content: bytes, suffix: str, convert: bool = False) -> tuple[bytes, str] | None:
    """Return a mesh's content and suffix as MuJoCo reads them, or None.

    Parameters
    ----------
    content
    suffix
        Of the file, without the dot.
    convert
        Write it anew in any case.
    """
    kind = suffix.lower()
    if not convert and (kind == "msh" or (kind == "obj" and content.strip())):
        return content, kind
    if not convert and kind == "stl" and _is_binary_stl(content):
        return content, kind
    return _converted(content, kind)


def _is_binary_stl(content: bytes) -> bool:
    if len(content) < 84:
        return False
    faces = int.from_bytes(content[80:84], "little")
    return 1 <= faces <= _STL_FACES and len(content) == 84 + 50 * faces


def _converted(content: bytes, kind: str) -> tuple[bytes, str] | None:
    """Return a mesh as a text of vertices and triangles; None where nothing is readable."""
    import trimesh

    if kind not in _READ_BY_TRIMESH:
        return None
    try:
        with quiet_logs("trimesh"), np.errstate(all="ignore"):
            loaded = trimesh.load(io.BytesIO(content), file_type=kind, force="mesh", process=False)
        vertices = np.asarray(getattr(loaded, "vertices", ()), dtype=float)
        faces = np.asarray(getattr(loaded, "faces", ()), dtype=int)
    except Exception:  # whatever a parser of foreign formats says of a damaged file
        return None
    if not 1 <= len(faces) <= _MOST_FACES or not np.isfinite(vertices).all():
        return None
    if np.abs(vertices).max() > 1e6 or faces.min() < 0 or faces.max() >= len(vertices):
        return None
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return ("\n".join(lines) + "\n").encode(), "obj"

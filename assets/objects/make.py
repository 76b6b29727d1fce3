"""Write the meshes of the 13 objects: ``python assets/objects/make.py [DIR]``.

Files are Wavefront OBJ with coordinates in metres rounded to 1 micrometre and a canonical order
of vertices and faces. The same code gives the same surfaces within 2 micrometres on every machine,
and on one machine the same bytes.
"""

import argparse
from pathlib import Path

from solids import MAKERS, surface

from handsim.errors import InputError
from handsim.files import write_text
from handsim.objects.object import TriangleMesh


def obj_text(name: str, mesh: TriangleMesh) -> str:
    """Return a closed surface as a Wavefront OBJ file.

    Raises
    ------
    InputError
        If the surface is not watertight or not outward oriented.
    """
    import trimesh

    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    if not (solid.is_watertight and solid.is_winding_consistent and solid.volume > 0):
        raise InputError(f"mesh '{name}' is not watertight; close its holes")
    rows = [f"# {name}, metres, z up"]
    rows += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in mesh.vertices]
    rows += [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    return "\n".join(rows) + "\n"


def all_meshes() -> dict[str, str]:
    """Return the text of every mesh file by its name without suffix."""
    solids = {name: solid for maker in MAKERS for name, solid in maker().items()}
    return {name: obj_text(name, surface(solid)) for name, solid in solids.items()}


def main() -> None:
    """Write all meshes into the folder named on the command line, or beside this file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path(__file__).parent)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in all_meshes().items():
        write_text(folder / f"{name}.obj", text)


if __name__ == "__main__":
    main()

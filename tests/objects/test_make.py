"""The committed meshes are the surfaces that the code makes, and files hold closed surfaces only.

Surfaces are compared by geometry: which way a flat polygon is cut into triangles, and how a sixth
decimal is rounded, hangs on the last bit and so on the processor.
"""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.objects.mjcf import read_mesh
from handsim.objects.object import TriangleMesh

FOLDER = data_folder("assets") / "objects"
TOLERANCE = 2e-6
"""Of a vertex and of the surface [m]: every coordinate in a file is rounded to 1e-6."""


def solid_of(text: str) -> trimesh.Trimesh:
    """The surface in the text of a file."""
    rows = [line.split() for line in text.splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], dtype=float)
    faces = np.array([row[1:] for row in rows if row[0] == "f"], dtype=int) - 1
    return trimesh.Trimesh(vertices, faces, process=False)


def differences(made: trimesh.Trimesh, kept: trimesh.Trimesh) -> list[str]:
    """What tells two closed surfaces apart, worst first; nothing where they are one."""
    for name, solid in (("made", made), ("kept", kept)):
        if not (solid.is_watertight and solid.is_winding_consistent):
            return [f"{name}: not watertight"]
    far = max(
        KDTree(a.vertices).query(b.vertices)[0].max() for a, b in ((made, kept), (kept, made))
    )
    if far > TOLERANCE:
        return [f"a vertex is {1e6 * far:.1f} um off"]
    found = []
    apart = max(distance(made, kept), distance(kept, made))
    if apart > TOLERANCE:
        found.append(f"surfaces are {1e6 * apart:.1f} um apart")
    volume = abs(made.volume - kept.volume)
    if volume > TOLERANCE * kept.area:
        found.append(f"volumes differ by {1e9 * volume:.1f} mm3")
    return found


def distance(one: trimesh.Trimesh, other: trimesh.Trimesh) -> float:
    """Greatest distance of a point on one surface from the other [m], where triangles differ.

    Points are the centres of triangles and of their sides.
    """
    number = KDTree(other.vertices).query(one.vertices)[1]
    corners = alone(number[one.faces], other.faces, one.triangles)
    rest = alone(other.faces, number[one.faces], other.triangles)
    sides = [(corners[:, i] + corners[:, i - 1]) / 2 for i in range(3)]
    points = np.concatenate([corners.mean(axis=1), *sides])
    if not len(points):
        return 0.0
    each = np.repeat(points, len(rest), axis=0)  # every point against every triangle
    near = trimesh.triangles.closest_point(np.tile(rest, (len(points), 1, 1)), each)
    away = np.linalg.norm(near - each, axis=1).reshape(len(points), len(rest))
    return float(away.min(axis=1, initial=np.inf).max())


def alone(faces: np.ndarray, others: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Corners (n, 3, 3) of the faces that are not among the others, which way round or not."""
    shared = {frozenset(face) for face in others.tolist()}
    return corners[[frozenset(face) not in shared for face in faces.tolist()]]


@pytest.fixture(scope="module")
def make(script):
    return script("assets/objects/make.py")


@pytest.fixture(scope="module")
def made(make) -> dict[str, trimesh.Trimesh]:
    pytest.importorskip("manifold3d", reason="object meshes are made with manifold3d")
    return {name: solid_of(text) for name, text in make.all_meshes().items()}


def kept(name: str) -> trimesh.Trimesh:
    return solid_of((FOLDER / f"{name}.obj").read_text(encoding="utf-8"))


def test_every_mesh_made_is_committed_and_no_other(made) -> None:
    assert {path.stem for path in FOLDER.glob("*.obj")} == set(made)


def test_committed_meshes_are_what_the_code_makes(made) -> None:
    found = {name: differences(solid, kept(name)) for name, solid in made.items()}
    assert {name: each for name, each in found.items() if each} == {}


CUP = """
import hashlib
from make import obj_text
from solids import cup, surface
print(hashlib.sha256(obj_text("cup", surface(cup()["cup"])).encode()).hexdigest())
"""


@pytest.mark.parametrize("kernel", ["Haswell", "SkylakeX"])
def test_the_cup_is_the_same_with_any_kernel_of_the_linear_algebra(make, made, kernel: str) -> None:
    """The path of its handle solves a linear system; pieces of the handle meet in flat polygons."""
    environment = os.environ | {"OPENBLAS_CORETYPE": kernel}
    done = subprocess.run(
        [sys.executable, "-c", CUP],
        cwd=FOLDER,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode < 0:
        pytest.skip(f"this processor has no instructions for the kernel {kernel}")
    mesh = TriangleMesh(made["cup"].vertices, made["cup"].faces)
    own = hashlib.sha256(make.obj_text("cup", mesh).encode()).hexdigest()
    assert done.stdout.strip() == own, done.stderr


def test_a_flat_polygon_cut_otherwise_is_the_same_surface() -> None:
    """A cube's side has two diagonals."""
    box = trimesh.creation.box((0.05, 0.05, 0.05))
    other = box.copy()
    other.faces = mirrored(box)
    assert {frozenset(face) for face in other.faces.tolist()} != {
        frozenset(face) for face in box.faces.tolist()
    }
    assert differences(box, other) == []


def mirrored(box: trimesh.Trimesh) -> np.ndarray:
    """Faces of a centred box whose diagonals run the other way."""
    opposite = KDTree(box.vertices).query(box.vertices * [-1, 1, 1])[1]
    return opposite[box.faces][:, ::-1]


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda solid: solid.vertices.__setitem__((7, 2), solid.vertices[7, 2] + 3e-6), "vertex"),
        (lambda solid: setattr(solid, "faces", solid.faces[1:]), "watertight"),
        (lambda solid: setattr(solid, "faces", solid.faces[:, ::-1]), "volumes"),
        (lambda solid: solid.apply_translation([0, 0, 5e-6]), "vertex"),
    ],
)
def test_what_is_another_surface_is_told(change, word: str) -> None:
    solid = kept("cube")
    change(solid)
    assert [word in each for each in differences(solid, kept("cube"))] == [True]


def test_a_bent_polygon_cut_otherwise_is_another_surface() -> None:
    """With a corner lifted the two diagonals of a side run at different heights."""
    box = trimesh.creation.box((0.05, 0.05, 0.05))
    other = box.copy()
    other.faces = mirrored(box)
    for solid in (box, other):
        solid.vertices[np.argmax(solid.vertices.sum(axis=1))] += [0, 0, 1e-4]
    assert any("surfaces" in each for each in differences(box, other))


def test_a_mesh_with_a_hole_is_refused_by_name(make) -> None:
    mesh = read_mesh("cube")
    with pytest.raises(InputError, match="'holey' is not watertight"):
        make.obj_text("holey", TriangleMesh(mesh.vertices, mesh.faces[1:]))
    inside_out = TriangleMesh(mesh.vertices, mesh.faces[:, ::-1])
    with pytest.raises(InputError, match="'inverted' is not watertight"):
        make.obj_text("inverted", inside_out)


def test_a_file_is_read_as_it_was_written(make) -> None:
    mesh = read_mesh("cup")
    back = solid_of(make.obj_text("cup", mesh))
    np.testing.assert_allclose(back.vertices, mesh.vertices, atol=1e-9)
    np.testing.assert_array_equal(back.faces, mesh.faces)


def test_the_command_writes_every_mesh(make, made, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("sys.argv", ["make.py", str(tmp_path / "objects")])
    make.main()
    assert {path.stem for path in (tmp_path / "objects").iterdir()} == set(made)
    again = solid_of((tmp_path / "objects" / "cup.obj").read_text(encoding="utf-8"))
    assert differences(again, made["cup"]) == []

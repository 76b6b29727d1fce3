"""Files of other programs: MATLAB's recordings, meshes of objects."""

import io
import struct
import tracemalloc
from time import perf_counter

import numpy as np
import pytest
import trimesh
from hypothesis import strategies as st
from scipy.io import savemat

from handsim.errors import HandsimError
from handsim.objects.mesh_import import object_from_mesh

from .conftest import damaged_bytes, search

CELLS = ("X_R2G_SUBJECTbyOBJECT", "t_R2G_SUBJECTbyOBJECT")


def published(compressed: bool) -> tuple[bytes, bytes]:
    """Two files of the layout of a publication, one subject and five reaches."""
    time = np.arange(60) / 50
    angles, times = np.empty((1, 5), object), np.empty((1, 5), object)
    closing = 0.5 * (1 - np.cos(np.pi * np.clip((time - 0.2) / 0.8, 0, 1)))
    for i in range(5):
        angles[0, i] = -closing[:, None] * np.linspace(0.2, 1.0 + 0.1 * i, 23)
        times[0, i] = time[:, None]
    files = []
    for name, cells in zip(CELLS, (angles, times), strict=True):
        stream = io.BytesIO()
        savemat(stream, {name: cells}, do_compression=compressed)
        files.append(stream.getvalue())
    return files[0], files[1]


@pytest.mark.parametrize("compressed", [False, True])
def test_recordings_of_matlab(sandbox, compressed):
    x, t = published(compressed)

    def check(damaged: bytes) -> None:
        sandbox.fresh()
        paths = [sandbox.inputs / "x.mat", sandbox.inputs / "t.mat"]
        for path, content in zip(paths, (damaged, t), strict=True):
            path.write_bytes(content)
        out = sandbox.outputs / "set"
        sandbox.run("recordings", "import", *paths, "--format", "west-rtg", "-o", out)

    check(x)
    assert sandbox.codes == [0]
    search(check, damaged_bytes(x), 30 * sandbox.cases)
    assert 2 in sandbox.codes


@pytest.mark.parametrize(
    "claimed", [(2_000, 50_000), (50_000, 50_000), (2**31 - 1, 5), (2**31 - 1, 2**31 - 1)]
)
def test_cells_that_are_only_claimed_take_no_memory(sandbox, claimed, memory_limit):
    x, t = published(compressed=False)
    dimensions = struct.pack("<ii", 1, 5)
    assert x.count(dimensions) == 1
    sandbox.fresh()
    (sandbox.inputs / "x.mat").write_bytes(x.replace(dimensions, struct.pack("<ii", *claimed)))
    (sandbox.inputs / "t.mat").write_bytes(t)
    files = [sandbox.inputs / "x.mat", sandbox.inputs / "t.mat"]
    out = sandbox.outputs / "set"
    tracemalloc.start()
    assert sandbox.run("recordings", "import", *files, "--format", "west-rtg", "-o", out) == 2
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50e6


MESHES = {
    kind: trimesh.creation.box((0.04, 0.05, 0.06)).export(file_type=kind)
    for kind in ("obj", "stl", "ply", "off")
}


@pytest.mark.parametrize("kind", sorted(MESHES))
def test_meshes(sandbox, kind):
    whole = MESHES[kind]
    whole = whole.encode() if isinstance(whole, str) else whole
    made = []

    def check(damaged: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / f"thing.{kind}"
        path.write_bytes(damaged)
        try:
            object_from_mesh(path, 0.1)
        except HandsimError as error:
            assert "\n" not in str(error)
            made.append(False)
        else:
            made.append(True)

    search(check, damaged_bytes(whole), 12 * sandbox.cases)
    search(check, st.binary(max_size=100), 3 * sandbox.cases)
    assert False in made


def things() -> dict[str, bytes]:
    """Meshes with more to damage: a bottle, a hollow, two bodies, a concave bracket, a soup."""
    bottle = trimesh.creation.revolve(
        np.array([[0, 0], [30, 0], [33, 5], [33, 130], [14, 185], [14, 210], [0, 210]]), sections=16
    )
    inner = trimesh.creation.box((0.05, 0.05, 0.05))
    hollow = trimesh.util.concatenate([trimesh.creation.box((0.06, 0.06, 0.06)), inner])
    two = trimesh.util.concatenate(
        [trimesh.creation.box((0.1, 0.03, 0.03)), trimesh.creation.cylinder(0.01, 0.25)]
    )
    made = {
        "bottle.stl": bottle.export(file_type="stl"),
        "bottle.obj": bottle.export(file_type="obj"),
        "hollow.ply": hollow.export(file_type="ply"),
        "two.off": two.export(file_type="off"),
        "words.stl": bottle.export(file_type="stl_ascii"),
    }
    return {name: each.encode() if isinstance(each, str) else each for name, each in made.items()}


@pytest.mark.parametrize("name", sorted(things()))
def test_own_things_are_checked_or_refused_in_one_line_and_soon(sandbox, name, monkeypatch):
    """What has to be decomposed is taken as it is here: that is done by another program."""
    monkeypatch.setattr("handsim.objects.contact_pieces.decompose", lambda v, f, seed: [v])
    whole = things()[name]
    longest = 0.0

    def check(damaged: bytes) -> None:
        nonlocal longest
        sandbox.fresh()
        path = sandbox.inputs / name
        path.write_bytes(damaged)
        began = perf_counter()
        sandbox.run("object", "check", path, "--json")
        longest = max(longest, perf_counter() - began)

    check(whole)
    assert sandbox.codes == [0]
    search(check, damaged_bytes(whole), 20 * sandbox.cases)
    assert 2 in sandbox.codes
    assert longest < 20


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        ("ply", b"ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\n"
                b"property float y\nproperty float z\nend_header\n0 0 0\n"),
        ("ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\n"
                b"property float x\nproperty float y\nproperty float z\nend_header\n0000"),
        ("stl", bytes(80) + b"\xff\xff\xff\xff" + bytes(50)),
        ("off", b"OFF\n999999999999 999999999999 0\n0 0 0\n"),
        ("obj", b"v 0 0 0\nf 1 99999999999 -5\n"),
    ],
)  # fmt: skip
def test_meshes_that_only_claim_to_be_large(tmp_path, kind, content, memory_limit):
    path = tmp_path / f"thing.{kind}"
    path.write_bytes(content)
    with pytest.raises(HandsimError):
        object_from_mesh(path, 0.1)


def test_a_mesh_names_no_other_file(tmp_path):
    """Materials and textures are other files; they are not opened."""
    text = MESHES["obj"]
    (tmp_path / "thing.mtl").write_text("newmtl a\nmap_Kd secret.png\n")
    (tmp_path / "thing.obj").write_text(f"mtllib thing.mtl\nusemtl a\n{text}")
    (tmp_path / "thing.mtl").chmod(0)
    assert object_from_mesh(tmp_path / "thing.obj", 0.1).pieces

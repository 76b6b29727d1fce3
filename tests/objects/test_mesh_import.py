import builtins
import os
import sys
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from handsim.errors import FileError, InputError, MissingToolError
from handsim.objects import _convex_pieces
from handsim.objects._convex_pieces import MODES
from handsim.objects.contact_pieces import MAX_HULL_POINTS
from handsim.objects.mesh_import import object_from_mesh, read_object
from handsim.objects.mjcf import add_object
from handsim.objects.object import GraspObject
from handsim.tasks.scene import build_scene


def saved(mesh: trimesh.Trimesh, path: Path) -> Path:
    mesh.export(path)
    return path


def bracket() -> trimesh.Trimesh:
    """Return an L of 60 x 60 x 20 mm and 20 mm thick, closed."""
    outline = np.array([[0, 0], [60, 0], [60, 20], [20, 20], [20, 60], [0, 60]]) / 1000
    lower = np.column_stack([outline, np.zeros(6)])
    upper = np.column_stack([outline, np.full(6, 0.02)])
    caps = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    sides = [
        row
        for i, j in zip(range(6), [1, 2, 3, 4, 5, 0], strict=True)
        for row in ([i, j, j + 6], [i, j + 6, i + 6])
    ]
    return trimesh.Trimesh(
        np.vstack([lower, upper]), np.vstack([caps[:, ::-1], caps + 6, sides]), process=False
    )


REAL = Path(__file__).parents[2] / "../shared/data/objects"
real_data = pytest.mark.skipif(not REAL.is_dir(), reason="no scanned objects in ../shared")


def rest(grasp_object: GraspObject, seconds: float = 1.0) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = build_scene(grasp_object, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    return model, data


@pytest.mark.parametrize("kind", ["obj", "stl", "ply", "off"])
def test_a_box_of_any_format_becomes_an_object_that_stands(tmp_path: Path, kind: str) -> None:
    mesh = trimesh.creation.box((40, 60, 80)).apply_translation((100, 0, 7))
    path = saved(mesh, tmp_path / f"thing.{kind}")
    grasp_object = object_from_mesh(path, 0.2, scale=0.001)
    assert (grasp_object.name, grasp_object.mass, len(grasp_object.colliders)) == ("thing", 0.2, 1)
    model, data = rest(grasp_object)
    np.testing.assert_allclose(data.qpos[:3], 0, atol=1e-4)
    inertia = 0.2 / 12 * np.array([0.04**2 + 0.06**2, 0.04**2 + 0.08**2, 0.06**2 + 0.08**2])
    np.testing.assert_allclose(np.sort(model.body("object").inertia), inertia, rtol=1e-5)


def test_a_fine_convex_mesh_gets_one_thinned_hull(tmp_path: Path) -> None:
    path = saved(trimesh.creation.icosphere(5, 0.03), tmp_path / "ball.ply")
    (collider,) = object_from_mesh(path, 0.1).colliders
    assert len(collider.points) <= MAX_HULL_POINTS
    centred = np.array(collider.points) - [0, 0, 0.03]
    np.testing.assert_allclose(np.linalg.norm(centred, axis=1), 0.03, rtol=1e-3)


def test_a_concave_mesh_is_decomposed_the_same_way_each_time(tmp_path: Path) -> None:
    pytest.importorskip("coacd", reason="concave meshes are decomposed by coacd")
    path = saved(bracket(), tmp_path / "bracket.stl")
    first, second = (object_from_mesh(path, 0.1).colliders for _ in range(2))
    assert first == second
    assert len(first) >= 2
    for collider in first:  # no piece fills the notch
        assert not trimesh.convex.convex_hull(np.array(collider.points)).contains(
            [[0.02, 0.02, 0.01]]
        )
    _, data = rest(object_from_mesh(path, 0.1))
    np.testing.assert_allclose(data.qpos[:3], 0, atol=1e-3)


def test_without_the_decomposer_the_command_that_installs_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = saved(bracket(), tmp_path / "bracket.stl")
    monkeypatch.setattr("handsim.objects._convex_pieces.find_spec", lambda name: None)
    with pytest.raises(
        MissingToolError, match=r"bracket\.stl: .* run: pip install 'handsim.assets.'"
    ):
        object_from_mesh(path, 0.1)


def test_a_decomposition_that_crashes_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd", reason="concave meshes are decomposed by coacd")
    path = saved(bracket(), tmp_path / "bracket.stl")
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(InputError, match=r"bracket\.stl: the mesh cannot be decomposed"):
        object_from_mesh(path, 0.1)


def test_a_decomposition_without_end_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd", reason="concave meshes are decomposed by coacd")
    path = saved(bracket(), tmp_path / "bracket.stl")
    monkeypatch.setitem(MODES, "off", 0.01)
    with pytest.raises(InputError, match="not decomposed within"):
        object_from_mesh(path, 0.1)


@pytest.mark.skipif(find_spec("resource") is None, reason="no limits of the processor's time")
@pytest.mark.parametrize(("busy", "refused"), [("while True: pass", True), ("sleep(2.0)", False)])
def test_what_counts_is_the_time_of_the_processor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, busy: str, refused: bool
) -> None:
    """Where it is given to other programs, a mesh that takes longer by the clock is not refused."""
    pytest.importorskip("coacd", reason="concave meshes are decomposed by coacd")
    (tmp_path / "coacd.py").write_text(
        "from time import sleep\ndef set_log_level(level): pass\n"
        "def Mesh(vertices, faces): return vertices, faces\n"
        f"def run_coacd(mesh, **options):\n    {busy}\n    return [mesh]\n"
    )
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.setitem(MODES, "off", 1.0)
    monkeypatch.setattr(_convex_pieces, "PATIENCE", 60.0)
    path = saved(bracket(), tmp_path / "bracket.stl")
    if refused:
        before = sum(os.times()[2:4])  # of ended children
        with pytest.raises(InputError, match="not decomposed within 1 s; simplify it"):
            object_from_mesh(path, 0.1)
        assert sum(os.times()[2:4]) - before < 4.0
    else:
        assert len(object_from_mesh(path, 0.1).colliders) == 1


def test_a_mesh_with_a_large_hole_is_refused_by_name(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.04, 0.04, 0.04))
    mesh.update_faces(np.arange(len(mesh.faces)) > 0)
    path = saved(mesh, tmp_path / "holey.stl")
    with pytest.raises(FileError, match=r"holey\.stl: the mesh is not watertight: 1 hole"):
        object_from_mesh(path, 0.1)


def test_a_mesh_turned_inside_out_is_turned_back(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.04, 0.04, 0.04))
    mesh.invert()
    model, _ = rest(object_from_mesh(saved(mesh, tmp_path / "out.stl"), 0.1), 0.01)
    assert model.body("object").mass[0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.stl", None, "no such file"),
        ("scene.glb", b"x", "format 'glb' is not one of obj, stl, ply, off"),
        ("cut.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 9\n", "not a readable"),
        ("words.obj", b"just some words\n", "holds no surface|not a readable"),
        (
            "bad.obj",
            b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "finite|not a readable|holds no surface",
        ),
        (
            "flat.obj",
            b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nv .1 .1 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n",
            "encloses no volume|not watertight",
        ),
        (
            "words.stl",
            b"solid x\nfacet normal 0 0 up\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
            b"vertex 0 1 0\nendloop\nendfacet\nendsolid x\n" + 80 * b" ",
            "encloses no volume|not a readable",
        ),
        ("empty.off", b"", "not a readable|holds no surface"),
    ],
)
def test_files_that_are_no_closed_mesh_are_named(
    tmp_path: Path,
    name: str,
    content: bytes | None,
    message: str,
    caplog: pytest.LogCaptureFixture,
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=message) as caught:
        object_from_mesh(tmp_path / name, 0.1)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not caplog.records  # which would end on standard error


@pytest.mark.parametrize(
    ("mass", "scale", "message"),
    [
        (0.0, 1.0, "mass 0 kg"),
        (-1.0, 1.0, "mass -1 kg"),
        (200.0, 1.0, "mass 200 kg"),
        (np.nan, 1.0, "mass nan kg"),
        (0.1, 0.0, "scale 0 is not positive"),
        (0.1, np.nan, "scale nan"),
        (0.1, 1000.0, "longest side is 40 m"),
    ],
)
def test_mass_and_size_out_of_range_are_refused(
    tmp_path: Path, mass: float, scale: float, message: str
) -> None:
    path = saved(trimesh.creation.box((0.04, 0.04, 0.04)), tmp_path / "box.stl")
    with pytest.raises(InputError, match=message):
        object_from_mesh(path, mass, scale=scale)


def test_no_other_file_is_opened_for_a_mesh(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    box = str(trimesh.creation.box((0.04, 0.04, 0.04)).export(file_type="obj"))
    (tmp_path / "box.obj").write_text("mtllib other.mtl\nusemtl x\n" + box, encoding="utf-8")
    (tmp_path / "other.mtl").write_text("newmtl x\nmap_Kd secret.png\n", encoding="utf-8")
    opened: list[str] = []
    plain = builtins.open

    def recording(file: object, *args: object, **kwargs: object) -> object:
        opened.append(str(file))
        return plain(file, *args, **kwargs)  # type: ignore[call-overload]

    monkeypatch.setattr(builtins, "open", recording)
    assert len(object_from_mesh(tmp_path / "box.obj", 0.1).colliders) == 1
    assert not [name for name in opened if name.startswith(str(tmp_path)) and "box.obj" not in name]


@pytest.mark.parametrize("kind", ["obj", "stl", "ply", "off"])
def test_a_damaged_file_gives_an_object_or_one_line(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("handsim.objects.contact_pieces.decompose", lambda v, f, s: [v])
    whole = saved(trimesh.creation.box((0.04, 0.05, 0.06)), tmp_path / f"whole.{kind}").read_bytes()
    generator = np.random.default_rng(7)
    path, refused = tmp_path / f"damaged.{kind}", 0
    for _ in range(150):
        content = bytearray(whole)
        for _ in range(generator.integers(1, 5)):
            place, change = int(generator.integers(len(content))), generator.integers(4)
            if change == 0:
                content[place] = int(generator.integers(256))
            elif change == 1:
                del content[place : place + int(generator.integers(1, 30))]
            elif change == 2:
                content[place:place] = generator.choice([b"nan", b"1e308", b"-9", b"\n", b"\0" * 8])
            else:
                content = content[: max(place, 1)]
        path.write_bytes(bytes(content))
        try:
            spec = mujoco.MjSpec()
            add_object(spec, object_from_mesh(path, 0.1))
            spec.compile()
        except InputError as error:
            refused += 1
            assert str(path) in str(error)
            assert "\n" not in str(error)
    assert 50 < refused < 150


def can(folder: Path, up: str = "z", scale: float = 1000.0) -> Path:
    """A can of 66 x 122 mm whose axis is that of the file named."""
    mesh = trimesh.creation.cylinder(0.033 * scale, 0.122 * scale, sections=48)
    turn = {"x": (np.pi / 2, [0, 1, 0]), "y": (-np.pi / 2, [1, 0, 0]), "z": (0.0, [0, 0, 1])}[up]
    mesh.apply_transform(trimesh.transformations.rotation_matrix(*turn))
    return saved(mesh, folder / "can.stl")


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_a_can_stands_whatever_the_axis_of_its_file_and_stays(tmp_path: Path, up: str) -> None:
    own = read_object(can(tmp_path, up))
    assert own.resting[0].name == f"+{up}"
    np.testing.assert_allclose(own.size, [0.066, 0.066, 0.122], rtol=0.01)
    _, data = rest(own.object, 0.5)
    np.testing.assert_allclose(data.qpos[2:7], [0, 1, 0, 0, 0], atol=1e-3)


def test_what_is_asked_to_be_up_is_up(tmp_path: Path) -> None:
    lying = read_object(can(tmp_path, "y"), up="z")
    np.testing.assert_allclose(lying.size, [0.066, 0.122, 0.066], rtol=0.01)
    standing = object_from_mesh(can(tmp_path, "y"), 0.3, scale=0.001, up="y")
    heights = np.array(standing.colliders[0].points)[:, 2]
    np.testing.assert_allclose([heights.min(), heights.max()], [0, 0.122], atol=1e-9)


def test_a_pose_nearly_asked_for_is_straightened_and_said(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.05, 0.05, 0.10))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.deg2rad(4.0), [1, 0, 0]))
    own = read_object(saved(mesh, tmp_path / "box.stl"), scale=1.0, up="z")
    assert "turned by 4.0 deg to rest with z up" in own.guessed
    assert own.size[2] == pytest.approx(0.10, rel=1e-3)


def test_unit_and_mass_are_guessed_and_said_and_kept_where_given(tmp_path: Path) -> None:
    guessed = read_object(can(tmp_path))
    assert guessed.scale == 0.001
    volume = 48 / 2 * np.sin(2 * np.pi / 48) * 0.033**2 * 0.122
    assert guessed.object.mass == pytest.approx(1000 * volume, abs=1e-4)
    assert [each.split()[0] for each in guessed.guessed] == ["unit", "mass", "up"]
    given = read_object(can(tmp_path), scale=0.0005, mass=0.3, up="z")
    assert (given.object.mass, given.guessed) == (0.3, ())
    assert given.size[2] == pytest.approx(0.061)


def test_every_way_to_rest_can_be_stood_in(tmp_path: Path) -> None:
    own = read_object(
        saved(trimesh.creation.box((0.03, 0.06, 0.12)), tmp_path / "brick.stl"), scale=1.0
    )
    heights = [max(z for _, _, z in own.standing(pose).colliders[0].points) for pose in own.resting]
    np.testing.assert_allclose(heights, [0.03, 0.03, 0.06, 0.06, 0.12, 0.12], atol=1e-9)


def test_ready_pieces_are_taken_in_place_of_a_decomposition(tmp_path: Path) -> None:
    path, folder = saved(bracket(), tmp_path / "bracket.stl"), tmp_path / "parts"
    folder.mkdir()
    for i, (sides, at) in enumerate(
        [((0.06, 0.02, 0.02), (0.03, 0.01, 0.01)), ((0.02, 0.04, 0.02), (0.01, 0.04, 0.01))]
    ):
        saved(trimesh.creation.box(sides).apply_translation(at), folder / f"contact{i}.stl")
    made = object_from_mesh(path, 0.1, pieces=folder)
    assert len(made.colliders) == 2
    points = np.concatenate([np.array(each.points) for each in made.colliders])
    np.testing.assert_allclose(points.min(axis=0), [-0.03, -0.03, 0], atol=1e-9)
    (folder / "contact0.stl").unlink()
    with pytest.raises(FileError, match=r"pieces end 40 mm from where the mesh ends"):
        object_from_mesh(path, 0.1, pieces=folder)
    (folder / "contact1.stl").unlink()
    with pytest.raises(FileError, match="0 meshes in it"):
        object_from_mesh(path, 0.1, pieces=folder)
    with pytest.raises(FileError, match="no such folder"):
        object_from_mesh(path, 0.1, pieces=tmp_path / "none")


def test_bodies_that_are_each_convex_need_no_decomposition(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("handsim.objects.contact_pieces.decompose", None)
    head = trimesh.creation.box((0.1, 0.03, 0.03)).apply_translation((0, 0.1, 0))
    hammer = trimesh.util.concatenate([head, trimesh.creation.box((0.02, 0.28, 0.02))])
    own = read_object(saved(hammer, tmp_path / "hammer.stl"))
    assert len(own.object.colliders) == 2
    assert "2 bodies taken as one rigid thing" in own.mended


def test_a_hollow_weighs_in_its_wall(tmp_path: Path) -> None:
    inner = trimesh.creation.box((0.098, 0.098, 0.098))
    shell = trimesh.util.concatenate([trimesh.creation.box((0.1, 0.1, 0.1)), inner])
    own = read_object(saved(shell, tmp_path / "shell.stl"), mass=0.1)
    assert len(own.object.colliders) == 1
    model, _ = rest(own.object, 0.01)
    expected = 0.1 / 6 * (0.1**5 - 0.098**5) / (0.1**3 - 0.098**3)
    np.testing.assert_allclose(model.body("object").inertia, expected, rtol=1e-3)


@real_data
@pytest.mark.real_data
@pytest.mark.parametrize(
    ("name", "n_pieces", "height"),
    [("cubemedium", 1, 0.080), ("cup", 12, 0.100), ("mouse", 1, 0.039), ("mug", 14, 0.105),
     ("scissors", 14, 0.0145)],
)  # fmt: skip
def test_scanned_things_stand_as_they_are_used(name: str, n_pieces: int, height: float) -> None:
    own = read_object(REAL / name / f"{name}.stl", pieces=REAL / name, mass=0.2)
    assert (own.watertight, own.mended, own.scale) == (True, (), 1.0)
    assert (len(own.object.colliders), own.resting[0].name) == (n_pieces, "+z")
    assert own.size[2] == pytest.approx(height, abs=1e-3)
    _, data = rest(own.object, 0.5)
    assert data.body("object").xmat[8] > np.cos(np.deg2rad(3.0))  # scissors rock on three points

import mujoco
import numpy as np
import pytest
import trimesh

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import data_folder
from handsim.objects.mjcf import OBJECTS, add_object, object_by_name, read_mesh
from handsim.objects.object import Piece
from handsim.tasks.scene import build_scene

TABLE_I = (
    "tall-glass", "mouse", "cup", "hammer", "ashtray", "cube", "pen", "jar", "screwdriver", "book",
    "phone", "scissors", "stapler",
)  # fmt: skip

# Bounding boxes of the real things [mm], along x, y, z as they rest, and masses [g].
REAL = {
    "tall-glass": ((64, 64, 145), 225),
    "mouse": ((113, 62, 38), 88),
    "cup": ((110.8, 80, 82), 225),
    "hammer": ((302, 105, 23), 378),
    "ashtray": ((100, 100, 32), 330),
    "cube": ((55, 55, 55), 119),
    "pen": ((140, 10.4, 11.2), 12),
    "jar": ((72, 72, 104), 264),
    "screwdriver": ((215, 30.3, 27), 97),
    "book": ((130, 22, 200), 390),
    "phone": ((106, 48, 15.5), 105),
    "phone-today": ((147.6, 71.6, 7.8), 171),
    "scissors": ((199, 87, 10.5), 82),
    "stapler": ((130, 36, 55), 200),
}

# What mass over volume may be [kg/m3]: solid materials as they are, shells with works inside less.
DENSITY = {
    "tall_glass": (2400, 2600), "jar_glass": (2400, 2600), "ashtray": (2400, 2600),
    "cup": (2200, 2500), "hammer_head": (6500, 7900), "hammer_handle": (600, 800),
    "cube": (650, 780), "book_pages": (700, 850), "book_cover": (550, 750),
    "jar_coffee": (200, 300), "screwdriver_handle": (1000, 1350), "screwdriver_blade": (7600, 8000),
    "scissors_blade": (7000, 14000), "scissors_moving_blade": (7000, 14000),
}  # fmt: skip


def pieces_of(name: str) -> tuple[Piece, ...]:
    linked = (piece for link in OBJECTS[name].links for piece in link.pieces)
    return (*OBJECTS[name].pieces, *linked)


def solid_of(piece: Piece) -> trimesh.Trimesh:
    assert isinstance(piece.mesh, str)
    mesh = read_mesh(piece.mesh)
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def compiled(name: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = build_scene(name, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def settle(model: mujoco.MjModel, data: mujoco.MjData, seconds: float) -> None:
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))


def turned_deg(quat: np.ndarray, other: np.ndarray) -> float:
    return float(np.rad2deg(2 * np.arccos(min(1.0, abs(quat @ other)))))


def test_there_are_the_13_objects_of_the_table_and_todays_phone() -> None:
    assert tuple(name for name in OBJECTS if name != "phone-today") == TABLE_I
    assert all(OBJECTS[name].name == name for name in OBJECTS)
    assert set(REAL) == set(OBJECTS)


@pytest.mark.parametrize("name", OBJECTS)
def test_every_mesh_is_watertight(name: str) -> None:
    for piece in pieces_of(name):
        solid = solid_of(piece)
        assert solid.is_watertight, piece.mesh
        assert solid.is_winding_consistent, piece.mesh
        assert solid.volume > 0, piece.mesh


@pytest.mark.parametrize("name", OBJECTS)
def test_size_and_mass_are_the_real_ones(name: str) -> None:
    vertices = np.vstack([solid_of(piece).vertices for piece in pieces_of(name)])
    sides_mm, mass_g = REAL[name]
    np.testing.assert_allclose(1000 * np.ptp(vertices, axis=0), sides_mm, atol=1.0)
    assert 1000 * OBJECTS[name].mass == pytest.approx(mass_g, abs=0.5)
    assert vertices[:, 2].min() == pytest.approx(0.0, abs=1e-5)


def test_the_readme_states_the_sizes_and_masses() -> None:
    text = (data_folder("assets") / "README.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("| ")]
    stated = {row[0].strip(): row for row in rows if row[0].strip() in OBJECTS}
    assert set(stated) == set(OBJECTS)
    for name, row in stated.items():
        sides = [float(side) for side in row[1].split("x")]
        np.testing.assert_allclose(sides, REAL[name][0], atol=0.5)
        assert float(row[2]) == REAL[name][1]
        hinges = [link.hinge.name for link in OBJECTS[name].links]
        assert all(f"`{hinge}`" in row[4] for hinge in hinges), name


def test_masses_agree_with_volumes_and_materials() -> None:
    pieces = {piece.mesh: piece for name in OBJECTS for piece in pieces_of(name)}
    for mesh, (low, high) in DENSITY.items():
        piece = pieces[mesh]
        assert low <= piece.mass / solid_of(piece).volume <= high, mesh


@pytest.mark.parametrize("name", OBJECTS)
def test_mass_and_inertia_of_the_compiled_bodies_are_those_of_the_meshes(name: str) -> None:
    model, _ = compiled(name)
    bodies = {"object": OBJECTS[name].pieces}
    bodies |= {link.hinge.name: link.pieces for link in OBJECTS[name].links}
    for body, pieces in bodies.items():
        solids = [solid_of(piece) for piece in pieces]
        mass = sum(piece.mass for piece in pieces)
        parts = list(zip(pieces, solids, strict=True))
        centre = sum(piece.mass * solid.center_mass for piece, solid in parts) / mass
        inertia = np.zeros((3, 3))
        for piece, solid in parts:
            arm = solid.center_mass - centre
            inertia += piece.mass / solid.volume * solid.moment_inertia
            inertia += piece.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        assert model.body(body).mass[0] == pytest.approx(mass, rel=1e-6)
        np.testing.assert_allclose(model.body(body).ipos, centre, atol=1e-6)
        np.testing.assert_allclose(
            np.sort(model.body(body).inertia), np.linalg.eigvalsh(inertia), rtol=1e-4
        )


@pytest.mark.parametrize("name", OBJECTS)
def test_rests_where_it_is_set_down_however_it_is_turned(name: str) -> None:
    """At every time of 2 s, not at the end alone: what hops up may come down again."""
    for turn in np.arange(12) * np.pi / 6 + 0.013:
        model = build_scene(name, None, turn=turn).compile()
        data = mujoco.MjData(model)
        before = data.qpos.copy()
        for _ in range(50):
            settle(model, data, 0.04)
            assert np.linalg.norm(data.qpos[:3] - before[:3]) < 1e-3, turn
            assert turned_deg(before[3:7], data.qpos[3:7]) < 1.0, turn
            assert np.abs(np.rad2deg(data.qpos[7:] - before[7:])).max(initial=0.0) < 1.0, turn
        assert np.abs(data.qvel).max() < 1e-3, turn
        assert data.warning.number.sum() == 0


@pytest.mark.parametrize("name", OBJECTS)
def test_no_cylinder_stands_on_the_table(name: str) -> None:
    """MuJoCo's contact of a plane with a cylinder that is upright to within rounding is wrong."""
    model, data = compiled(name)
    cylinders = model.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER
    upright = np.abs(data.geom_xmat[:, 8]) > 0.99
    assert not (cylinders & upright & (model.geom_contype > 0)).any()


@pytest.mark.parametrize("name", OBJECTS)
def test_contact_pieces_lie_on_what_is_seen(name: str) -> None:
    """Rays from all sides meet the collision pieces where they meet the meshes.

    Edges are rounded in one and not in the other, a book's pages lie 3 mm behind its boards, and a
    grazing ray runs far between the two.
    """
    model, data = compiled(name)
    shown, solid = (np.array([i == group for i in range(6)], np.uint8) for group in (2, 3))
    table = [model.geom("table").id, model.geom("table_top").id]
    model.geom_group[table] = 0
    generator = np.random.default_rng(0)
    centre, extent = data.body("object").xipos, np.array(REAL[name][0]) / 1000
    gaps = []
    for _ in range(400):
        direction = generator.normal(size=3)
        direction[2] = -abs(direction[2])  # not from below the table
        direction /= np.linalg.norm(direction)
        target = centre + generator.uniform(-0.45, 0.45, 3) * extent
        start, hit = target - 0.5 * direction, np.zeros(1, np.int32)
        far = [
            mujoco.mj_ray(model, data, start, direction, group, 1, -1, hit)
            for group in (shown, solid)
        ]
        if min(far) > 0:
            gaps.append(abs(far[0] - far[1]))
    assert len(gaps) > 100
    assert np.median(gaps) < 0.7e-3
    assert np.quantile(gaps, 0.9) < 4e-3


@pytest.mark.parametrize(
    ("name", "floor"), [("tall-glass", 0.010), ("cup", 0.005), ("ashtray", 0.008)]
)
def test_a_marble_falls_into_a_hollow_object(name: str, floor: float) -> None:
    radius = 0.008
    spec = build_scene(name, None)
    marble = spec.worldbody.add_body(name="marble", pos=[0.005, 0.004, 0.18])
    marble.add_freejoint()
    marble.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], density=2500)
    model = spec.compile()
    data = mujoco.MjData(model)
    settle(model, data, 1.5)
    assert data.body("marble").xpos[2] == pytest.approx(floor + radius, abs=5e-4)


def test_the_cup_has_a_handle_one_can_reach_through() -> None:
    cup = solid_of(OBJECTS["cup"].pieces[0])
    assert cup.euler_number == 0  # one hole through a closed surface
    model, data = compiled("cup")
    through = mujoco.mj_ray(
        model, data, np.array([0.050, 0.2, 0.045]), np.array([0.0, -1.0, 0.0]),
        np.array([0, 0, 0, 1, 0, 0], np.uint8), 1, -1, np.zeros(1, np.int32),
    )  # fmt: skip
    assert through == -1


def test_scissors_have_two_loops() -> None:
    for piece in pieces_of("scissors"):
        holes = {"scissors_grip": 1, "scissors_moving_grip": 1}.get(str(piece.mesh), 0)
        genus = sum(1 - part.euler_number / 2 for part in solid_of(piece).split())
        assert genus == holes, piece.mesh


def push(name: str, body: str, at: tuple[float, float, float], force: float) -> float:
    """Return the angle [deg] of hinge ``body`` under a downward force [N] at a point of it."""
    model, data = compiled(name)
    settle(model, data, 0.3)
    for _ in range(200):
        data.qfrc_applied[:] = 0
        mujoco.mj_applyFT(
            model, data, np.array([0, 0, -force]), np.zeros(3), np.array(at),
            model.body(body).id, data.qfrc_applied,
        )  # fmt: skip
        mujoco.mj_step(model, data)
    pressed = float(np.rad2deg(data.joint(body).qpos[0]))
    data.qfrc_applied[:] = 0
    settle(model, data, 0.5)
    assert abs(np.rad2deg(data.joint(body).qpos[0])) < 0.15  # it comes back
    return pressed


@pytest.mark.parametrize(("button", "y"), [("left_button", 0.015), ("right_button", -0.015)])
def test_mouse_buttons_click_under_a_fingertip_and_not_under_a_resting_finger(
    button: str, y: float
) -> None:
    assert push("mouse", button, (0.0536, y, 0.02), 1.2) > 1.0
    assert push("mouse", button, (0.0536, y, 0.02), 0.4) < 0.7


def test_the_stapler_shuts_under_a_push_and_opens_again() -> None:
    assert push("stapler", "arm", (0.05, 0.0, 0.05), 8.0) > 4.5
    assert push("stapler", "arm", (0.05, 0.0, 0.05), 1.0) < 2.0


def test_the_lid_rises_by_its_pitch_as_it_is_unscrewed() -> None:
    model, data = compiled("jar")
    data.eq_active[:] = 1
    held = data.qpos[:7].copy()
    for _ in range(200):
        data.joint("lid").qfrc_applied[:] = 0.25
        mujoco.mj_step(model, data)
        data.qpos[:7], data.qvel[:6] = held, 0
        if data.joint("lid").qpos[0] > np.pi / 2:
            break
    turned, risen = data.joint("lid").qpos[0], data.joint("lid_rise").qpos[0]
    assert turned > np.pi / 2
    assert risen == pytest.approx(0.006 * turned / (2 * np.pi), rel=0.02)


def test_the_lid_stays_under_a_torque_below_its_friction() -> None:
    model, data = compiled("jar")
    held = data.qpos[:7].copy()
    for _ in range(500):
        data.joint("lid").qfrc_applied[:] = 0.02
        mujoco.mj_step(model, data)
        data.qpos[:7], data.qvel[:6] = held, 0
    assert abs(np.rad2deg(data.joint("lid").qpos[0])) < 2.0


def test_opening_the_scissors_parts_the_loops() -> None:
    spec = build_scene("scissors", None)
    spec.body("blade").add_site(name="loop", pos=[-0.070, 0.0225, 0.0])
    model = spec.compile()
    data = mujoco.MjData(model)
    distance = []
    for angle in (0.0, 30.0):
        data.joint("blade").qpos[:] = np.deg2rad(angle)
        mujoco.mj_forward(model, data)
        distance.append(float(data.site("loop").xpos[1]))
    assert distance[1] - distance[0] > 0.03


@pytest.mark.parametrize(
    ("name", "hinge", "degrees"),
    [("scissors", "blade", 30.0), ("jar", "lid", 90.0), ("stapler", "arm", 3.0)],
)
def test_a_hinge_started_open_is_where_its_angle_puts_it(
    name: str, hinge: str, degrees: float
) -> None:
    """Starting at an angle equals starting at zero and turning the joint there."""
    specs = [mujoco.MjSpec(), mujoco.MjSpec()]
    add_object(specs[0], OBJECTS[name], start={hinge: np.deg2rad(degrees)})
    add_object(specs[1], OBJECTS[name])
    places = []
    for spec in specs:
        model = spec.compile()
        data = mujoco.MjData(model)
        data.joint(hinge).qpos[:] = np.deg2rad(degrees)
        if name == "jar":
            data.joint("lid_rise").qpos[:] = 0.006 / 4 if spec is specs[1] else 0.0
        mujoco.mj_forward(model, data)
        places.append((data.body(hinge).xipos.copy(), data.body(hinge).ximat.copy()))
    np.testing.assert_allclose(places[0][0], places[1][0], atol=1e-9)
    np.testing.assert_allclose(places[0][1], places[1][1], atol=1e-9)


def test_a_missing_mesh_is_named() -> None:
    with pytest.raises(FileError, match=r"no_such_thing\.obj: no such mesh"):
        read_mesh("no_such_thing")


def test_an_unknown_object_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="tall-glass"):
        object_by_name("tal-glas")


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_a_mass_scale_that_is_not_positive_is_refused(scale: float) -> None:
    with pytest.raises(InputError, match="mass scale"):
        add_object(mujoco.MjSpec(), OBJECTS["cube"], mass_scale=scale)


def test_mass_scale_scales_mass_and_inertia() -> None:
    models = []
    for scale in (1.0, 1.7):
        spec = mujoco.MjSpec()
        add_object(spec, OBJECTS["jar"], mass_scale=scale)
        models.append(spec.compile())
    np.testing.assert_allclose(models[1].body_mass, 1.7 * models[0].body_mass)
    np.testing.assert_allclose(models[1].body_inertia, 1.7 * models[0].body_inertia)


def test_hinges_start_within_their_range_and_under_their_name() -> None:
    with pytest.raises(InputError, match="cannot start at 90 deg; its range is 0 to 60 deg"):
        add_object(mujoco.MjSpec(), OBJECTS["scissors"], start={"blade": np.pi / 2})
    with pytest.raises(UnknownNameError, match="blade"):
        add_object(mujoco.MjSpec(), OBJECTS["scissors"], start={"blad": 0.1})

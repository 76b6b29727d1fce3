import mujoco
import numpy as np
import pytest

from handsim.errors import InputError
from handsim.viewing.film.posture_clips import posture_model
from handsim.viewing.live.shapes import geom_colour, geom_mesh, visible_geoms

XML = """
<mujoco>
  <asset>
    <material name="red" rgba="1 0 0 1"/>
    <mesh name="wedge" vertex="0 0 0  .2 0 0  0 .3 0  0 0 .4"/>
    <hfield name="hill" nrow="2" ncol="2" size="1 1 1 .1"/>
  </asset>
  <worldbody>
    <geom name="sphere" size=".1"/>
    <geom name="capsule" type="capsule" size=".1 .2"/>
    <geom name="ellipsoid" type="ellipsoid" size=".1 .2 .3" material="red"/>
    <geom name="cylinder" type="cylinder" size=".1 .2" rgba="0 1 0 .5" material="red"/>
    <geom name="box" type="box" size=".1 .2 .3" group="3"/>
    <geom name="plane" type="plane" size="0 2 .1" rgba="0 0 0 0"/>
    <geom name="wedge" type="mesh" mesh="wedge" pos="1 2 3" euler="30 40 50"/>
    <geom name="hill" type="hfield" hfield="hill"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(XML)


@pytest.mark.parametrize(
    ("name", "half"),
    [
        ("sphere", (0.1, 0.1, 0.1)),
        ("capsule", (0.1, 0.1, 0.3)),
        ("ellipsoid", (0.1, 0.2, 0.3)),
        ("cylinder", (0.1, 0.1, 0.2)),
        ("box", (0.1, 0.2, 0.3)),
        ("plane", (1.0, 2.0, 5e-5)),
    ],
)
def test_shapes_have_the_size_of_their_geoms(model, name, half) -> None:
    bounds = geom_mesh(model, model.geom(name).id).bounds
    np.testing.assert_allclose(bounds, [np.negative(half), half], atol=2e-3)


def test_meshes_stand_where_their_file_has_them(model) -> None:
    geom = model.geom("wedge")
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, geom.quat)
    placed = geom_mesh(model, geom.id).vertices @ turn.reshape(3, 3).T + geom.pos
    file_turn = np.zeros(4)
    mujoco.mju_euler2Quat(file_turn, np.deg2rad([30, 40, 50]), "xyz")
    mujoco.mju_quat2Mat(turn, file_turn)
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.3, 0], [0, 0, 0.4]])
    expected = corners @ turn.reshape(3, 3).T + (1, 2, 3)
    distances = np.linalg.norm(placed[:, None] - expected, axis=2)
    assert distances.min(axis=0).max() < 1e-6


def test_colours_are_the_geom_s_own_or_the_material_s(model) -> None:
    colours = {name: geom_colour(model, model.geom(name).id) for name in ("ellipsoid", "cylinder")}
    assert colours["ellipsoid"] == (1, 0, 0, 1)
    assert colours["cylinder"] == pytest.approx((0, 1, 0, 0.5))


def test_hidden_groups_and_transparent_geoms_are_left_out(model) -> None:
    names = {model.geom(i).name for i in visible_geoms(model)}
    assert names == {"sphere", "capsule", "ellipsoid", "cylinder", "wedge", "hill"}


def test_kinds_without_a_mesh_are_refused(model) -> None:
    with pytest.raises(InputError, match="render"):
        geom_mesh(model, model.geom("hill").id)


def test_all_that_is_seen_of_the_hand_has_a_mesh() -> None:
    hand = posture_model()
    shown = visible_geoms(hand)
    assert len(shown) >= 19
    for geom in shown:
        mesh = geom_mesh(hand, geom)
        assert mesh.is_watertight
        radius = np.linalg.norm(mesh.vertices, axis=1).max()
        assert radius == pytest.approx(hand.geom_rbound[geom], rel=0.02)

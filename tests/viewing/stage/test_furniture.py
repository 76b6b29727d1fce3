import mujoco
import numpy as np
import pytest

from handsim.tasks.scene import TABLE_TOP, build_scene
from handsim.viewing.film.offscreen import open_offscreen
from handsim.viewing.stage.camera import Camera
from handsim.viewing.stage.furniture import draw_furniture, furniture_of


@pytest.fixture(scope="module")
def scene() -> mujoco.MjModel:
    return build_scene("cube").compile()


def test_table_has_an_edge_all_round_and_legs_down_to_the_floor(scene: mujoco.MjModel) -> None:
    edge, *legs, floor = furniture_of(scene)
    table = scene.geom("table_top")
    assert edge.pos[2] + edge.size[2] == pytest.approx(-0.004), "below the top"
    assert edge.pos[2] - edge.size[2] == pytest.approx(-TABLE_TOP[2])
    np.testing.assert_allclose(edge.size[:2] - table.size[:2], 0.012)
    assert len(legs) == 4
    for leg in legs:
        assert leg.pos[2] + leg.size[2] == pytest.approx(-TABLE_TOP[2])
        assert leg.pos[2] - leg.size[2] == pytest.approx(-0.73)
        assert (np.abs(leg.pos[:2] - table.pos[:2]) + leg.size[:2] < table.size[:2]).all()
    assert floor.pos[2] + floor.size[2] == pytest.approx(-0.73)
    assert len({tuple(leg.pos) for leg in legs}) == 4


def test_other_models_get_none(ball: mujoco.MjModel) -> None:
    assert furniture_of(ball) == ()


def test_no_more_is_drawn_than_there_is_room_for(scene: mujoco.MjModel) -> None:
    parts = furniture_of(scene)
    for room, drawn in ((100, 6), (4, 4), (0, 0)):
        picture = mujoco.MjvScene(scene, room)
        draw_furniture(picture, parts)
        assert picture.ngeom == drawn


def test_furniture_is_no_object_of_the_model(scene: mujoco.MjModel) -> None:
    """Whatever was drawn in its place before."""
    picture = mujoco.MjvScene(scene, 1)
    geom = picture.geoms[0]
    geom.objtype, geom.objid, geom.segid = mujoco.mjtObj.mjOBJ_GEOM.value, 7, 9
    draw_furniture(picture, furniture_of(scene))
    assert picture.ngeom == 1
    assert (geom.objtype, geom.objid) == (mujoco.mjtObj.mjOBJ_UNKNOWN.value, -1)
    assert geom.segid == -1, "it has no colour in pictures of objects"


def test_floor_is_seen_beyond_the_persons_edge_of_the_table(
    rendering: str, scene: mujoco.MjModel
) -> None:
    """From the side, the lower right is below and behind the edge that is the person's."""
    data = mujoco.MjData(scene)
    mujoco.mj_forward(scene, data)
    frames = []
    with open_offscreen(160, 120) as offscreen:
        loaded = offscreen.add(scene)
        camera = Camera(scene, data, "side")
        for parts in (loaded._furniture, ()):
            loaded._furniture = parts
            frames.append(loaded.draw(data, camera.view).astype(int))
    different = (np.abs(frames[0] - frames[1]) > 15).any(axis=-1)
    assert 0.01 < different.mean() < 0.5
    rows, _ = np.nonzero(different)
    assert rows.min() > 50, "nothing above the table's top"
    assert (different[:, 100:].sum() / different.sum()) > 0.6, "at the person's side"

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.viewing.film.offscreen import (
    CAMERAS,
    FOLLOW_TIME_S,
    Camera,
    View,
    open_offscreen,
    parse_size,
)

HAND = """
<mujoco>
  <worldbody>
    <body name="palm"><freejoint/><geom size=".04"/>
      <body name="middle_proximal" pos=".094 0 0"><geom size=".01"/></body>
      <body name="index_proximal" pos=".09 {side} 0"><geom size=".01"/></body>
      <body name="little_proximal" pos=".08 -{side} 0"><geom size=".01"/></body>
    </body>
  </worldbody>
</mujoco>
"""


def started(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def hand(side: float = 0.03) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(HAND.format(side=side).replace("--", ""))


def test_frame_has_the_size_asked_for_and_shows_something(
    rendering: str, ball: mujoco.MjModel
) -> None:
    data = started(ball)
    with open_offscreen(100, 60) as offscreen:
        frame = offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view)
    assert frame.shape == (60, 100, 3)
    assert frame.dtype == np.uint8
    assert np.ptp(frame) > 50


def test_first_row_is_the_top(rendering: str, ball: mujoco.MjModel) -> None:
    data = started(ball)
    with open_offscreen(64, 64) as offscreen:
        frame = offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view)
    assert frame[:8].mean() < 5, "the sky, which this model leaves black"
    assert frame[-8:].mean() > 20, "the floor"


def test_scenes_on_one_stage_do_not_draw_over_each_other(
    rendering: str, ball: mujoco.MjModel
) -> None:
    other = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><light/><geom size=".4" rgba="1 0 0 1"/></worldbody></mujoco>'
    )
    alone, together = [], []
    for model in (ball, other):
        data = started(model)
        with open_offscreen(64, 48) as offscreen:
            alone.append(offscreen.add(model).draw(data, Camera(model, data, "view").view))
    with open_offscreen(64, 48) as offscreen:
        scenes = [offscreen.add(model) for model in (ball, other)]
        for scene in scenes:
            data = started(scene.model)
            together.append(scene.draw(data, Camera(scene.model, data, "view").view))
    for first, second in zip(alone, together, strict=True):
        np.testing.assert_array_equal(first, second)


def test_model_is_left_as_it_was(rendering: str, ball: mujoco.MjModel) -> None:
    before = (ball.vis.global_.offwidth, ball.vis.quality.shadowsize)
    with open_offscreen(1000, 60) as offscreen:
        offscreen.add(ball)
    assert (ball.vis.global_.offwidth, ball.vis.quality.shadowsize) == before


def test_shadows_only_where_asked_for_on_software(rendering: str, ball: mujoco.MjModel) -> None:
    data = started(ball)
    frames = []
    for shadows in (False, True):
        with open_offscreen(64, 64, shadows) as offscreen:
            frames.append(offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view))
    darker = frames[0].astype(int) - frames[1] > 20
    assert 0.01 < darker.any(axis=-1).mean() < 0.5, "the ball's shadow, and no more"


def test_unknown_camera_offers_the_nearest(ball: mujoco.MjModel) -> None:
    with pytest.raises(UnknownNameError, match="unknown camera 'fixt'; did you mean fixed"):
        Camera(ball, started(ball), "fixt")


def test_own_camera_is_used_where_the_model_has_it(ball: mujoco.MjModel) -> None:
    view = Camera(ball, started(ball), "fixed").view
    assert view.type == mujoco.mjtCamera.mjCAMERA_FIXED
    assert view.fixedcamid == ball.camera("fixed").id


@pytest.mark.parametrize("name", CAMERAS)
def test_cameras_look_at_the_hand_from_where_it_fits(name: str) -> None:
    model = hand()
    view = Camera(model, started(model), name).view
    np.testing.assert_allclose(view.lookat, [0.094, 0, 0], atol=1e-12)
    # The hand is 0.2 m long; 1.6 of that fits into a field of view of 45 degrees.
    assert view.distance == pytest.approx(0.16 / np.tan(np.pi / 8))


def test_moving_cameras_move_whatever_the_model_calls_its_own() -> None:
    text = HAND.format(side=0.03).replace("<worldbody>", '<worldbody><camera name="orbit"/>')
    model = mujoco.MjModel.from_xml_string(text)
    data = started(model)
    camera = Camera(model, data, "orbit")
    start = camera.view.azimuth
    camera.aim(model, data, 1.0)
    assert camera.view.azimuth != start


def test_views_are_mirrored_for_a_left_hand() -> None:
    right, left = (Camera(m, started(m), "side").view for m in (hand(0.03), hand(-0.03)))
    assert left.azimuth == pytest.approx(-right.azimuth)
    assert left.elevation == pytest.approx(right.elevation)


def test_orbit_turns_once_in_its_period() -> None:
    model = hand()
    data = started(model)
    camera = Camera(model, data, "orbit")
    start = camera.view.azimuth
    camera.aim(model, data, 2.0)
    assert camera.view.azimuth - start == pytest.approx(90.0)


def test_follow_comes_after_the_hand() -> None:
    model = hand()
    data = started(model)
    camera = Camera(model, data, "follow")
    camera.aim(model, data, 0.0)
    data.qpos[0] = 1.0
    mujoco.mj_forward(model, data)
    camera.aim(model, data, FOLLOW_TIME_S)
    assert camera.view.lookat[0] == pytest.approx(0.094 + 1 - np.exp(-1))


@pytest.mark.parametrize(
    ("width", "height", "fps"), [(8, 480, 30), (640, 5000, 30), (640, 480, 0.5), (640, 480, 1000)]
)
def test_view_out_of_limits(width: int, height: int, fps: float) -> None:
    with pytest.raises(InputError, match="give"):
        View(width=width, height=height, fps=fps)


def test_size_is_read() -> None:
    assert parse_size("640x480") == (640, 480)
    assert parse_size(" 32X16 ") == (32, 16)


@pytest.mark.parametrize("text", ["640", "640x", "x480", "640x480x3", "a x b", "-1x5", "1.5x2"])
def test_size_that_is_none(text: str) -> None:
    with pytest.raises(InputError, match="640x480"):
        parse_size(text)

import mujoco
import numpy as np
import pytest

from handsim.errors import UnknownNameError
from handsim.viewing.stage.camera import CAMERAS, FOLLOW_TIME_S, Camera

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

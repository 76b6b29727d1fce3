import mujoco
import numpy as np
import pytest

from handsim.types import Array
from handsim.viewing.stage.camera import Camera, standing_axes
from handsim.viewing.stage.framing import APART_M, Room, frame_movement

SCENE = """
<mujoco>
  <worldbody>
    <camera name="view" pos="1 1 .6" xyaxes="-1 1 0 -.2 -.2 .6"/>
    <body name="palm" pos="0 .4 .3"><joint name="reach" type="slide" axis="0 -1 -.5"/>
      <geom type="box" size=".05 .04 .02"/>
      <body name="index_proximal" pos=".09 0 0"><geom type="capsule" size=".01 .03"/></body>
    </body>
    <body name="object" pos="0 0 .1"><joint name="lift" type="slide" axis="0 0 1"/>
      <geom type="cylinder" size=".03 .08"/>
    </body>
  </worldbody>
</mujoco>
"""
ROOMS = [Room(), Room(0.24, 0.05, 0.97, 0.64), Room(0.0, 0.0, 0.5, 0.5)]


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(SCENE)


def grasp() -> tuple[Array, Array]:
    """The palm reaches the object within a second, then both rise."""
    time = np.linspace(0, 3, 61)
    rise = 0.3 * np.clip(time - 1.5, 0, 1)
    return time, np.column_stack([0.4 * np.clip(time, 0, 1) - rise, rise])


def seen_edges(model: mujoco.MjModel, camera: Camera, qpos: Array, aspect: float) -> Array:
    """Left, top, right and bottom of all parts, as shares of the picture."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    corners = []
    for geom in range(model.ngeom):
        middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        for sign in np.ndindex(2, 2, 2):
            local = middle + half * (2 * np.array(sign) - 1)
            corners.append(data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ local)
    axes = standing_axes(model, data, "view")
    eye = camera.view.lookat + camera.view.distance * axes[:, 2]
    x, y, z = ((np.array(corners) - eye) @ axes).T
    tangent = np.tan(np.deg2rad(model.vis.global_.fovy) / 2)
    across, down = 0.5 + 0.5 * x / -z / tangent / aspect, 0.5 - 0.5 * y / -z / tangent
    return np.array([across.min(), down.min(), across.max(), down.max()])


@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.parametrize("aspect", [4 / 3, 2.0, 0.7])
def test_hand_and_object_stay_in_the_room(model: mujoco.MjModel, room: Room, aspect: float) -> None:
    time, qpos = grasp()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = standing_axes(model, data, "view")
    framing = frame_movement(model, time, qpos, axes, aspect, room)
    assert framing is not None
    camera = Camera(model, data, "view", framing)
    assert np.abs(np.diff(framing.distance)).max() < 0.06, "it does not leap"
    fill = []
    for moment, state in zip(time, qpos, strict=True):
        camera.aim(model, data, float(moment))
        left, top, right, bottom = seen_edges(model, camera, state, aspect)
        assert left > room.left - 0.01
        assert top > room.top - 0.01
        assert right < room.right + 0.01
        assert bottom < room.bottom + 0.01
        fill.append(
            max(
                (right - left) / (room.right - room.left),
                (bottom - top) / (room.bottom - room.top),
            )
        )
    assert max(fill) > 0.85, "and fill it, as long as they are apart"


def test_the_camera_keeps_its_direction_and_the_horizon(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axes = standing_axes(model, data, "view")
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert axes[2, 0] == pytest.approx(0.0)
    framing = frame_movement(model, *grasp(), axes, 4 / 3, Room())
    view = Camera(model, data, "view", framing).view
    azimuth, elevation = np.deg2rad([view.azimuth, view.elevation])
    sight = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)]
    np.testing.assert_allclose([*sight, np.sin(elevation)], -axes[:, 2], atol=1e-9)


def test_a_fist_alone_does_not_fill_the_picture(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    time, qpos = np.arange(3.0), np.tile([0.0, APART_M + 1.0], (3, 1))  # the object is far away
    framing = frame_movement(model, time, qpos, standing_axes(model, data, "view"), 4 / 3, Room())
    assert framing is not None
    tangent = np.tan(np.deg2rad(model.vis.global_.fovy) / 2)
    np.testing.assert_allclose(2 * framing.distance * tangent, 0.24)
    assert framing.lookat[0, 2] == pytest.approx(0.3, abs=0.05), "it looks at the palm"


def test_nothing_to_frame() -> None:
    ball = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>"
    )
    assert frame_movement(ball, np.arange(2.0), np.zeros((2, 0)), np.eye(3), 1.0, Room()) is None

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.retargeting.robot_hand import RobotHand
from handsim.robot_hands.mounting import mount_robot_hand

from .hands import five_fingers, urdf

POS, QUAT = [0.1, 0.2, 0.5], [0.5, 0.5, 0.5, 0.5]


@pytest.fixture
def robot(tmp_path) -> RobotHand:
    path = tmp_path / "hand.urdf"
    path.write_text(urdf(five_fingers()))
    return RobotHand(path)


@pytest.mark.parametrize("body", ["", "arm"])
def test_the_palm_is_where_it_is_put_and_follows(robot, body):
    scene = mujoco.MjSpec()
    scene.option.gravity = [0, 0, 0]
    scene.worldbody.add_body(name="arm").add_geom(size=[0.01, 0, 0], contype=0, conaffinity=0)
    mount_robot_hand(scene, robot.spec, robot.frames.palm, POS, QUAT, body=body)
    model = scene.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    palm = robot.frames.palm
    carrier = data.body(f"robot_{palm.name}")
    place = carrier.xpos + carrier.xmat.reshape(3, 3) @ palm.pos
    np.testing.assert_allclose(place, POS, atol=1e-9)
    assert model.nu == len(robot.actuator_names)
    if body:
        return
    data.mocap_pos[0] = [0.1, 0.2, 0.6]
    data.ctrl[model.actuator("robot_index_1").id] = 1.0
    mujoco.mj_step(model, data, nstep=1000)
    np.testing.assert_allclose(data.body("robot_mount").xpos, [0.1, 0.2, 0.6], atol=0.005)
    index = data.joint("robot_index_1").qpos[0]
    assert index == pytest.approx(1.0, abs=0.05)
    assert data.joint("robot_index_2").qpos[0] == pytest.approx(1.05 * index, abs=0.05)


def test_the_scene_is_the_same_as_xml(robot):
    scene = mujoco.MjSpec()
    mount_robot_hand(scene, robot.spec, robot.frames.palm, POS, QUAT)
    model = scene.compile()
    again = mujoco.MjModel.from_xml_string(scene.to_xml())
    np.testing.assert_allclose(again.body_mass, model.body_mass)
    assert again.body("robot_mount").mass[0] > 0


def test_two_hands_need_two_prefixes_and_bodies_that_are_there(robot):
    scene = mujoco.MjSpec()
    mount_robot_hand(scene, robot.spec, robot.frames.palm)
    with pytest.raises(InputError, match="another prefix"):
        mount_robot_hand(scene, robot.spec, robot.frames.palm)
    mount_robot_hand(scene, robot.spec, robot.frames.palm, [0.5, 0, 0], prefix="left_")
    assert scene.compile().nmocap == 2
    with pytest.raises(UnknownNameError, match="forearm"):
        mount_robot_hand(scene, robot.spec, robot.frames.palm, body="forearm", prefix="x_")

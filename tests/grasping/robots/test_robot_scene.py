"""A scene with a robot hand: names as a person's, friction and weight, complete as XML."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from handsim.grasping._stored_model import trusted_xml
from handsim.grasping.conditions import Conditions
from handsim.grasping.robots.robot_scene import PREFIX, RobotScene
from handsim.grasping.rollout.compiled_scene import front_end
from handsim.grasping.rollout.sensing import Sensors
from handsim.hand.export import write_hand
from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.objects.catalogue import OBJECTS
from handsim.objects.mirror import mirrored
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.robot_hands.hand_frames import AttachedFrame, HandFrames
from handsim.tasks.lift import lift_task
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND

TASK, FREE = task_by_name("cube-raise"), Conditions(base="free")


def test_bodies_of_fingers_begin_with_their_names_and_others_do_not(scene):
    names = [scene.model.body(i).name for i in range(scene.model.nbody)]
    for finger in FINGERS:
        own = [name for name in names if name.startswith(f"{finger}_")]
        assert own and all(PREFIX in name for name in own)
    assert {"forearm", "palm", "forearm_target", "object"} <= set(names)
    assert f"{PREFIX}palm" in names  # no finger's


def test_a_missing_finger_is_a_body_of_nothing(three_fingers):
    scene = RobotScene.build(TASK, FREE, three_fingers)
    body = scene.model.body("little_missing")
    assert (body.mass[0], body.geomnum[0]) == (0.0, 0)
    assert scene.gripping == ["index", "middle"]
    values = scene.data.sensordata[None, Sensors(scene.model).first :]
    assert Sensors(scene.model).finger_forces(values) == [[0.0] * len(FINGERS)]


def test_a_grasp_without_any_of_the_fingers_takes_all(hand_file):
    pair = RobotHand(hand_file, "palm", {f: f"{f}_pad" for f in ("thumb", "little")})
    assert "little" not in TASK.grasp.fingers
    assert RobotScene.build(TASK, FREE, pair).gripping == ["little"]


def test_coordinates_and_actuators_are_found_in_the_scene(scene):
    robot = scene.robot
    names = [scene.model.joint(int(np.flatnonzero(scene.model.jnt_qposadr == at)[0])).name
             for at in scene.joint_index]  # fmt: skip
    assert names == [PREFIX + name for name in robot.joint_names]
    assert [scene.model.actuator(int(i)).name for i in scene.ctrl_index] == [
        PREFIX + name for name in robot.actuator_names
    ]
    for index, finger in zip(scene.fingers, robot.joint_names, strict=True):
        expected = finger.split("_")[0]
        assert index == (FINGERS.index(expected) if expected in FINGERS else -1)


def test_friction_is_that_of_the_conditions_torsion_in_proportion(robot):
    scene = RobotScene.build(TASK, replace(FREE, friction=0.4), robot)
    hand = scene.model.body_rootid == scene.model.body("forearm").id
    geoms = hand[scene.model.geom_bodyid]
    np.testing.assert_allclose(scene.model.geom_friction[geoms, 0], 0.4)
    np.testing.assert_allclose(scene.model.geom_friction[geoms, 1], 0.005)
    assert (scene.model.geom_condim[geoms] == 4).all()


def test_links_weigh_nothing_on_their_servos(scene):
    hand = scene.model.body_rootid == scene.model.body("forearm").id
    np.testing.assert_array_equal(scene.model.body_gravcomp[hand], 1.0)


def test_the_xml_needs_no_file_and_is_the_same_model(scene):
    text = scene.xml()
    model = mujoco.MjModel.from_xml_string(trusted_xml(text, {}))
    assert (model.nq, model.nv, model.nu) == (scene.model.nq, scene.model.nv, scene.model.nu)
    np.testing.assert_allclose(model.body_mass, scene.model.body_mass, atol=1e-9)
    np.testing.assert_allclose(model.geom_pos, scene.model.geom_pos, atol=1e-6)


def test_what_published_hands_consist_of_comes_without_a_warning_and_can_be_stored(hand_file):
    """Another solver, tendons of both kinds and their defaults, textures, all sorts of numbers."""
    spec = mujoco.MjSpec.from_file(str(hand_file))
    spec.option.iterations, spec.option.noslip_iterations = 7, 9
    spec.default.tendon.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    spec.default.tendon.range = [-9.0, 9.0]
    tendon = spec.add_tendon(name="fixed", armature=1e-6)
    tendon.wrap_joint("index_mcp", 1.0)
    spatial = spec.add_tendon(name="spatial", width=0.001, rgba=[1, 0, 0, 1])
    spatial.wrap_site("index_pad")
    spatial.wrap_site("middle_pad")
    spatial.wrap_pulley(2.0)
    spatial.wrap_site("ring_pad")
    spatial.wrap_site("little_pad")
    spec.add_texture(
        name="marked", type=mujoco.mjtTexture.mjTEXTURE_CUBE, width=8, height=8,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, mark=mujoco.mjtMark.mjMARK_CROSS,
    )  # fmt: skip
    shiny = spec.add_material(name="shiny", emission=0.5, metallic=0.5, roughness=0.5)
    shiny.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "marked"
    spec.joint("index_mcp").actgravcomp = True
    hand = RobotHand(spec, "palm", {finger: f"{finger}_pad" for finger in FINGERS})
    scene = RobotScene.build(TASK, FREE, hand)
    assert scene.model.opt.iterations not in (7, 9)
    model = mujoco.MjModel.from_xml_string(trusted_xml(scene.xml(), {}))
    assert (model.ntendon, model.nwrap) == (2, 6)


def test_the_parts_of_the_hand_are_told_apart_by_the_sensors(scene):
    parts = {CONTACT_PARTS[i] for i in Sensors(scene.model)._parts}
    assert parts == set(CONTACT_PARTS)


@pytest.fixture(scope="module")
def left(tmp_path_factory) -> RobotHand:
    file = write_hand(replace(MEDIAN_HAND, side="left"), tmp_path_factory.mktemp("left") / "hand")
    tips = {finger: AttachedFrame(f"{finger}_pad") for finger in FINGERS}
    return RobotHand(file, frames=HandFrames(AttachedFrame("palm"), tips, side="left"))


def test_a_left_robot_meets_the_mirror_image_of_what_is_handed(left):
    """And that is what is told of the scene."""
    task = task_by_name("scissors-use")
    scene = RobotScene.build(task, FREE, left)
    assert scene.object == scene.task.object == mirrored(task.object) != task.object
    np.testing.assert_array_equal(scene.front, front_end(mirrored(task.object)))
    assert not np.allclose(scene.front, front_end(task.object))


def test_a_left_robot_meets_own_objects_as_they_are(left):
    own, grasp = OBJECTS["hammer"], task_by_name("hammer-use").grasp
    scene = RobotScene.build(lift_task(own, grasp, side="left"), FREE, left)
    assert scene.object == own and scene.task.grasp == grasp
    turned_over = RobotScene.build(lift_task(own, grasp), FREE, left)  # for a right hand: mirrored
    there, mirror = scene.model.body("object").ipos, turned_over.model.body("object").ipos
    assert there[1] == pytest.approx(-mirror[1]) and there[1] < -0.001  # its face is at -y


TWICE = """<mujoco><compiler angle="radian"/><default><joint axis="0 1 0" range="0 1.6"/></default>
<worldbody><body name="palm"><geom type="box" size=".04 .04 .01"/>
<body name="index" pos=".09 .02 0"><joint name="i1"/><joint name="i2"/><geom type="capsule"
fromto="0 0 0 .04 0 0" size=".007"/></body><body name="thumb" pos=".02 .05 0"><joint name="t1"/>
<geom type="capsule" fromto="0 0 0 .04 0 0" size=".007"/></body></body></worldbody>
<tendon><fixed name="t"><joint joint="i1" coef="1"/><joint joint="i2" coef="1"/></fixed></tendon>
<actuator><position joint="t1" kp="1" ctrlrange="0 1.6"/>
<position tendon="t" kp="1" ctrlrange="0 3"/></actuator></mujoco>"""
"""A finger with two hinges in one place, whose inertia matrix is all but singular."""


def test_what_mujoco_thinks_of_a_users_hand_is_not_said_again(tmp_path, grasps, plan):
    """Python's warnings are errors in tests; on a terminal they would be lines of source."""
    file = tmp_path / "hand.xml"
    file.write_text(TWICE)
    with pytest.warns(UserWarning, match="too close to singular"):
        mujoco.MjSpec.from_file(str(file)).compile()
    robot = RobotHand(file)
    scene = RobotScene.build(TASK, FREE, robot)
    run = replace(grasps, retargeter=Retargeter(robot)).run(scene, plan)
    assert run.model().nq == scene.model.nq

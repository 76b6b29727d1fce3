from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.grasping.plan import Pose
from handsim.grasping.planning.opposition import (
    Opposition,
    align_palm,
    close_to_width,
    opposition,
    palm_pose,
)
from handsim.grasping.planning.preshapes import PRESHAPES
from handsim.grasping.rollout.forearm import Wrist
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, JOINT_INDEX, LOWER, UPPER
from handsim.tasks.table_one import task_by_name

TASKS = ("tall-glass-drink", "tall-glass-top-move", "cube-raise", "jar-move")


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


@pytest.mark.parametrize("name", TASKS)
def test_the_hand_closes_to_the_width_of_the_object(hand, name):
    grasp = task_by_name(name).grasp
    preshape = PRESHAPES[grasp.kind]
    q = close_to_width(hand, preshape.open, preshape.shut, grasp)
    assert opposition(hand, q, grasp).gap == pytest.approx(grasp.width, abs=1e-4)


@pytest.mark.parametrize("name", TASKS)
def test_alignment_lays_the_pads_on_the_grasp(hand, name):
    grasp = task_by_name(name).grasp
    preshape = PRESHAPES[grasp.kind]
    q = close_to_width(hand, preshape.open, preshape.shut, grasp)
    palm = align_palm(opposition(hand, q, grasp), grasp)
    hand.set_posture(q)
    here = palm_pose(hand)
    pads = palm.pos + palm.rotation.apply(here.rotation.inv().apply(hand.pads()[0] - here.pos))
    thumb = pads[0]
    fingers = pads[[FINGERS.index(finger) for finger in grasp.fingers]].mean(axis=0)
    np.testing.assert_allclose((thumb + fingers) / 2, grasp.point, atol=1e-9)
    facing = palm.rotation.apply([0, 0, -1.0])
    if grasp.kind == "side":
        np.testing.assert_allclose(facing, grasp.approach, atol=1e-9)
        np.testing.assert_allclose(palm.rotation.apply([0, 1.0, 0]), [0, 0, 1.0], atol=1e-9)
    else:
        axis = (fingers - thumb) / np.linalg.norm(fingers - thumb)
        np.testing.assert_allclose(axis, grasp.opposition, atol=1e-9)
        assert facing @ np.array(grasp.approach) > 0.5


@pytest.mark.parametrize("angles", [(0, 0), (30, 0), (0, -20), (-40, 15)])
def test_the_forearm_gives_way_to_the_wrist(hand, angles):
    q = np.zeros(22)
    q[JOINT_INDEX["wrist_flexion"]], q[JOINT_INDEX["wrist_deviation"]] = np.deg2rad(angles)
    wanted = Pose(
        np.array([0.1, -0.2, 0.3]),
        Rotation.from_euler("xyz", [20, -30, 40], degrees=True).as_quat(scalar_first=True),
    )
    base = Pose(*Wrist(hand.model).forearm(wanted.pos, wanted.quat, q))
    hand.set_posture(q)
    palm = palm_pose(hand)  # with the forearm at the world's origin
    reached = base @ palm
    np.testing.assert_allclose(reached.pos, wanted.pos, atol=1e-9)
    np.testing.assert_allclose(reached.rotation.as_matrix(), wanted.rotation.as_matrix(), atol=1e-9)


def test_widths_beyond_reach_give_the_nearer_end(hand):
    grasp = task_by_name("cube-raise").grasp
    preshape = PRESHAPES[grasp.kind]
    wide = close_to_width(hand, preshape.open, preshape.shut, replace(grasp, width=0.5))
    np.testing.assert_allclose(wide, preshape.open)


def test_an_opposition_is_that_of_the_pads_in_the_palm(hand):
    """Whatever the wrist does, and by the fingers that the grasp has alone."""
    q = PRESHAPES["top"].shut.copy()
    q[JOINT_INDEX["wrist_flexion"]], q[JOINT_INDEX["wrist_deviation"]] = 0.5, -0.3
    grasp = replace(task_by_name("cube-raise").grasp, fingers=("index", "ring"))
    opposed = opposition(hand, q, grasp)
    palm, pads = palm_pose(hand), hand.pads()[0]
    fingers = (pads[1] + pads[3]) / 2
    middle = palm.pos + palm.rotation.apply(opposed.midpoint)
    np.testing.assert_allclose(middle, (pads[0] + fingers) / 2, atol=1e-12)
    np.testing.assert_allclose(
        opposed.gap * palm.rotation.apply(opposed.axis), fingers - pads[0], atol=1e-12
    )
    assert np.linalg.norm(opposed.axis) == pytest.approx(1.0)
    assert np.linalg.norm(opposed.facing) == pytest.approx(1.0)
    assert opposed.facing @ opposed.axis == pytest.approx(0.0, abs=1e-12)
    # The palm looks along its -z, as far as that is across the axis.
    assert opposed.facing[2] < -0.5
    np.testing.assert_allclose(np.cross([0, 0, 1], opposed.axis) @ opposed.facing, 0, atol=1e-12)


def test_thin_things_are_opposed_between_pads_and_tips(hand):
    grasp = task_by_name("pen-move").grasp
    q = PRESHAPES["top"].shut
    pads = opposition(hand, q, replace(grasp, width=0.0151))
    pinched = opposition(hand, q, replace(grasp, width=0.015))
    palm = palm_pose(hand)
    between = []
    for i, finger in enumerate(FINGERS):
        centre = hand.data.geom(f"{finger}_distal_geom").xpos
        pad, tip = hand.pads()[0][i] - centre, hand.fingertips()[i] - centre
        between.append(centre + (pad + tip) * np.sqrt(0.5))
    used = [FINGERS.index(finger) for finger in grasp.fingers]
    fingers = np.array(between)[used].mean(axis=0)
    middle = palm.pos + palm.rotation.apply(pinched.midpoint)
    np.testing.assert_allclose(middle, (between[0] + fingers) / 2, atol=1e-12)
    middle = palm.pos + palm.rotation.apply(pads.midpoint)
    fingers = hand.pads()[0][used].mean(axis=0)
    np.testing.assert_allclose(middle, (hand.pads()[0][0] + fingers) / 2, atol=1e-12)


def test_a_palm_is_turned_from_its_own_axes_to_the_grasps():
    """Closed form: a hand that opposes along its y and faces along its -z."""
    grasp = replace(
        task_by_name("cube-raise").grasp,
        point=(0.1, 0.2, 0.3),
        opposition=(2.0, 0.0, 0.0),
        approach=(0.4, 0.0, -1.0),
    )
    opposed = Opposition(
        np.array([0.01, 0.02, 0.03]), np.array([0, 1.0, 0]), 0.05, np.array([0, 0, -1.0])
    )
    palm = align_palm(opposed, grasp)
    turn = palm.rotation
    np.testing.assert_allclose(turn.apply([0, 1, 0]), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(turn.apply([0, 0, -1]), [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(turn.apply([1, 0, 0]), [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(palm.pos + turn.apply(opposed.midpoint), grasp.point, atol=1e-12)


def test_a_hand_that_rests_stays_level():
    grasp = task_by_name("mouse-slide").grasp
    opposed = Opposition(np.zeros(3), np.array([0, 0.6, 0.8]), 0.05, np.array([0, 0.8, -0.6]))
    palm = align_palm(opposed, grasp)
    np.testing.assert_allclose(palm.rotation.apply([0, 0, -1]), grasp.approach, atol=1e-3)
    np.testing.assert_allclose(palm.pos, grasp.point, atol=1e-12)


def test_closing_stops_on_the_way_and_within_the_ranges(hand):
    """At a width in between the posture lies on the line from open to shut."""
    grasp = task_by_name("cube-raise").grasp
    preshape = PRESHAPES[grasp.kind]
    q = close_to_width(hand, preshape.open, preshape.shut, grasp)
    way = preshape.shut - preshape.open
    part = (q - preshape.open) @ way / (way @ way)
    assert 0.05 < part < 0.95
    np.testing.assert_allclose(q, preshape.open + part * way, atol=1e-12)
    shut = close_to_width(hand, preshape.open, preshape.shut, replace(grasp, width=1e-3))
    np.testing.assert_allclose(shut, preshape.shut)
    far = preshape.shut + np.where(way > 0, 3.0, 0.0)
    beyond = close_to_width(hand, far, far, replace(grasp, width=-1.0))
    np.testing.assert_array_equal(beyond, np.clip(far, LOWER, UPPER))
    beyond = close_to_width(hand, far, far, replace(grasp, width=1.0))
    np.testing.assert_array_equal(beyond, np.clip(far, LOWER, UPPER))


def test_many_forearms_give_way_to_the_wrist_as_one(hand):
    wrist, generator = Wrist(hand.model), np.random.default_rng(3)
    pos, quat = generator.normal(size=(20, 3)), generator.normal(size=(20, 4))
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    q = generator.uniform(LOWER, UPPER, (20, 22))
    for place, turn, *given in zip(*wrist.forearms(pos, quat, q), pos, quat, q, strict=True):
        palm, orientation, posture = given
        hand.set_posture(posture)
        reached = Pose(place, turn) @ palm_pose(hand)
        wanted = Pose(palm, orientation)
        np.testing.assert_allclose(reached.pos, wanted.pos, atol=1e-9)
        np.testing.assert_allclose(
            reached.rotation.as_matrix(), wanted.rotation.as_matrix(), atol=1e-9
        )


def test_forearms_give_way_to_a_wrist_that_is_not_at_their_end():
    """As in an arm whose palm is mounted askew and away from the forearm's origin."""
    model = mujoco.MjModel.from_xml_string(
        """
        <mujoco>
          <worldbody>
            <body name="forearm">
              <freejoint name="forearm"/>
              <geom size="0.01"/>
              <body name="palm" pos="0.05 0.02 -0.03" quat="0.8 0 0.6 0">
                <joint name="wrist_flexion" axis="0 1 0"/>
                <joint name="wrist_deviation" axis="0 0 1"/>
                <geom size="0.01"/>
              </body>
            </body>
          </worldbody>
        </mujoco>
        """
    )
    data, wrist, generator = mujoco.MjData(model), Wrist(model), np.random.default_rng(1)
    pos, quat = generator.normal(size=(10, 3)), generator.normal(size=(10, 4))
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    q = generator.uniform(LOWER, UPPER, (10, 22))
    many = wrist.forearms(pos, quat, q)
    for i in range(10):
        for forearm in (wrist.forearm(pos[i], quat[i], q[i]), (many[0][i], many[1][i])):
            data.qpos[:3], data.qpos[3:7] = forearm
            data.qpos[7:] = [q[i, JOINT_INDEX[f"wrist_{way}"]] for way in ("flexion", "deviation")]
            mujoco.mj_kinematics(model, data)
            np.testing.assert_allclose(data.body("palm").xpos, pos[i], atol=1e-12)
            assert abs(data.body("palm").xquat @ quat[i]) == pytest.approx(1.0)

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.hand.model import HandModel, build_hand
from handsim.hand.tasks import task_by_name
from handsim.joints import FINGERS, JOINT_INDEX
from handsim.simulation.alignment import (
    Wrist,
    align_palm,
    close_to_width,
    opposition,
    palm_pose,
)
from handsim.simulation.closings import CLOSINGS
from handsim.simulation.plan import Pose

TASKS = ("tall-glass-drink", "tall-glass-top-move", "cube-raise", "jar-move")


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


@pytest.mark.parametrize("name", TASKS)
def test_the_hand_closes_to_the_width_of_the_object(hand, name):
    grasp = task_by_name(name).grasp
    closing = CLOSINGS[grasp.kind]
    q = close_to_width(hand, closing.open, closing.shut, grasp)
    assert opposition(hand, q, grasp).gap == pytest.approx(grasp.width, abs=1e-4)


@pytest.mark.parametrize("name", TASKS)
def test_alignment_lays_the_pads_on_the_grasp(hand, name):
    grasp = task_by_name(name).grasp
    closing = CLOSINGS[grasp.kind]
    q = close_to_width(hand, closing.open, closing.shut, grasp)
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
    from dataclasses import replace

    grasp = task_by_name("cube-raise").grasp
    closing = CLOSINGS[grasp.kind]
    wide = close_to_width(hand, closing.open, closing.shut, replace(grasp, width=0.5))
    np.testing.assert_allclose(wide, closing.open)

import numpy as np
import pytest

from handsim.grasping.gripping.squeeze import PAD, closing, squeeze_offset
from handsim.grasping.plan import ramp
from handsim.grasping.planning.preshapes import REST
from handsim.hand.anthropometry import LENGTHS
from handsim.hand.kinematics import Kinematics
from handsim.joints import FINGERS, JOINT_NAMES, JOINTS
from handsim.types import HandSize


def named(offset):
    """The joints that are squeezed, and by how much [deg]."""
    return {
        name: round(float(degrees), 9)
        for name, degrees in zip(JOINT_NAMES, np.rad2deg(offset), strict=True)
        if degrees
    }


def test_the_thumb_squeezes_whatever_else_does():
    thumb = {"thumb_mcp": 10.0, "thumb_ip": 12.0}
    assert named(squeeze_offset(1.0, ())) == thumb
    index = {"index_mcp": 12.0, "index_pip": 10.0, "index_dip": 5.0}
    assert named(squeeze_offset(1.0, ("index",))) == thumb | index


@pytest.mark.parametrize("finger", FINGERS[1:])
def test_each_finger_squeezes_when_it_opposes_and_otherwise_not(finger):
    squeezed = {name.split("_")[0] for name in named(squeeze_offset(1.0, (finger,)))}
    assert squeezed == {"thumb", finger}


def test_all_fingers_squeeze_unless_told_otherwise():
    np.testing.assert_array_equal(squeeze_offset(), squeeze_offset(1.0, FINGERS))
    assert len(named(squeeze_offset())) == 14  # the flexions of the hand without the wrist


def test_a_squeeze_flexes_in_proportion_to_its_strength():
    offset = squeeze_offset(1.0, ("middle", "ring"))
    assert (offset >= 0).all()
    np.testing.assert_allclose(squeeze_offset(0.3, ("middle", "ring")), 0.3 * offset)
    assert not squeeze_offset(0.0).any()


HAND = Kinematics(HandSize())
OF_THUMB = np.array([joint.finger == "thumb" for joint in JOINTS])
BENT = REST.copy()
BENT[JOINT_NAMES.index("wrist_flexion")] = 0.9


def pad_in_palm(q):
    """The middle of the thumb's pad in the palm's frame, (3,) [m]."""
    frames, palm = HAND.frames(q[None]), HAND.names.index("palm")
    tip = HAND.names.index("thumb_distal")
    along = np.array([PAD * LENGTHS["thumb"][2] * HAND.size.length, 0.0, 0.0])
    where = frames.position[0, tip] + frames.rotation[0, tip] @ along
    return frames.rotation[0, palm].T @ (where - frames.position[0, palm])


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 1, 0), (0, 0, -1), (-0.6, 0.0, 0.8)])
def test_the_thumb_closes_along_the_gradient_of_its_pads_way_to_the_fingers(way):
    offset = closing(BENT, np.array(way, dtype=float), ("index",), 0.5, HAND)
    columns, tiny = np.flatnonzero(OF_THUMB), 1e-6
    slopes = []
    for column in columns:
        step = np.zeros(22)
        step[column] = tiny
        slopes.append((pad_in_palm(BENT + step) - pad_in_palm(BENT - step)) @ way / (2 * tiny))
    expected = np.array(slopes) / np.abs(slopes).max() * np.deg2rad(6.0)
    np.testing.assert_allclose(offset[columns], expected, atol=1e-6)


def test_the_other_fingers_close_as_they_squeeze():
    offset = closing(BENT, np.array([1.0, 0.0, 0.0]), ("index", "ring"), 0.7, HAND)
    squeezed = squeeze_offset(0.7, ("index", "ring"))
    np.testing.assert_array_equal(offset[~OF_THUMB], squeezed[~OF_THUMB])


def test_a_ramp_goes_from_zero_to_one_by_minimum_jerk():
    times = np.array([-1.0, 0.0, 1.2, 1.325, 1.45, 1.575, 1.7, 3.0])
    # 10 x^3 - 15 x^4 + 6 x^5 at a quarter, half and three quarters.
    expected = [0, 0, 0, 53 / 512, 0.5, 459 / 512, 1, 1]
    np.testing.assert_allclose(ramp(times, 1.2, 0.5), expected, atol=1e-12)
    assert ramp(1, 0, 2) == pytest.approx(0.5)  # also of whole numbers

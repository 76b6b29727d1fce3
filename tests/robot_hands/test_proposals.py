"""Palm and fingertips are proposed from names where there are any, and from the tree."""

import re
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, UnknownNameError
from handsim.retargeting.robot_hand import RobotHand
from handsim.robot_hands.hand_frames import frames_as_toml, read_frames
from handsim.robot_hands.presets import recognise

from .hands import Joint, finger, five_fingers, thumb, urdf

DATA = Path(__file__).parents[3] / "shared/data/robot_hands"


def hand(folder: Path, joints: list[Joint]) -> RobotHand:
    path = folder / "hand.urdf"
    path.write_text(urdf(joints))
    return RobotHand(path)


def nameless(joints: list[Joint]) -> list[Joint]:
    """The same with links and joints called by numbers."""
    names = sorted({name for j in joints for name in (j.name, j.child)})
    called = {name: f"part{i}" for i, name in enumerate(names)}
    return [
        Joint(
            called[j.name], called.get(j.parent, j.parent), called[j.child], j.xyz, j.rpy, j.axis,
            j.limits, (called[j.mimic[0]], *j.mimic[1:]) if j.mimic else None, j.length, j.kind,
        )
        for j in joints
    ]  # fmt: skip


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("named", [True, False])
def test_five_fingers_are_found_with_their_side(tmp_path, side, named):
    joints = five_fingers(side)
    robot = hand(tmp_path, joints if named else nameless(joints))
    assert robot.side == ("right" if side > 0 else "left")
    assert robot.fingers == ("thumb", "index", "middle", "ring", "little")
    tips = robot.forward(robot.reference)
    ends = [-0.03 * side, -0.01 * side, 0.01 * side, 0.03 * side]
    across = tips.points[1:, 1] - tips.points[1:, 1].mean()
    np.testing.assert_allclose(across, -np.array(ends), atol=1e-6)
    np.testing.assert_allclose(tips.directions[1:], np.tile([1.0, 0, 0], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(tips.backs[1:], np.tile([0, 0, 1.0], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(robot.reach[1:], 0.05 + np.hypot(0.033, 0.007), atol=1e-6)


def test_pads_are_on_the_palmar_surface_before_the_end(tmp_path):
    robot = hand(tmp_path, five_fingers())
    frame = robot.frames.fingertips["index"]
    assert frame.name == "index_distal"
    np.testing.assert_allclose(frame.pos, [0.04 - 0.007, 0.0, -0.007], atol=1e-6)


def test_the_palm_is_where_a_person_of_these_fingers_had_it(tmp_path):
    """So that a straight robot finger and a person's are at the same place, but for the scale."""
    from handsim.retargeting.person import Person
    from handsim.types import MEDIAN_HAND

    robot = hand(tmp_path, five_fingers())
    person = Person(robot, MEDIAN_HAND, None, 0.5)
    apart = robot.roots[1:].mean(axis=0) - person.scale * person.hand.roots[1:].mean(axis=0)
    assert np.abs(apart).max() < 0.004


def test_three_fingers_without_a_name_have_a_thumb(tmp_path):
    joints = thumb("a") + finger("b", 0.02) + finger("c", -0.02)
    robot = hand(tmp_path, nameless(joints))
    assert robot.fingers == ("thumb", "index", "middle")
    assert robot.side == "right"
    assert robot.model.joint(int(robot.joint_ids[0])).name is not None


def test_an_extra_joint_in_the_palm_is_no_knuckle(tmp_path):
    joints = [j for j in five_fingers() if not j.child.startswith("pinky")]
    joints += [
        Joint("hollow", "base", "metacarpal", (0.03, -0.02, 0.0), axis=(1, 0, 0), length=0.03)
    ]
    joints += [
        Joint(j.name, "metacarpal" if j.parent == "base" else j.parent, j.child,
              (0.06, -0.01, 0.0) if j.parent == "base" else j.xyz, j.rpy, j.axis, j.limits, j.mimic,
              j.length, j.kind)
        for j in finger("pinky", 0.0)
    ]  # fmt: skip
    robot = hand(tmp_path, joints)
    assert dict(robot.frames.knuckles) == {"little": "pinky_1"}
    assert robot.reach[-1] == pytest.approx(robot.reach[1], abs=0.003)


def test_frames_are_written_read_and_corrected(tmp_path):
    robot = hand(tmp_path, five_fingers())
    text = frames_as_toml(robot.frames)
    (tmp_path / "map.toml").write_text(text)
    again = read_frames(tmp_path / "map.toml")
    assert again.side == "right" and list(again.fingertips) == list(robot.frames.fingertips)
    np.testing.assert_allclose(again.palm.pos, robot.frames.palm.pos, atol=1e-5)
    moved = re.sub(
        r'on = "index_distal"\npos = \[[^]]*\]', 'on = "index_tip"\npos = [0, 0, 0]', text
    )
    (tmp_path / "hand.toml").write_text(moved)
    corrected = RobotHand(tmp_path / "hand.urdf")
    assert corrected.frames.fingertips["index"].name == "index_tip", "it is beside the hand"
    assert "hand.toml" in corrected.notes[-1]
    assert corrected.pads_are_known


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("side = 'up'", UnknownNameError),
        ("tips = 1", UnknownNameError),
        ("[palm]\non = 'a'", FileError),
        ("[palm]\non = 'a'\n[fingertips.tail]\non = 'b'", UnknownNameError),
        ("[palm]\non = 1\n[fingertips.index]\non = 'b'", FileError),
        ("[palm]\non = 'a'\npos = [1, 2, nan]\n[fingertips.index]\non = 'b'", FileError),
        ("[palm]\non = 'a'\nquat = [2, 0, 0, 0]\n[fingertips.index]\non = 'b'", FileError),
        ("palm", FileError),
        ("\0", FileError),
    ],
)
def test_a_map_that_is_none_is_refused_in_one_line(tmp_path, text, error):
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(error) as raised:
        read_frames(tmp_path / "map.toml")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("bodies", "joints", "name"),
    [
        (["rh_palm", *(f"rh_{f}distal" for f in ("ff", "mf", "rf", "lf", "th"))],
         ["rh_LFJ5", "rh_LFJ4", "rh_FFJ4"], "Shadow"),
        (["palm", *(f"{f}distal" for f in ("ff", "mf", "rf", "lf", "th"))],
         ["LFJ4", "LFJ3", "FFJ0"], "Shadow or Adroit"),
        (["robot0:palm", *(f"robot0:{f}distal" for f in ("ff", "mf", "rf", "lf", "th"))],
         ["robot0:LFJ4", "robot0:LFJ3", "robot0:FFJ0"], "Shadow or Adroit"),
        (["base_link", "link_3.0_tip", "link_7.0_tip", "link_11.0_tip", "link_15.0_tip"], [],
         "Allegro"),
        (["palm_lower", "fingertip", "fingertip_2", "fingertip_3", "thumb_fingertip"], [], "LEAP"),
        (["base", *(f"{f}_L2" for f in ("thumb", "index", "middle", "ring", "pinky"))], [],
         "Ability"),
        (["L_hand_base_link", "L_thumb_distal",
          *(f"L_{f}_intermediate" for f in ("index", "middle", "ring", "pinky"))], [], "Inspire"),
        (["left_hand_e1", *(f"left_hand_{f}" for f in "ctsrq")], ["left_hand_Thumb_Opposition"],
         "SVH"),
        (["base_link", "finger_1_dist_link", "finger_2_dist_link", "finger_3_dist_link"], [],
         "Barrett"),
        (["bh_base_link", "bh_finger_13_link", "bh_finger_23_link", "bh_finger_33_link"], [],
         "Barrett"),
    ],
)  # fmt: skip
def test_published_hands_are_recognised_by_their_link_names(bodies, joints, name):
    found = recognise(["world", *bodies], joints)
    assert found is not None and found.hand == name
    assert found.palm in bodies
    assert set(found.fingertips.values()) <= set(bodies)
    assert recognise(bodies[:-1], joints) is None


@pytest.mark.parametrize(
    ("bodies", "joints", "left_out"),
    [
        (["palm", *(f"{f}_tip" for f in ("ff", "mf", "rf", "th"))], [], "R_lf_tip"),
        (["palm", *(f"rh_{f}distal" for f in ("ff", "mf", "rf", "th"))], [], "rh_lfdistal"),
    ],
)
def test_a_hand_of_four_fingers_is_not_seen_in_one_of_five(bodies, joints, left_out):
    assert recognise(bodies, joints) is not None
    assert recognise([*bodies, left_out], joints) is None


@pytest.mark.real_data
@pytest.mark.skipif(not DATA.is_dir(), reason="the robot hands are not beside the checkout")
@pytest.mark.parametrize(
    ("file", "fingers", "side", "coordinates"),
    [
        ("shadow_hand/right_hand.xml", 5, "right", 18),
        ("shadow_hand/left_hand.xml", 5, "left", 18),
        ("shadow_hand/scene_right.xml", 5, "right", 18),
        ("wonik_allegro/right_hand.xml", 4, "right", 16),
        ("wonik_allegro/left_hand.xml", 4, "left", 16),
        ("allegro_urdf/allegro_hand_right.urdf", 4, "right", 16),
        ("leap_hand/leap_hand_right.urdf", 4, "right", 16),
    ],
)
def test_published_hands_are_read_with_their_frames(file, fingers, side, coordinates):
    robot = RobotHand(DATA / file)
    assert (len(robot.fingers), robot.side, len(robot.lower)) == (fingers, side, coordinates)
    tips = robot.forward(np.clip(robot.reference, robot.lower, robot.upper))
    assert (tips.directions[1:, 0] > 0.99).all(), "fingers point away from the wrist"
    assert (tips.backs[1:, 2] > 0.99).all(), "their backs are the hand's"
    right = 1 if side == "right" else -1
    assert right * tips.points[0, 1] > right * tips.points[1, 1], "the thumb is beside the index"
    assert (np.diff(right * tips.points[1:, 1]) < -0.015).all(), "index to little"

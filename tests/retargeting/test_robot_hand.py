from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.hand.anthropometry import LENGTHS, HandGeometry
from handsim.hand.mjcf import build_hand
from handsim.joints import FINGERS
from handsim.retargeting.retarget import human_hand
from handsim.retargeting.robot_hand import AttachedFrame, RobotHand
from handsim.types import HandSize

FOUR_FINGERS = Path(__file__).parent / "data" / "four_finger_hand.xml"
TIPS = {"thumb": "thumb_touch", "index": "f1_touch", "middle": "f2_touch", "ring": "f3_touch"}

# One finger of two links, 40 and 30 mm, that bends towards -z.
FINGER = """
<mujoco>
  <worldbody>
    <body name="wrist">
      <joint name="wrist" axis="0 0 1"/>
      <geom size="0.01" mass="0.1"/>
      <body name="palm">
        <geom size="0.01"/>
        <body name="first" pos="0.1 0 0">
          <joint name="knuckle" axis="0 1 0" range="0 90"/>
          <geom size="0.01"/>
          <body name="second" pos="0.04 0 0">
            <joint name="middle" axis="0 1 0" range="0 100"/>
            <geom size="0.01"/>
            {more}
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality>{equality}</equality>
</mujoco>
"""
SLIDE = """<body name="third" pos="0.02 0 0"><joint name="end" type="slide" axis="1 0 0"/>
           <geom size="0.01"/></body>"""
FOLLOW = '<joint joint1="middle" joint2="knuckle" polycoef="0.1 0.5 0.2 0 0"/>'


def finger(more: str = "", equality: str = "", end: str = "second") -> RobotHand:
    spec = mujoco.MjSpec.from_string(FINGER.format(more=more, equality=equality))
    return RobotHand(spec, "palm", {"index": AttachedFrame(end, pos=(0.03, 0.0, 0.0))})


def four_fingers() -> RobotHand:
    return RobotHand(FOUR_FINGERS, "base_frame", TIPS)


def test_two_links_are_where_the_closed_form_has_them():
    robot = finger()
    assert robot.joint_names == ("knuckle", "middle"), "the wrist is not between palm and tip"
    assert np.allclose(robot.lower, 0)
    assert np.allclose(robot.upper, np.deg2rad([90, 100]))
    assert np.allclose(robot.roots, [[0.1, 0, 0]])
    assert np.allclose(robot.reach, 0.07)
    a, b = 0.5, 0.8
    tips = robot.forward(np.array([a, b]))
    x = 0.1 + 0.04 * np.cos(a) + 0.03 * np.cos(a + b)
    z = -0.04 * np.sin(a) - 0.03 * np.sin(a + b)
    assert np.allclose(tips.points, [[x, 0, z]], atol=1e-12)
    assert np.allclose(tips.directions, [[np.cos(a + b), 0, -np.sin(a + b)]], atol=1e-12)


def test_joint_that_follows_another_is_no_coordinate():
    robot = finger(equality=FOLLOW)
    assert robot.joint_names == ("knuckle", "middle")
    assert robot.lower.shape == (1,)
    assert np.allclose(robot.joint_positions(np.array([[0.4]])), [[0.4, 0.1 + 0.2 + 0.2 * 0.16]])


def test_chain_of_followers_is_followed_to_its_end():
    chain = FOLLOW + '<joint joint1="end" joint2="middle" polycoef="0 0.01 0 0 0"/>'
    robot = finger(SLIDE, chain, end="third")
    middle = 0.1 + 0.5 * 0.4 + 0.2 * 0.16
    assert np.allclose(robot.joint_positions(np.array([0.4])), [0.4, middle, 0.01 * middle])
    locked = finger(SLIDE, '<joint joint1="middle" polycoef="0.3 0 0 0 0"/>', end="third")
    assert np.allclose(locked.joint_positions(np.array([0.4, 0.01])), [0.4, 0.3, 0.01])


@pytest.mark.parametrize(
    "robot",
    [
        finger(SLIDE, end="third"),
        finger(equality=FOLLOW),
        finger(
            SLIDE,
            FOLLOW + '<joint joint1="end" joint2="middle" polycoef="0 .01 .1 0 0"/>',
            end="third",
        ),
        four_fingers(),
        human_hand(HandSize(side="left")),
    ],
    ids=["slide", "follows", "chain", "four-fingers", "human"],
)
def test_jacobians_are_the_slopes_of_points_and_directions(robot):
    rng = np.random.default_rng(5)
    for _ in range(3):
        x = robot.lower + rng.uniform(0.1, 0.9, len(robot.lower)) * (robot.upper - robot.lower)
        assert np.all((x > robot.lower) & (x < robot.upper))
        tips = robot.forward(x)
        for i, step in enumerate(1e-6 * np.eye(len(x))):
            ahead, behind = robot.forward(x + step), robot.forward(x - step)
            slope = (ahead.points - behind.points) / 2e-6
            assert np.allclose(tips.d_points[:, :, i], slope, atol=1e-8)
            slope = (ahead.directions - behind.directions) / 2e-6
            assert np.allclose(tips.d_directions[:, :, i], slope, atol=1e-8)


def test_fingertips_stay_in_the_palms_frame_wherever_the_hand_is():
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    spec.body("mount").pos = [0.3, -0.2, 0.5]
    spec.body("mount").quat = [0.5, 0.5, -0.5, 0.5]
    moved, robot = RobotHand(spec, "base_frame", TIPS), four_fingers()
    assert "mount_roll" not in robot.joint_names
    x = 0.3 * robot.lower + 0.7 * robot.upper
    assert np.allclose(moved.forward(x).points, robot.forward(x).points, atol=1e-12)
    assert np.allclose(moved.roots, robot.roots, atol=1e-12)
    pos, axes = moved.palm_pose()
    assert np.allclose(pos, [0.3, -0.2, 0.5])
    turn = Rotation.from_quat([0.5, 0.5, -0.5, 0.5], scalar_first=True)
    assert np.allclose(axes, turn.as_matrix() @ np.diag([1, -1, -1]))


def test_palm_that_moves_with_the_fingers_is_the_frame_all_the_same():
    """Seen from the ring's part of the palm, the arch moves the index finger."""
    other = RobotHand(build_hand(), "palm_ulnar", {"index": "index_pad"})
    assert "palm_arch" in other.joint_names
    x = 0.5 * (other.lower + other.upper)
    step = np.zeros(len(x))
    step[other.joint_names.index("palm_arch")] = 1e-6
    slope = (other.forward(x + step).points - other.forward(x - step).points) / 2e-6
    assert np.abs(slope).max() > 0.01
    arch = other.joint_names.index("palm_arch")
    assert np.allclose(other.forward(x).d_points[:, :, arch], slope, atol=1e-8)


def test_human_fingers_begin_at_their_knuckles_and_have_the_tables_lengths():
    hand, geometry = human_hand(HandSize(0.18, 0.08)), HandGeometry(HandSize(0.18, 0.08))
    assert hand.fingers == FINGERS
    assert len(hand.joint_names) == 20, "all but the wrist"
    assert np.allclose(hand.roots[0], geometry.thumb_cmc)
    for i, name in enumerate(FINGERS):
        shape = geometry.ellipsoid(f"{name}_distal")
        bones = sum(LENGTHS[name][:2]) * 0.18
        pad = np.hypot(shape.centre[0], shape.semi_axes[2])
        assert hand.reach[i] == pytest.approx(bones + pad, rel=1e-6)
        if name != "thumb":
            assert np.allclose(hand.roots[i], geometry.mcp(name))


def test_finger_whose_metacarpal_moves_begins_where_it_is_said_to():
    little = {"little": "little_pad"}
    plain = RobotHand(build_hand(), "palm", little)
    named = RobotHand(build_hand(), "palm", little, knuckles={"little": "little_mcp"})
    assert np.allclose(plain.roots[0], HandGeometry().arch_origin)
    assert np.allclose(named.roots[0], HandGeometry().mcp("little"))
    assert named.reach[0] == pytest.approx(human_hand().reach[4])
    assert named.joint_names == plain.joint_names, "the arch is moved all the same"
    with pytest.raises(UnknownNameError, match="little_mcp"):
        RobotHand(build_hand(), "palm", little, knuckles={"little": "litle_mcp"})


def test_offset_and_turn_of_a_frame_are_within_the_site_or_body():
    plain = finger()
    turned = RobotHand(
        mujoco.MjSpec.from_string(FINGER.format(more="", equality="")),
        AttachedFrame("palm", pos=(0.01, 0.02, 0.03), quat=(0.0, 1.0, 0.0, 0.0)),
        {"index": AttachedFrame("second", (0.03, 0.0, 0.0), (0.5**0.5, 0.0, 0.0, 0.5**0.5))},
    )
    x = np.array([0.2, 0.3])
    point, direction = plain.forward(x).points[0], plain.forward(x).directions[0]
    assert np.allclose(turned.forward(x).points[0], (point - [0.01, 0.02, 0.03]) * [1, -1, -1])
    assert direction[1] == pytest.approx(0, abs=1e-12)
    assert np.allclose(turned.forward(x).directions[0], [0, -1, 0], atol=1e-12)


def test_joints_without_a_range_get_a_wide_one():
    robot = finger(SLIDE, end="third")
    assert robot.slides.tolist() == [False, False, True]
    assert np.allclose([robot.lower[2], robot.upper[2]], [-0.1, 0.1])
    spec = mujoco.MjSpec.from_string(FINGER.format(more="", equality=""))
    spec.joint("middle").limited = mujoco.mjtLimited.mjLIMITED_FALSE
    free = RobotHand(spec, "palm", {"index": "second"})
    assert np.allclose([free.lower[1], free.upper[1]], [-np.pi, np.pi])


def test_order_of_fingers_is_thumb_first_however_they_are_given():
    robot = RobotHand(FOUR_FINGERS, "base_frame", dict(reversed(TIPS.items())))
    assert robot.fingers == ("thumb", "index", "middle", "ring")
    assert np.allclose(robot.roots, four_fingers().roots)


def test_what_cannot_be_read_or_followed_is_an_error_with_a_remedy(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        RobotHand(tmp_path / "none.xml", "palm", {"index": "second"})
    (tmp_path / "broken.xml").write_text("<mujoco><worldbody></mujoco>")
    with pytest.raises(FileError, match=r"broken\.xml"):
        RobotHand(tmp_path / "broken.xml", "palm", {"index": "second"})
    with pytest.raises(UnknownNameError, match="f1_touch"):
        RobotHand(FOUR_FINGERS, "base_frame", TIPS | {"index": "f1_tuch"})
    with pytest.raises(UnknownNameError, match="little"):
        RobotHand(FOUR_FINGERS, "base_frame", {"litle": "f1_touch"})
    with pytest.raises(InputError, match="no fingertip"):
        RobotHand(FOUR_FINGERS, "base_frame", {})
    with pytest.raises(InputError, match="no joint of its own"):
        finger(end="palm")
    with pytest.raises(InputError, match="hinge"):
        finger(SLIDE.replace('type="slide"', 'type="ball"'), end="third")


@pytest.mark.parametrize(
    ("equality", "message"),
    [
        ('<weld body1="second" body2="wrist"/>', "binds the fingers"),
        ('<connect name="loop" body1="first" body2="wrist" anchor="0 0 0"/>', "'loop' binds"),
        ('<joint joint1="middle" joint2="wrist"/>', "not between palm and fingertips"),
        (
            '<joint joint1="middle" joint2="knuckle"/><joint joint1="knuckle" joint2="middle"/>',
            "in a circle",
        ),
    ],
)
def test_closed_loops_and_foreign_leaders_are_refused(equality, message):
    with pytest.raises(InputError, match=message):
        finger(equality=equality)
    assert finger(equality=equality.replace("/>", ' active="false"/>')).reach[0] > 0


def test_weld_that_carries_the_hand_is_none_of_its_business():
    assert finger(equality='<weld body1="wrist" body2="world"/>').lower.shape == (2,)

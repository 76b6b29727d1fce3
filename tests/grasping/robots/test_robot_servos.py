"""Stiffness, lead and force of servos, against what a finger of two hinges has by hand."""

import numpy as np
import pytest

from handsim.grasping.robots.robot_servos import RobotServos
from handsim.joints import FINGERS
from handsim.retargeting.robot_hand import RobotHand

GAINS, DAMPING = (2.0, 3.0), 0.06
ARM = """
<body name="{name}" pos="0 {y} 0">
  <joint name="{name}_1" axis="0 1 0" range="-2 2" damping="{damping}"/>
  <geom type="capsule" size="0.008" fromto="0 0 0 0.05 0 0"/>
  <body pos="0.05 0 0">
    <joint name="{name}_2" axis="0 1 0" range="-2 2" damping="{damping}"/>
    <geom type="capsule" size="0.008" fromto="0 0 0 0.04 0 0"/>
    <site name="{name}_tip" pos="0.04 0 0"/>
  </body>
</body>"""


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> RobotHand:
    arms = "".join(
        ARM.format(name=name, y=y, damping=DAMPING) for name, y in (("a", -0.03), ("b", 0.03))
    )
    servos = "".join(
        f'<position name="{name}_{i}" joint="{name}_{i}" kp="{gain}" kv="0.03" ctrlrange="-2 2"/>'
        for name in "ab"
        for i, gain in enumerate(GAINS, start=1)
    )
    path = tmp_path_factory.mktemp("pair") / "pair.xml"
    path.write_text(
        '<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="palm">'
        f'<site name="frame"/><geom size="0.01"/>{arms}</body></worldbody>'
        f"<actuator>{servos}</actuator></mujoco>"
    )
    return RobotHand(path, "frame", {"thumb": "a_tip", "index": "b_tip"})


def test_stiffness_and_lead_are_those_of_the_file(pair):
    servos = RobotServos.at(pair, np.zeros(4))
    np.testing.assert_allclose(servos.stiffness, np.diag([*GAINS, *GAINS]), atol=1e-6)
    np.testing.assert_allclose(servos.lead, [0.09 / gain for gain in (*GAINS, *GAINS)], rtol=1e-4)
    assert servos.lag == pytest.approx(0.5 * (0.09 / 2 + 0.09 / 3), rel=1e-4)


def test_fingertips_move_as_levers_say_and_other_fingers_do_not(pair):
    servos = RobotServos.at(pair, np.zeros(4))
    thumb = servos.jacobian[FINGERS.index("thumb")]
    np.testing.assert_allclose(thumb[2], [-0.09, -0.04, 0.0, 0.0], atol=1e-9)
    np.testing.assert_array_equal(servos.jacobian[FINGERS.index("little")], 0.0)


def test_the_force_of_a_movement_is_that_of_its_work(pair):
    """A target that is off by dx stores dx K dx; the tip would have gone J dx."""
    servos = RobotServos.at(pair, np.zeros(4))
    closing = np.array([0.1, 0.2, 0.0, 0.0])
    work, way = 0.1**2 * 2.0 + 0.2**2 * 3.0, 0.1 * 0.09 + 0.2 * 0.04
    assert servos.force_of(closing) == pytest.approx(work / way, rel=1e-4)


def test_a_thumb_that_stands_still_leaves_the_force_to_the_next_finger(pair):
    servos = RobotServos.at(pair, np.zeros(4))
    own = servos.force_of(np.array([0.0, 0.0, 0.1, 0.2]))
    assert own == pytest.approx(servos.force_of(np.array([0.1, 0.2, 0.0, 0.0])))
    assert servos.force_of(np.zeros(4)) == 0.1

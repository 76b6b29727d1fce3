"""Stiffness, lead and force of servos, against what a finger of two hinges has by hand."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.grasping.plan import Schedule
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.joints import FINGERS
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import Task

TASK = task_by_name("cube-raise")
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


@dataclass(frozen=True)
class Asked:
    """What a schedule looks at of a scene."""

    task: Task


def hand_of(path: Path, without: str = "", gain: float = 1.0) -> RobotHand:
    """Two fingers of two hinges, of which one may have no servo."""
    arms = "".join(
        ARM.format(name=name, y=y, damping=DAMPING) for name, y in (("a", -0.03), ("b", 0.03))
    )
    servos = "".join(
        f'<position name="{joint}" joint="{joint}" kp="{kp * gain}" kv="0.03" ctrlrange="-2 2"/>'
        for joint, kp in zip(("a_1", "a_2", "b_1", "b_2"), (*GAINS, *GAINS), strict=True)
        if joint != without
    )
    path.write_text(
        '<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="palm">'
        f'<site name="frame"/><geom size="0.01"/>{arms}</body></worldbody>'
        f"<actuator>{servos}</actuator></mujoco>"
    )
    return RobotHand(path, "frame", {"thumb": "a_tip", "index": "b_tip"})


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> RobotHand:
    return hand_of(tmp_path_factory.mktemp("pair") / "pair.xml")


def test_stiffness_and_lead_are_those_of_the_file(pair):
    servos = RobotServos.at(pair, np.zeros(4))
    np.testing.assert_allclose(servos.stiffness, np.diag([*GAINS, *GAINS]), atol=1e-6)
    np.testing.assert_allclose(servos.lead, [0.09 / gain for gain in (*GAINS, *GAINS)], rtol=1e-4)
    assert servos.lag == pytest.approx(0.5 * (0.09 / 2 + 0.09 / 3), rel=1e-4)


def test_a_joint_that_no_servo_moves_has_no_lead_and_does_not_lag(tmp_path):
    """It gives way freely: its damping over hardly any stiffness would be minutes."""
    servos = RobotServos.at(hand_of(tmp_path / "hand.xml", without="a_2"), np.zeros(4))
    np.testing.assert_array_equal(servos.driven, [True, False, True, True])
    assert 0.0 < servos.stiffness[1, 1] < 0.01
    np.testing.assert_allclose(servos.lead, [0.045, 0.0, 0.045, 0.03], rtol=1e-4)
    assert servos.lag == pytest.approx(0.045, rel=1e-4)


def test_servos_that_are_too_slow_to_grasp_are_refused(tmp_path, grasps):
    def schedule(gain: float) -> Schedule:
        robot = hand_of(tmp_path / f"{gain}.xml", gain=gain)
        return replace(grasps, retargeter=Retargeter(robot)).schedule(Asked(TASK))

    assert schedule(0.05).squeeze > schedule(1.0).squeeze + 3.0  # of 1.7 s
    with pytest.raises(InputError, match=r"time constant of 3\.75 s, more than 2; give them more"):
        schedule(0.01)


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

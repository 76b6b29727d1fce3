"""Joints on one tendon actuator move as it moves them; commands hold the postures returned."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim import Retargeter, RobotHand, data_folder, read_recordings

DATA = Path(__file__).parents[3] / "shared/data"
CLAW = """
<mujoco><compiler angle="radian"/><option gravity="0 0 0" timestep="0.002"/>
<default><joint damping="{damping}" stiffness="{stiffness}" armature="0.001"/></default>
<worldbody><body name="palm"><site name="palm"/>
{fingers}
</body></worldbody>
<tendon>{tendons}</tendon>
<actuator>{actuators}</actuator></mujoco>
"""
FINGER = """<body name="{f}_1" pos="{x} {y} 0"><joint name="{f}_mcp" axis="0 1 0" range="-0.2 1.6"/>
<geom type="capsule" fromto="0 0 0 .045 0 0" size=".008"/>
<body pos=".045 0 0"><joint name="{f}_pip" axis="0 1 0" range="0 1.7"/>
<geom type="capsule" fromto="0 0 0 .025 0 0" size=".007"/>
<body pos=".025 0 0"><joint name="{f}_dip" axis="0 1 0" range="0 {dip}" {own}/>
<geom type="capsule" fromto="0 0 0 .022 0 0" size=".006"/><site name="{f}_tip" pos=".022 0 0"/>
</body></body></body>"""
TENDON = (
    '<fixed name="{f}_j0"><joint joint="{f}_pip" coef="1"/><joint joint="{f}_dip" coef="{c}"/>'
    "</fixed>"
)
ACTUATORS = (
    '<position name="{f}_a" joint="{f}_mcp" kp="5"/>'
    '<position name="{f}_b" tendon="{f}_j0" kp="5" ctrlrange="0 3.4"/>'
)
FINGERS = ("index", "middle")


def claw(
    c: float = 1.0, dip: float = 1.7, own: str = "", damping: float = 0.05, stiffness: float = 0.0
) -> RobotHand:
    places = {"index": (0.09, 0.02), "middle": (0.092, 0.0)}
    text = CLAW.format(
        damping=damping,
        stiffness=stiffness,
        fingers="".join(
            FINGER.format(f=f, x=x, y=y, dip=dip, own=own) for f, (x, y) in places.items()
        ),
        tendons="".join(TENDON.format(f=f, c=c) for f in FINGERS),
        actuators="".join(ACTUATORS.format(f=f) for f in FINGERS),
    )
    tips = {f: f"{f}_tip" for f in FINGERS}
    return RobotHand(mujoco.MjSpec.from_string(text), "palm", tips)  # type: ignore[arg-type]


def follower_and_leader(robot: RobotHand, finger: str = "index") -> tuple[int, int]:
    names = robot.joint_names
    return names.index(f"{finger}_dip"), names.index(f"{finger}_pip")


def test_two_joints_on_one_tendon_are_one_coordinate() -> None:
    robot = claw()
    assert len(robot.joint_names) == 6 and len(robot.lower) == 4
    positions = robot.joint_positions(np.array([0.1, 0.5, 0.2, 0.9]))
    dip, pip = follower_and_leader(robot)
    assert positions[dip] == positions[pip] == 0.5
    assert robot.actuator_names == ("index_a", "index_b", "middle_a", "middle_b")


@pytest.mark.parametrize(
    ("c", "own", "stiffness", "ratio"),
    [
        (1.0, "", 0.0, 1.0),
        (0.5, "", 0.0, 0.5),
        (1.0, 'damping="0.1"', 0.0, 0.5),  # twice the damping, half the way
        (1.0, 'stiffness="1.2"', 0.4, 1 / 3),
    ],
)
def test_they_go_as_the_simulated_actuator_moves_them(
    c: float, own: str, stiffness: float, ratio: float
) -> None:
    robot = claw(c=c, own=own, stiffness=stiffness)
    dip, pip = follower_and_leader(robot)
    x = np.array([0.0, 0.6, 0.0, 0.6])
    predicted = robot.joint_positions(x)
    assert predicted[dip] == pytest.approx(ratio * predicted[pip])
    data = mujoco.MjData(robot.model)
    data.ctrl[:] = robot.commands(x)
    for _ in range(4000):
        mujoco.mj_step(robot.model, data)
    moved = data.qpos
    assert moved[pip] > 0.1
    assert moved[dip] / moved[pip] == pytest.approx(ratio, rel=0.02)
    if not stiffness:  # springs hold against the servo
        np.testing.assert_allclose(moved, predicted, atol=0.01)


def test_ranges_of_both_joints_are_kept() -> None:
    robot = claw(dip=0.8)
    dip, pip = follower_and_leader(robot)
    top = robot.joint_positions(robot.upper)
    assert top[dip] == pytest.approx(0.8, abs=1e-3) and top[pip] == pytest.approx(0.8, abs=1e-3)
    assert top[dip] <= 0.8 + 1e-9


def test_joints_with_an_actuator_of_their_own_are_free() -> None:
    text = CLAW.format(
        damping=0.1,
        stiffness=0,
        fingers=FINGER.format(f="index", x=0.09, y=0.0, dip=1.7, own=""),
        tendons=TENDON.format(f="index", c=1),
        actuators='<position joint="index_dip"/><position tendon="index_j0"/>',
    )
    robot = RobotHand(mujoco.MjSpec.from_string(text), "palm", {"index": "index_tip"})
    assert len(robot.lower) == 3


def test_commands_keep_to_their_ranges_and_motors_have_none() -> None:
    robot = claw()
    high = robot.commands(np.array([[0.0, 1.7, 0.0, 0.3], [1.0, 0.2, 0.0, 0.3]]))
    np.testing.assert_allclose(high, [[0.0, 3.4, 0.0, 0.6], [1.0, 0.4, 0.0, 0.6]], atol=1e-9)
    text = CLAW.format(
        damping=0.1,
        stiffness=0,
        fingers=FINGER.format(f="index", x=0.09, y=0.0, dip=1.7, own=""),
        tendons="",
        actuators='<motor joint="index_mcp"/>',
    )
    motor = RobotHand(mujoco.MjSpec.from_string(text), "palm", {"index": "index_tip"})
    assert np.isnan(motor.commands(motor.reference)).all()


@pytest.mark.real_data
@pytest.mark.skipif(not DATA.is_dir(), reason="the files of users are not beside the checkout")
def test_a_users_claw_by_tendon_is_that_by_equality() -> None:
    tips = {f: f"{f}_tip" for f in ("thumb", "index", "middle")}
    folder = DATA / "user_files/tendon-coupled"
    cube = next(
        r for r in read_recordings(data_folder("assets") / "experiments") if r.task == "cube-raise"
    )
    tendon, equality = (
        Retargeter(RobotHand(folder / f"claw_{kind}.xml", "palm", tips))  # type: ignore[arg-type]
        for kind in ("tendon", "equality")
    )
    by_tendon, by_equality = tendon.retarget(cube.q[::10]), equality.retarget(cube.q[::10])
    np.testing.assert_allclose(by_tendon.positions, by_equality.positions, atol=1e-9)
    names = by_tendon.joint_names
    for finger in tips:
        pip, dip = (by_tendon.positions[:, names.index(f"{finger}_{j}")] for j in ("pip", "dip"))
        np.testing.assert_array_equal(pip, dip)
        command = by_tendon.commands[:, by_tendon.actuator_names.index(f"{finger}_b")]
        np.testing.assert_allclose(command, pip + dip, atol=1e-9)

import numpy as np
import pytest

from handsim.arm.arm_geometry import ArmGeometry
from handsim.arm.arm_joints import ARM_JOINT_NAMES
from handsim.arm.arm_strength import (
    PASSIVE_DAMPING,
    SATURATION,
    arm_damping,
    arm_gains,
    arm_torque_limits,
    leading_targets,
    moved_inertia,
)
from handsim.types import HandSize

ARM = ArmGeometry()


def test_the_median_man_has_the_published_torques_and_others_the_cube() -> None:
    assert arm_torque_limits(ARM) == pytest.approx([67, 71, 33, 46, 13.1])
    small = ArmGeometry(HandSize(0.1933 / 2 + 0.05, 0.07))
    ratio = arm_torque_limits(small) / arm_torque_limits(ARM)
    assert ratio == pytest.approx(np.full(5, ((0.1933 / 2 + 0.05) / 0.1933) ** 3))


def test_gain_is_torque_over_saturation_and_damping_is_critical() -> None:
    assert arm_gains(ARM) * SATURATION == pytest.approx(arm_torque_limits(ARM))
    assert arm_gains(ARM, 0.3) == pytest.approx(0.3 * arm_gains(ARM))
    for stiffness in (1.0, 0.25):
        ratio = arm_damping(ARM, stiffness) / (
            2 * np.sqrt(arm_gains(ARM, stiffness) * moved_inertia(ARM))
        )
        assert ratio == pytest.approx(np.ones(5))


def test_the_shoulder_moves_the_whole_arm() -> None:
    plane, elevation, rotation, elbow, forearm = moved_inertia(ARM)
    assert elevation > 3 * elbow
    assert elevation > plane > rotation > elbow > 10 * forearm
    assert 0.2 < elevation < 0.5  # a straight arm of 4 kg and 0.3 m to its middle has 0.4 kg m2


def test_a_joint_follows_leading_targets_and_lags_behind_others() -> None:
    step, n = 0.002, 600
    time = np.arange(n) * step
    path = np.outer(1 - np.cos(np.pi * np.clip(time / 1.0, 0, 1)), np.linspace(0.2, 0.5, 5))
    gains, inertia = arm_gains(ARM), moved_inertia(ARM)
    passive = np.array([PASSIVE_DAMPING[name.split("_")[0]] for name in ARM_JOINT_NAMES])
    damping = arm_damping(ARM) + passive
    worst = []
    for targets in (path, leading_targets(path, step, ARM)):
        q, speed, off = path[0].copy(), np.zeros(5), 0.0
        for k in range(n):
            off = max(off, float(np.abs(q - path[k]).max()))
            torque = gains * (targets[k] - q) - damping * speed
            speed = speed + step * torque / inertia
            q = q + step * speed
        worst.append(off)
    assert worst[0] > 0.05
    assert worst[1] < 0.005


def test_a_path_of_two_rows_is_its_own_target() -> None:
    path = np.arange(10.0).reshape(2, 5)
    assert leading_targets(path, 0.01, ARM).tolist() == path.tolist()

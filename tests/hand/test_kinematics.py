"""Forward kinematics in NumPy against the compiled hand, and its Jacobian against differences."""

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.hand.kinematics import Kinematics
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import LOWER, UPPER
from handsim.types import HandSize

SIZES = [HandSize(), HandSize(0.16, 0.08), HandSize(0.21, 0.09, "left")]


def random_postures(n: int) -> np.ndarray:
    return np.random.default_rng(5).uniform(LOWER, UPPER, (n, 22))


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_bodies_axes_and_fingertips_are_those_of_the_compiled_hand(size: HandSize) -> None:
    compiled, hand = HandModel.from_spec(build_hand(size)), Kinematics(size)
    q = random_postures(20)
    frames = hand.frames(q)
    tips = hand.points(frames, hand.fingertips)
    bodies = [compiled.model.body(name).id for name in hand.names]
    joints = [
        mujoco.mj_name2id(compiled.model, mujoco.mjtObj.mjOBJ_JOINT, name)
        for name in compiled_joints(compiled)
    ]
    for i, posture in enumerate(q):
        compiled.set_posture(posture)
        assert np.abs(compiled.data.xpos[bodies] - frames.position[i]).max() < 1e-9
        turned = compiled.data.xmat[bodies].reshape(-1, 3, 3)
        assert np.abs(turned - frames.rotation[i]).max() < 1e-9
        assert np.abs(compiled.data.xaxis[joints] - frames.axis[i]).max() < 1e-9
        assert np.abs(compiled.fingertips() - tips[i]).max() < 1e-9
        thumb, index = compiled.fingertips()[:2]
        assert hand.aperture(q[[i]]) == pytest.approx([np.linalg.norm(thumb - index)], abs=1e-9)


def compiled_joints(compiled: HandModel) -> tuple[str, ...]:
    from handsim.joints import JOINT_NAMES

    assert compiled.model.njnt == len(JOINT_NAMES)
    return JOINT_NAMES


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("last", ["thumb_distal", "ring_distal", "palm"])
def test_a_body_and_those_that_carry_it_can_be_placed_alone(size: HandSize, last: str) -> None:
    hand, q = Kinematics(size), random_postures(3)
    whole, alone = hand.frames(q), hand.frames(q, last)
    i = hand.names.index(last)
    np.testing.assert_array_equal(alone.position[:, i], whole.position[:, i])
    np.testing.assert_array_equal(alone.rotation[:, i], whole.rotation[:, i])
    np.testing.assert_array_equal(alone.axis[:, hand.moves[i]], whole.axis[:, hand.moves[i]])
    others = [j for j, name in enumerate(hand.names) if name.split("_")[0] == "index"]
    np.testing.assert_array_equal(alone.position[:, others], 0.0)


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_jacobian_is_the_derivative(size: HandSize) -> None:
    hand, q, step = Kinematics(size), random_postures(6), 1e-6
    names = [
        "palm",
        "palm_ulnar",
        "thumb_metacarpal",
        "thumb_distal",
        "index_middle",
        "ring_distal",
    ]
    points = hand.at(names, np.random.default_rng(1).uniform(-0.02, 0.02, (len(names), 3)))
    jacobian = hand.jacobian(hand.frames(q), points)
    assert jacobian.shape == (6, len(names), 3, 22)
    for j in range(22):
        moved = [hand.points(hand.frames(q + s * step * np.eye(22)[j]), points) for s in (1, -1)]
        assert np.abs((moved[0] - moved[1]) / (2 * step) - jacobian[..., j]).max() < 1e-8
    assert np.abs(jacobian[:, 3, :, 20:]).max() > 0.05  # the wrist moves the thumb


def test_bad_input() -> None:
    with pytest.raises(InputError, match=r"give .n, 22"):
        Kinematics().frames(np.zeros((3, 20)))
    with pytest.raises(UnknownNameError, match="index_distal"):
        Kinematics().at(["index_distl"], np.zeros((1, 3)))
    with pytest.raises(InputError, match="hand length"):
        Kinematics(HandSize(0.5, 0.1)).frames(np.zeros((1, 22)))

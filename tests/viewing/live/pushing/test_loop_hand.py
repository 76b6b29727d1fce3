import mujoco
import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.joints import FINGERS
from handsim.learning.controller import GraspController
from handsim.viewing.film.posture_clips import posture_model
from handsim.viewing.live.pushing.loop_hand import MOST_AT_ONCE_S, LoopHand
from handsim.viewing.live.pushing.pushes import (
    MOST_FORCE,
    STIFFNESS,
    PadPush,
    Pull,
    finger_of,
    limited,
)

MODEL = posture_model()
CONTROLLER = GraspController.load(data_folder("assets") / "controller.npz")
GOAL = CONTROLLER.demonstrations[0].z_goal


def loop_hand(seed: int = 0) -> LoopHand:
    return LoopHand(CONTROLLER, MODEL, np.zeros(3), GOAL, seed)


def run(loop: LoopHand, seconds: float, *pushes: PadPush | Pull) -> np.ndarray:
    """Advance frame by frame, and return how far off the hand was after each [deg]."""
    off = []
    for _ in range(round(30 * seconds)):
        loop.advance(1 / 30, pushes)
        off.append(np.rad2deg(loop.off))
    return np.array(off)


def test_the_hand_goes_to_its_destination_and_stays_there() -> None:
    loop = loop_hand()
    assert np.linalg.norm(loop.place - GOAL) > np.deg2rad(20)
    assert run(loop, 2.0).max() == 0.0, "without a push both hands are the same"
    assert loop.time == pytest.approx(2.0, abs=0.011)
    assert np.linalg.norm(loop.place - GOAL) < np.deg2rad(1)


@pytest.mark.parametrize("begins", [0.4, 2.0], ids=["on its way", "at its destination"])
def test_a_pushed_hand_comes_back(begins: float) -> None:
    loop = loop_hand()
    run(loop, begins)
    off = run(loop, 1.5, PadPush("index", 20.0, until=loop.time + 0.3))
    assert off[:9].max() > 4
    assert off[-1] < 0.1
    forces = np.array([force for _, _, force in loop.past])
    assert (forces > 0).sum() == 30
    assert forces.max() == pytest.approx(20.0)


def test_the_loop_is_closed_its_reference_follows_the_reading_of_a_pushed_hand() -> None:
    loop = loop_hand()
    run(loop, 0.5)
    assert np.array_equal(*loop._references)
    run(loop, 0.3, PadPush("middle", 30.0, until=np.inf))
    pushed, free = loop._references
    assert np.rad2deg(np.linalg.norm(pushed - free)) > 0.3


def test_the_noise_of_the_glove_is_that_of_its_seed() -> None:
    loops = [loop_hand(seed) for seed in (0, 0, 1)]
    for loop in loops:
        run(loop, 0.5)
    first, same, other = (loop.place for loop in loops)
    np.testing.assert_array_equal(first, same)
    assert not np.array_equal(first, other)


def test_the_hand_goes_on_to_another_destination() -> None:
    loop = loop_hand()
    run(loop, 0.6)
    before = loop.place
    loop.redirect(np.zeros(3))
    assert np.array_equal(loop.place, before)
    run(loop, 0.2)
    assert np.linalg.norm(loop.place) > 0.7 * np.linalg.norm(before), "it begins slowly again"
    run(loop, 2.0)
    assert np.linalg.norm(loop.place) < np.deg2rad(1)
    with pytest.raises(InputError):
        loop.redirect(np.full(3, 9.0))


def test_a_late_page_does_not_make_up_for_everything() -> None:
    loop = loop_hand()
    loop.advance(20.0)
    assert loop.time == pytest.approx(MOST_AT_ONCE_S)


def test_a_pull_draws_a_finger_to_the_pointer_and_lets_it_go() -> None:
    loop = loop_hand()
    run(loop, 2.0)
    body = MODEL.body("index_distal").id
    held = loop.data.xpos[body] + [0.004, -0.003, 0.01]
    pull = Pull.at(loop.data, body, held, held + [0.0, 0.0, 0.05])
    np.testing.assert_allclose(pull.held(loop.data), held, atol=1e-12)
    run(loop, 0.5, pull)
    moved = pull.held(loop.data) - held
    assert moved[2] > 0.002
    run(loop, 1.0)
    np.testing.assert_allclose(pull.held(loop.data), held, atol=1e-3)


def test_pulls_are_springs_of_limited_force() -> None:
    data = mujoco.MjData(MODEL)
    mujoco.mj_forward(MODEL, data)
    body = MODEL.body("thumb_distal").id
    near = Pull.at(data, body, data.xpos[body], data.xpos[body] + [0.02, 0.0, 0.0])
    assert near.apply(MODEL, data) == pytest.approx(0.02 * STIFFNESS)
    jacobian = np.zeros((3, MODEL.nv))
    mujoco.mj_jacBody(MODEL, data, jacobian, None, body)
    np.testing.assert_allclose(data.qfrc_applied, 0.02 * STIFFNESS * jacobian[0], atol=1e-9)
    far = Pull.at(data, body, data.xpos[body], data.xpos[body] + [3.0, 0.0, 0.0])
    assert far.apply(MODEL, data) == pytest.approx(MOST_FORCE)
    np.testing.assert_array_equal(limited(np.array([0.0, 2.0, 0.0])), [0.0, 2.0, 0.0])


def test_a_push_opens_the_finger_whose_pad_it_is_on() -> None:
    for finger in FINGERS:
        loop = loop_hand()
        run(loop, 2.0)
        joint = MODEL.joint(f"{finger}_mcp").qposadr[0]
        before = loop.qpos.copy()
        run(loop, 0.3, PadPush(finger, 20.0, until=np.inf))
        away = np.rad2deg(loop.qpos - before)
        assert away[joint] < -1
        if finger != "thumb":
            assert abs(away[joint]) == pytest.approx(np.abs(away).max(), rel=0.7)


def test_bodies_belong_to_fingers() -> None:
    assert finger_of("index_distal") == "index"
    assert finger_of("palm_ulnar") is finger_of("forearm") is None

import mujoco
import numpy as np
import pytest

from handsim.joints import FINGERS, JOINT_INDEX, JOINT_NAMES, UPPER
from handsim.recordings.recording import Recording
from handsim.types import HandSize
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.posture_clips import posture_clip, posture_model


def closing(n: int = 41, seed: int = 0) -> Recording:
    """A hand that closes, a little differently by the seed."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0, 1, n)
    goal = 0.6 * UPPER * rng.uniform(0.7, 1.0, 22)
    bend = 0.2 * rng.normal(size=22)
    share = 10 * time**3 - 15 * time**4 + 6 * time**5
    q = np.outer(share, goal) + np.outer(np.sin(np.pi * share), bend)
    return Recording(
        f"r{seed}", time, q, seed + 1, "synthetic", "cube", "cube-raise", HandSize(0.19, 0.085)
    )


@pytest.fixture(scope="module")
def hand() -> mujoco.MjModel:
    return posture_model()


def test_hand_stands_upright_with_its_palm_to_the_front(hand: mujoco.MjModel) -> None:
    data = mujoco.MjData(hand)
    mujoco.mj_forward(hand, data)
    wrist, tip = data.body("palm").xpos, data.site("middle_tip").xpos
    np.testing.assert_allclose((tip - wrist)[:2], 0, atol=5e-3)
    assert tip[2] - wrist[2] > 0.18
    assert data.site("palm_centre").xpos[0] > wrist[0], "the palm faces +x"
    assert data.body("index_proximal").xpos[1] > data.body("little_proximal").xpos[1]


def test_left_hand_is_its_mirror_image(hand: mujoco.MjModel) -> None:
    left = posture_model(HandSize(side="left"))
    places = []
    for model in (hand, left):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        places.append(np.array([data.site(f"{finger}_tip").xpos for finger in FINGERS]))
    np.testing.assert_allclose(places[0] * [1, -1, 1], places[1], atol=1e-9)


def test_joints_are_drawn_in_glove_order_and_beyond_their_ranges(hand: mujoco.MjModel) -> None:
    q = np.arange(44.0).reshape(2, 22) / 10
    clip = posture_clip(np.arange(2.0), q, hand)
    for name in JOINT_NAMES:
        address = hand.joint(name).qposadr[0]
        np.testing.assert_array_equal(clip.qpos[:, address], q[:, JOINT_INDEX[name]])


def test_frames_show_a_hand_before_a_plain_background(rendering: str, hand: mujoco.MjModel) -> None:
    recording = closing()
    clip = posture_clip(recording.time, recording.q, hand)
    frames = list(render_clips([clip], View(width=96, height=96, fps=4)))
    assert len(frames) == 5
    for frame in frames:
        red = frame[..., 0].astype(int) - frame[..., 2]
        assert 0.05 < (red > 30).mean() < 0.5, "skin"
        assert (red < 5).mean() > 0.4, "background"
    assert len({frame.tobytes() for frame in frames}) == 5

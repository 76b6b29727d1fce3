"""What a frame costs beside MuJoCo's renderer alone; run by `make bench`.

The bar on their ratio is held, for both backends, in `tests/viewing/opengl/test_backends.py`.
"""

from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from handsim.joints import clip_to_range
from handsim.viewing.film.clips import Clip, render_clips
from handsim.viewing.film.offscreen import Camera, View
from handsim.viewing.film.posture_clips import posture_clip
from handsim.viewing.opengl.backend import choose_backend

pytestmark = pytest.mark.slow

VIEW = View("view", 640, 480, fps=30)
N_FRAMES = 31
ROUNDS = 3


@pytest.fixture(scope="module")
def clip() -> Clip:
    choose_backend()
    time = np.linspace(0.0, 1.0, 101)
    return posture_clip(time, clip_to_range(np.outer(time, np.full(22, 1.2))))


def test_a_second_of_video(benchmark, clip: Clip) -> None:
    frames = benchmark.pedantic(lambda: list(render_clips([clip], VIEW)), rounds=ROUNDS)
    assert len(frames) == N_FRAMES
    assert frames[0].shape == (VIEW.height, VIEW.width, 3)


def test_the_same_frames_by_mujoco_alone(benchmark, clip: Clip) -> None:
    model, data = clip.model, mujoco.MjData(clip.model)
    usual, model.vis.quality.shadowsize = model.vis.quality.shadowsize, 0

    def frames() -> Iterator[np.ndarray]:
        with mujoco.Renderer(model, VIEW.height, VIEW.width) as renderer:
            mujoco.mj_forward(model, data)
            camera = Camera(model, data, VIEW.camera).view
            for time in np.arange(N_FRAMES) / VIEW.fps:
                data.qpos[:] = clip.qpos[min(round(100 * time), 100)]
                mujoco.mj_forward(model, data)
                renderer.update_scene(data, camera)
                yield renderer.render()

    drawn = benchmark.pedantic(lambda: list(frames()), rounds=ROUNDS)
    model.vis.quality.shadowsize = usual
    assert len(drawn) == N_FRAMES

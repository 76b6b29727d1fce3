"""What frames cost beside MuJoCo's renderer and beside ffmpeg alone; run by `make bench`.

The bar on the ratio of rendering is held, for both backends, in
`tests/viewing/opengl/test_backends.py`.
"""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest

from handsim.joints import clip_to_range
from handsim.types import Frame
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.posture_clips import posture_clip
from handsim.viewing.film.video import write_video
from handsim.viewing.opengl.backend import choose_backend
from handsim.viewing.stage.camera import Camera

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


@pytest.fixture(scope="module")
def frames(clip: Clip) -> list[Frame]:
    """Four seconds of video: there, back, there and back again."""
    there = list(render_clips([clip], VIEW))
    return [*there, *there[::-1]] * 2


def test_four_seconds_into_mp4(benchmark, frames: list[Frame], tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    n = benchmark.pedantic(lambda: write_video(frames, path, VIEW.fps), rounds=2 * ROUNDS)
    assert n == len(frames)


def test_the_same_frames_through_a_pipe_to_ffmpeg(
    benchmark, frames: list[Frame], tmp_path: Path
) -> None:
    ours, alone = tmp_path / "a.mp4", tmp_path / "b.mp4"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{VIEW.width}x{VIEW.height}"]
    colours = ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]
    h264 = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-vf", "scale=out_color_matrix=bt709"]
    quality = ["-crf", "20", "-preset", "medium", "-movflags", "+faststart"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", *raw, "-r", "30", "-i", "-"]
    command += [*h264, *colours, *quality, str(alone)]

    def encode() -> None:
        with subprocess.Popen(command, stdin=subprocess.PIPE) as encoder:
            for frame in frames:
                encoder.stdin.write(frame)
            encoder.stdin.close()

    benchmark.pedantic(encode, rounds=2 * ROUNDS)
    write_video(frames, ours, VIEW.fps)
    assert ours.read_bytes() == alone.read_bytes()

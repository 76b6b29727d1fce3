"""Each backend in a process of its own, since a process can have only one."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

from handsim.types import Frame
from handsim.viewing.opengl.backend import probe

MOVEMENT = """
import numpy as np
from handsim.joints import clip_to_range
from handsim.viewing.film.clips import save_clips
from handsim.viewing.film.overlay import Caption
from handsim.viewing.film.posture_clips import posture_clip
from handsim.viewing.film.offscreen import View

time = np.linspace(0, 1, 101)
q = clip_to_range(np.outer(time, np.full(22, 1.2)))
clip = posture_clip(time, q, overlays=(Caption(("fist",)),))
"""


@pytest.fixture(scope="module", params=["egl", "osmesa"])
def backend(request: pytest.FixtureRequest) -> str:
    result = probe(request.param, seconds=0.0)
    if not result.ok:
        pytest.skip(f"{request.param} does not render here: {result.reason}")
    return request.param


def run(backend: str, code: str, *arguments: str) -> str:
    """Run code under a backend; nothing may be left on standard error."""
    environment = {**os.environ, "MUJOCO_GL": backend}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", MOVEMENT + code, *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    assert done.returncode == 0
    return done.stdout


def test_each_kind_of_file(
    backend: str, target: Path, read_video: Callable[[Path], tuple[dict[str, Any], list[Frame]]]
) -> None:
    code = """
import sys
folder = sys.argv[1]
view = View("view", 160, 120, fps=20)
save_clips([clip], f"{folder}/a.mp4", view)
save_clips([clip], f"{folder}/a.gif", view)
save_clips([clip], f"{folder}/a.png", view, n_postures=6)
save_clips([clip, clip], f"{folder}/two.mp4", view, columns=2)
"""
    run(backend, code, str(target))
    for name, width in (("a.mp4", 160), ("two.mp4", 2 * 160 + 2), ("a.gif", 160)):
        frames = np.array(read_video(target / name)[1])
        assert frames.shape == (21, 120, width, 3)
        assert all(np.ptp(frame) > 100 for frame in frames), "none is blank"
        steps = np.abs(np.diff(frames.astype(int), axis=0)).mean(axis=(1, 2, 3))
        assert steps.min() > 0.1, "none is like the one before"
    metadata, _ = read_video(target / "a.mp4")
    assert metadata["fps"] == pytest.approx(20)
    assert metadata["duration"] == pytest.approx(1.0, abs=1.1 / 20)
    assert iio.imread(target / "a.png").shape == (2 * 120 + 2, 3 * 160 + 4, 3)
    assert len(list(target.iterdir())) == 4


def test_a_platform_left_over_for_the_other_backend_does_no_harm(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYOPENGL_PLATFORM", "osmesa" if backend == "egl" else "egl")
    run(
        backend,
        "from handsim.viewing.film.clips import render_sheet\nrender_sheet(clip, View(), 2)",
    )


def test_an_unfinished_video_leaves_nothing_on_standard_error(backend: str) -> None:
    run(
        backend,
        "from handsim.viewing.film.clips import render_clips\n"
        "frames = render_clips([clip], View('view', 64, 48))\nnext(frames)",
    )


@pytest.mark.slow
def test_memory_stays_flat_over_many_renders(backend: str) -> None:
    code = """
import resource
from pathlib import Path
from handsim.viewing.film.clips import render_sheet

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20

for i in range(200):
    render_sheet(clip, View("view", 320, 240), n=2)
    if i == 19:
        start = resident()
print(resident() - start)
"""
    if not sys.platform.startswith("linux"):
        pytest.skip("reads the memory in use from /proc")
    assert float(run(backend, code)) < 50


@pytest.mark.slow
def test_drawing_costs_little_more_than_the_renderer_alone(backend: str) -> None:
    """CPU time, which other work on the machine disturbs less than the clock; best of 5."""
    code = """
import time as clock
import mujoco
from handsim.viewing.film.clips import render_clips
from handsim.viewing.stage.camera import Camera

view = View("view", 640, 480, fps=30)
model = clip.model

def ours():
    return sum(1 for _ in render_clips([clip], view))

def alone():
    data = mujoco.MjData(model)
    usual, model.vis.quality.shadowsize = model.vis.quality.shadowsize, 0
    with mujoco.Renderer(model, view.height, view.width) as renderer:
        mujoco.mj_forward(model, data)
        camera = Camera(model, data, view.camera).view
        for time in np.arange(31) / 30:
            data.qpos[:] = clip.qpos[min(round(100 * time), 100)]
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            renderer.render()
    model.vis.quality.shadowsize = usual
    return 31

def cost(draw):
    start = clock.process_time()
    assert draw() == 31
    return clock.process_time() - start

ours(), alone()
pairs = [(cost(ours), cost(alone)) for _ in range(5)]
print(min(p[0] for p in pairs) / min(p[1] for p in pairs))
"""
    ratio = float(run(backend, code))
    print(f"{backend}: {ratio:.3f} x mujoco.Renderer alone")
    assert ratio <= 1.15

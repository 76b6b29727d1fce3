"""A process forked from one that has rendered says so instead of hanging."""

import multiprocessing
import os
import subprocess
import sys

import pytest

from handsim.viewing.opengl import forking

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks on this system")

CODE = """
import os, signal
import mujoco
from handsim.errors import RenderingError
from handsim.viewing.film import offscreen as offscreen
from handsim.viewing.stage.camera import Camera

MODEL = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")

def ours():
    with offscreen.open_offscreen(32, 32) as opened:
        data = mujoco.MjData(MODEL)
        mujoco.mj_forward(MODEL, data)
        opened.add(MODEL).draw(data, Camera(MODEL, data, "front").view)

def mujocos():
    with mujoco.Renderer(MODEL, 32, 32) as renderer:
        data = mujoco.MjData(MODEL)
        mujoco.mj_forward(MODEL, data)
        renderer.update_scene(data)
        renderer.render()

{before}
child = os.fork()
if child == 0:
    signal.alarm(30)  # one that hangs is not left behind
    try:
        ours()
        print("drawn", flush=True)
    except RenderingError as error:
        print(error, flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""


def forked(before: str, backend: str) -> str:
    """What a child says that draws after its parent has done something."""
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(before=before)],
        env=os.environ | {"MUJOCO_GL": backend}, capture_output=True, text=True, timeout=60,
        check=True,
    )  # fmt: skip
    return done.stdout


def test_a_child_of_one_that_has_rendered_names_the_remedy(rendering: str) -> None:
    said = forked("ours()", rendering)
    assert "was forked from process" in said
    assert "multiprocessing.get_context('spawn') or 'forkserver'" in said
    assert said.count("\n") == 1


def test_so_does_a_child_of_one_that_has_used_mujocos_renderer(rendering: str) -> None:
    if rendering != "egl":
        pytest.skip("MuJoCo leaves a display open with EGL alone")
    assert "was forked from process" in forked("mujocos()", rendering)


def test_a_child_of_one_that_has_not_rendered_draws(rendering: str) -> None:
    assert forked("", rendering) == "drawn\n"


def test_a_process_that_was_spawned_may_render(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forking._rendering, "opened", True)
    process = multiprocessing.get_context("spawn").Process(target=forking.check_not_forked)
    process.start()
    process.join(60)
    assert process.exitcode == 0

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.joints import JOINT_NAMES
from handsim.learning.controller import GraspController
from handsim.viewing.live import window

SWEEP = """
from handsim.files import data_folder
from handsim.learning.controller import GraspController
from handsim.viewing.live.window import show
controller = GraspController.load(data_folder("assets") / "controller.npz")
show(controller, lambda task, hand: None, seconds=1.0)
"""


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


def test_a_display_is_one_that_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not window.has_display()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert window.has_display()


def test_components_are_swept_one_after_the_other(controller: GraspController) -> None:
    model, moments, qpos = window._sweep(controller)
    q = qpos[:, [model.joint(name).qposadr[0] for name in JOINT_NAMES]]
    z = controller.subspace.transform(q)
    assert np.all(np.diff(moments) > 0)
    deviations = np.sqrt(controller.subspace.explained_variance_)
    np.testing.assert_allclose(z.max(axis=0), 2 * deviations, rtol=1e-3)
    np.testing.assert_allclose(z.min(axis=0), -2 * deviations, rtol=1e-3)
    assert np.all((np.abs(z) > 1e-9).sum(axis=1) <= 1)


def test_a_task_without_a_plan_is_refused(controller: GraspController) -> None:
    with pytest.raises(InputError, match="handsim grasp --task cube-raise"):
        window.show(controller, lambda task, hand: None, "cube-raise")


def test_the_window_opens_and_closes() -> None:
    if shutil.which("xvfb-run") is None:
        pytest.skip("xvfb-run is not installed; apt-get install xvfb")
    done = subprocess.run(
        ["xvfb-run", "--auto-servernum", sys.executable, "-c", SWEEP],
        env={key: value for key, value in os.environ.items() if key != "MUJOCO_GL"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")

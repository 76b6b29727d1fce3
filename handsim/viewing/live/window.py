"""MuJoCo's own viewer, where there is a display."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import os
import sys
import threading
import time
from collections.abc import Callable

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.viewing.film.posture_clips import posture_clip, posture_model
from handsim.viewing.stage.camera import Camera

RATE = 60.0
"""Pictures a second."""
SWEEP_S = 3.0
"""Time in which a component is swept there and back [s]."""


def has_display() -> bool:
    """Return whether windows can be opened; on Linux, whether a display server is named."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def show(
    controller: GraspController,
    plans: Callable[[str, Conditions], GraspPlan | None],
    task: str | None = None,
    seconds: float = np.inf,
) -> None:
    """Play a grasp, or the principal components in turn, over and over until the window is closed.

    Parameters
    ----------
    controller
    plans
        Returns the plan of a task under conditions, or None where none is known.
    task
        Task that is grasped; None sweeps the principal components.
    seconds
        Time after which the window is closed [s].

    Raises
    ------
    InputError
        If no plan of the task is known.
    """
    import mujoco.viewer

    model, moments, qpos = _sweep(controller) if task is None else _grasp(controller, plans, task)
    data = mujoco.MjData(model)
    start = time.monotonic()
    data.qpos[:] = qpos[0]
    mujoco.mj_forward(model, data)
    around = Camera(model, data, "orbit").view  # people may turn it
    others = set(threading.enumerate())
    with mujoco.viewer.launch_passive(
        model, data, show_left_ui=False, show_right_ui=False
    ) as window:
        for name in ("lookat", "distance", "azimuth", "elevation"):
            setattr(window.cam, name, getattr(around, name))
        while window.is_running() and time.monotonic() - start < seconds:
            at = (time.monotonic() - start) % (moments[-1] + 1.0)  # pause of a second at the end
            with window.lock():
                data.qpos[:] = qpos[min(int(np.searchsorted(moments, at)), len(moments) - 1)]
                mujoco.mj_forward(model, data)
            window.sync()
            time.sleep(1 / RATE)
    for drawing in set(threading.enumerate()) - others:
        drawing.join(10.0)  # one still closing its window crashes the interpreter's end


def _grasp(
    controller: GraspController, plans: Callable[[str, Conditions], GraspPlan | None], name: str
) -> tuple[mujoco.MjModel, np.ndarray, np.ndarray]:
    task, conditions = task_by_name(name), Conditions()
    plan = plans(name, conditions)
    if plan is None:
        raise InputError(f"no plan of {name} is stored; run `handsim grasp --task {name}` once")
    scene = Scene.build(task, conditions)
    run = run_plan(controller, scene, plan)
    return scene.hand.model, run.time - run.time[0], run.qpos


def _sweep(controller: GraspController) -> tuple[mujoco.MjModel, np.ndarray, np.ndarray]:
    """Return each component going to two standard deviations either way and back to the mean."""
    reach = 2.0 * np.sqrt(controller.subspace.explained_variance_)
    phase = np.linspace(0, 2 * np.pi, round(SWEEP_S * RATE), endpoint=False)
    z = np.concatenate([np.outer(np.sin(phase), row) for row in np.diag(reach)])
    moments = np.arange(len(z)) / RATE
    clip = posture_clip(moments, controller.subspace.inverse_transform(z), posture_model())
    return clip.model, moments, clip.qpos

import socket
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.viewing.live.page import LivePage
from handsim.viewing.live.shown import ShownController

TASK = "cube-raise"


def scripted(name: str, conditions: Conditions) -> GraspPlan | None:
    """The demonstrator's plan of one task, for any hand; no other is known."""
    if name != TASK:
        return None
    return scripted_plan(task_by_name(name), HandModel.from_spec(build_hand(conditions.hand)))[0]


def _shown(name: str = "hand", **changed: object) -> ShownController:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    return replace(ShownController(name, controller, scripted), **changed)


@pytest.fixture
def shown() -> Callable[..., ShownController]:
    """Makes what a page shows: the built-in controller by a name, or something of it changed."""
    return _shown


@pytest.fixture
def port() -> int:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.fixture
def live(port: int) -> Iterator[LivePage]:
    page = LivePage([_shown()], port=port)
    yield page
    page.close()


@pytest.fixture
def on_screen() -> Callable[[LivePage, np.ndarray], tuple[float, float]]:
    """Where a browser of the usual size shows a point of the page [px]."""

    def placed(page: LivePage, point: np.ndarray) -> tuple[float, float]:
        (client,) = page._server.get_clients().values()
        camera = client.camera
        forward = np.array(camera.look_at) - camera.position
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        up, away = np.cross(right, forward), point - camera.position
        scale = 0.5 * camera.image_height / np.tan(0.5 * camera.fov) / (away @ forward)
        x = 0.5 * camera.image_width + scale * (away @ right)
        return float(x), float(0.5 * camera.image_height - scale * (away @ up))

    return placed

"""The page's controls, moved as its server sees them and as a person does in a browser."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import MissingToolError, UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.viewing.live.page import NO_TASK, LivePage

TASK = "cube-raise"


def scripted(name: str, conditions: Conditions) -> GraspPlan | None:
    """The demonstrator's plan of one task, for any hand; no other is known."""
    if name != TASK:
        return None
    return scripted_plan(task_by_name(name), HandModel.from_spec(build_hand(conditions.hand)))[0]


@pytest.fixture
def live() -> Iterator[LivePage]:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    page = LivePage(controller, scripted, port=port)
    yield page
    page.close()


def tip(page: LivePage) -> np.ndarray:
    """Where the page has the index finger's last segment."""
    body = page._model.body("index_distal").id
    return np.array(page._bodies[body].position)


def press(page: LivePage, name: str) -> None:
    page._pressed[name] = True
    page.step(0.0)


def test_sliders_move_hand_and_change_its_size(live: LivePage) -> None:
    mean = tip(live)
    live._components[0].value = 40.0
    live.step(0.0)
    q = live._controller.subspace.inverse_transform(np.deg2rad([40.0, 0.0, 0.0]))
    index = [live._model.joint(name).qposadr[0] for name in ("index_mcp", "index_pip")]
    assert live._data.qpos[index] == pytest.approx(q[[4, 5]])
    mujoco.mj_kinematics(live._model, live._data)
    np.testing.assert_allclose(tip(live), live._data.body("index_distal").xpos, atol=1e-6)
    assert np.linalg.norm(tip(live) - mean) > 0.01
    live._components[0].value = 0.0
    live.step(0.0)
    np.testing.assert_allclose(tip(live), mean, atol=1e-6)
    live._length.value = 215
    live.step(0.0)
    assert tip(live)[2] > mean[2] + 0.005


def test_a_grasp_is_played_paused_and_replayed(live: LivePage) -> None:
    live._task.value = TASK
    live.step(0.0)
    assert "press play" in live._status.content
    press(live, "play")
    run = live._run
    assert run is not None
    assert run.task == TASK
    for _ in range(10):
        live.step(0.1)
    assert live._slider.value == pytest.approx(1.0)
    press(live, "pause")
    live.step(0.5)
    assert live._slider.value == pytest.approx(1.0)
    live._slider.value = 3.0
    live.step(0.0)
    assert "3.00 s" in live._status.content
    cube = live._model.body("object").id
    i = int(np.searchsorted(run.time - run.time[0], 3.0))
    np.testing.assert_allclose(live._bodies[cube].position, run.qpos[i, :3], atol=1e-6)
    press(live, "replay")
    live.step(100.0)
    assert live._slider.value == pytest.approx(run.time[-1] - run.time[0], abs=0.01)
    assert not live._playing
    assert live._run is run, "it is simulated once"


def bodies(live: LivePage) -> list[str]:
    return [live._model.body(i).name for i in range(live._model.nbody)]


def test_moving_a_component_leaves_the_task(live: LivePage) -> None:
    live._task.value = TASK
    live.step(0.0)
    assert "object" in bodies(live)
    live._components[1].value = 10.0
    live.step(0.0)
    assert "object" not in bodies(live)
    assert live._task.value == NO_TASK


def test_an_object_offers_its_tasks(live: LivePage) -> None:
    live._object.value = "cup"
    live.step(0.0)
    assert live._task.options[1:] == ("cup-drink", "cup-side-move", "cup-top-move",
                                      "cup-side-rotate")  # fmt: skip
    assert live._task.value == "cup-drink"
    live._object.value = "all"
    live.step(0.0)
    assert len(live._task.options) == 25


def test_what_cannot_be_played_is_said(live: LivePage) -> None:
    press(live, "play")
    assert "Choose a task" in live._status.content
    live._task.value = "jar-move"
    live.step(0.0)
    press(live, "play")
    assert "handsim grasp --task jar-move" in live._status.content
    live._length.value, live._breadth.value = 220, 65
    live.step(0.0)
    assert live._status.content


def test_a_page_can_begin_with_a_task() -> None:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    with pytest.raises(UnknownNameError, match="cube-raise"):
        LivePage(controller, scripted, task="cube-rase")


def test_without_viser_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    with pytest.raises(MissingToolError, match=r"pip install 'handsim\[viewer\]'"):
        LivePage(controller, scripted)


def test_a_person_moves_the_hand_and_plays_a_grasp(live: LivePage, browser, tmp_path: Path) -> None:
    def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end
            live.step(0.1)
            time.sleep(0.05)

    def hand_seen() -> np.ndarray:
        return browser.screenshot(tmp_path / "shot.png")[150:750, 350:850].astype(int)

    browser.visit(live.address)
    until(lambda: "PC 1 [deg]" in browser.evaluate("document.body.innerText"))
    until(lambda: hand_seen().std() > 10)  # white before the hand is there
    before = hand_seen()
    browser.type_into("PC 1 [deg]", "40")
    until(lambda: live._components[0].value == 40.0)
    until(lambda: np.abs(hand_seen() - before).mean() > 1)
    browser.choose("object", "cube")
    until(lambda: live._task.value == TASK)
    browser.press("play")
    until(lambda: "contact forces" in browser.evaluate("document.body.innerText"))
    until(lambda: live._time > 1.0)
    browser.press("pause")
    until(lambda: not live._playing)
    assert [said for said in browser.complaints() if "exceptionDetails" in said] == []
    assert all(url.startswith(live.address) for url in browser.requests())

"""The page's controls, moved as its server sees them and as a person does in a browser."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError, MissingToolError, UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import JOINT_NAMES
from handsim.learning.controller import GraspController
from handsim.recordings.folder import read_recordings
from handsim.tasks.table_one import task_by_name
from handsim.viewing.live.page import NO_TASK, LivePage

TASK = "cube-raise"


def scripted(name: str, conditions: Conditions) -> GraspPlan | None:
    """The demonstrator's plan of one task, for any hand; no other is known."""
    if name != TASK:
        return None
    return scripted_plan(task_by_name(name), HandModel.from_spec(build_hand(conditions.hand)))[0]


@pytest.fixture
def port() -> int:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.fixture
def live(port: int) -> Iterator[LivePage]:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    page = LivePage(controller, scripted, port=port)
    yield page
    page.close()


def tip(page: LivePage) -> np.ndarray:
    """Where the page has the index finger's last segment."""
    body = page._model.body("index_distal").id
    return np.array(page._puppet.bodies[body].position)


def press(page: LivePage, name: str) -> None:
    page._pressed[name] = True
    page.step(0.0)


def test_sliders_move_hand_and_change_its_size(live: LivePage) -> None:
    mean = tip(live)
    live._panel.components[0].value = 40.0
    live.step(0.0)
    q = live._controller.subspace.inverse_transform(np.deg2rad([40.0, 0.0, 0.0]))
    index = [live._model.joint(name).qposadr[0] for name in ("index_mcp", "index_pip")]
    assert live._puppet.data.qpos[index] == pytest.approx(q[[4, 5]])
    mujoco.mj_kinematics(live._model, live._puppet.data)
    np.testing.assert_allclose(tip(live), live._puppet.data.body("index_distal").xpos, atol=1e-6)
    assert np.linalg.norm(tip(live) - mean) > 0.01
    live._panel.components[0].value = 0.0
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
    assert live._forces.content.count(" N</span>") == 6, "a row for each part"
    cube = live._model.body("object").id
    i = int(np.searchsorted(run.time - run.time[0], 3.0))
    np.testing.assert_allclose(live._puppet.bodies[cube].position, run.qpos[i, :3], atol=1e-6)
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
    live._panel.components[1].value = 10.0
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


def test_the_hand_follows_what_is_dragged(live: LivePage) -> None:
    panel, subspace = live._panel, live._controller.subspace
    live.step(0.0)
    mean, at_start = tip(live), panel.state.start
    place = np.array(panel.scene.goal.position) + [0.01, 0.005, 0.0]
    panel.scene.goal.position = place
    live.step(0.0)
    goal = panel.scene.frame.to_subspace(place, panel.state.goal)
    np.testing.assert_allclose(panel.state.goal, goal)
    np.testing.assert_allclose(panel.posture, subspace.inverse_transform(goal))
    assert np.linalg.norm(tip(live) - mean) > 0.01
    np.testing.assert_allclose(panel.path[[0, -1]], [at_start, goal])
    panel.scene.start.position = np.array(panel.scene.start.position) + [0.0, 0.0, 0.02]
    live.step(0.0)
    assert panel.state.at == "start"
    assert panel.components[2].value == pytest.approx(np.rad2deg(panel.state.start[2]), abs=0.051)
    np.testing.assert_allclose(panel.state.goal, goal, err_msg="the destination stays")
    panel.share.value = 0.5
    live.step(0.0)
    assert "50 % of the way" in live._status.content
    before = tip(live)
    live.step(0.0)
    np.testing.assert_array_equal(tip(live), before)


def test_the_text_of_a_view_shows_it_again_elsewhere(live: LivePage) -> None:
    live._panel.share.value = 0.3
    live._panel.field.value = "φ"
    live._panel.components[0].value = 12.3
    live.step(0.0)
    text, seen = live._panel.text.value, tip(live)
    live._panel.components[0].value = 40.0
    live.step(0.0)
    assert np.linalg.norm(tip(live) - seen) > 0.005
    live._panel.text.value = text
    live.step(0.0)
    np.testing.assert_allclose(tip(live), seen, atol=1e-4)
    assert live._panel.field.value == "φ"
    live._panel.text.value = "?share=9"
    live.step(0.0)
    assert "give 0 to 1" in live._status.content


def test_a_recording_stands_beside_the_hand_as_a_ghost(port: int) -> None:
    recordings = tuple(read_recordings(data_folder("assets") / "experiments"))[:2]
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    name = recordings[1].name
    page = LivePage(
        controller, scripted, port=port, recordings=recordings, text=f"recording={name}&share=1"
    )
    try:
        page.step(0.0)
        page._panel.share.value = 0.999
        page.step(0.0)
        assert page._ghost is not None
        index = page._model.joint("index_pip").qposadr[0]
        expected = recordings[1].q[-1, JOINT_NAMES.index("index_pip")]
        assert page._ghost.data.qpos[index] == pytest.approx(expected, abs=0.05)
        page._panel.recording.value = "none"
        page.step(0.0)
        assert not page._ghost._root.visible
    finally:
        page.close()


def test_a_text_that_is_no_view_ends_the_server(port: int) -> None:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    with pytest.raises(InputError, match="'colour'"):
        LivePage(controller, scripted, port=port, text="colour=red")
    with socket.socket() as again:
        again.bind(("127.0.0.1", port))


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
    until(lambda: live._panel.components[0].value == 40.0)
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

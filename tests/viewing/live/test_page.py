"""The page's controls, moved as its server sees them and as a person does in a browser."""

import socket
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError, MissingToolError, UnknownNameError
from handsim.files import data_folder
from handsim.joints import JOINT_NAMES
from handsim.recordings.folder import read_recordings
from handsim.viewing.live.grasp_stage import NO_TASK
from handsim.viewing.live.page import LivePage

TASK = "cube-raise"


def tip(page: LivePage) -> np.ndarray:
    """Where the page has the index finger's last segment."""
    puppet = page.postures.puppets[0]
    return np.array(puppet.bodies[puppet.model.body("index_distal").id].position)


def press(page: LivePage, name: str) -> None:
    page.grasps.pressed[name] = True
    page.step(0.0)


def test_sliders_move_hand_and_change_its_size(live: LivePage) -> None:
    mean = tip(live)
    live.panel.components[0].value = 40.0
    live.step(0.0)
    q = live.panel._controllers[0].subspace.inverse_transform(np.deg2rad([40.0, 0.0, 0.0]))
    puppet = live.postures.puppets[0]
    index = [puppet.model.joint(name).qposadr[0] for name in ("index_mcp", "index_pip")]
    assert puppet.data.qpos[index] == pytest.approx(q[[4, 5]])
    mujoco.mj_kinematics(puppet.model, puppet.data)
    np.testing.assert_allclose(tip(live), puppet.data.body("index_distal").xpos, atol=1e-6)
    assert np.linalg.norm(tip(live) - mean) > 0.01
    live.panel.components[0].value = 0.0
    live.step(0.0)
    np.testing.assert_allclose(tip(live), mean, atol=1e-6)
    live.length.value = 215
    live.step(0.0)
    assert tip(live)[2] > mean[2] + 0.005


def test_a_grasp_is_played_paused_and_replayed(live: LivePage) -> None:
    live.grasps.task.value = TASK
    live.step(0.0)
    assert "drag the object" in live.status.content
    press(live, "grasp")
    (run,) = live.grasps.runs
    assert run is not None
    assert run.task == TASK
    for _ in range(10):
        live.step(0.1)
    assert live.grasps.slider.value == pytest.approx(1.0)
    press(live, "pause")
    live.step(0.5)
    assert live.grasps.slider.value == pytest.approx(1.0)
    live.grasps.slider.value = 3.0
    live.step(0.0)
    assert "3.00 s" in live.status.content
    assert live.grasps.forces.content.count(" N</span>") == 6, "a row for each part"
    puppet = live.grasps.puppets[0]
    cube = puppet.model.body("object").id
    i = int(np.searchsorted(run.time - run.time[0], 3.0))
    np.testing.assert_allclose(puppet.bodies[cube].position, run.qpos[i, :3], atol=1e-6)
    press(live, "replay")
    live.step(100.0)
    assert live.grasps.slider.value == pytest.approx(run.time[-1] - run.time[0], abs=0.01)
    assert not live.grasps.playing
    assert live.grasps.runs[0] is run, "it is simulated once"


def bodies(live: LivePage) -> list[str]:
    puppets = (*live.postures.puppets, *live.grasps.puppets)
    return [each.model.body(i).name for each in puppets for i in range(each.model.nbody)]


def test_moving_a_component_leaves_the_task(live: LivePage) -> None:
    live.grasps.task.value = TASK
    live.step(0.0)
    assert "object" in bodies(live)
    live.panel.components[1].value = 10.0
    live.step(0.0)
    assert "object" not in bodies(live)
    assert live.grasps.task.value == NO_TASK


def test_an_object_offers_its_tasks(live: LivePage) -> None:
    live.grasps.object.value = "cup"
    live.step(0.0)
    assert live.grasps.task.options[1:] == ("cup-drink", "cup-side-move", "cup-top-move",
                                      "cup-side-rotate")  # fmt: skip
    assert live.grasps.task.value == "cup-drink"
    live.grasps.object.value = "all"
    live.step(0.0)
    assert len(live.grasps.task.options) == 25


def test_the_hand_follows_what_is_dragged(live: LivePage) -> None:
    panel, subspace = live.panel, live.panel._controllers[0].subspace
    live.step(0.0)
    mean, at_start = tip(live), panel.state.start
    place = np.array(panel.scene.goal.position) + [0.01, 0.005, 0.0]
    panel.scene.goal.position = place
    live.step(0.0)
    goal = panel.scene.frame.to_subspace(place, panel.state.goal)
    np.testing.assert_allclose(panel.state.goal, goal)
    np.testing.assert_allclose(panel.postures[0], subspace.inverse_transform(goal))
    assert np.linalg.norm(tip(live) - mean) > 0.01
    np.testing.assert_allclose(panel.paths[0][[0, -1]], [at_start, goal])
    panel.scene.start.position = np.array(panel.scene.start.position) + [0.0, 0.0, 0.02]
    live.step(0.0)
    assert panel.state.at == "start"
    assert panel.components[2].value == pytest.approx(np.rad2deg(panel.state.start[2]), abs=0.051)
    np.testing.assert_allclose(panel.state.goal, goal, err_msg="the destination stays")
    panel.share.value = 0.5
    live.step(0.0)
    assert "50 % of the way" in live.status.content
    before = tip(live)
    live.step(0.0)
    np.testing.assert_array_equal(tip(live), before)


def test_the_text_of_a_view_shows_it_again_elsewhere(live: LivePage) -> None:
    live.panel.share.value = 0.3
    live.panel.field.value = "φ"
    live.panel.components[0].value = 12.3
    live.step(0.0)
    text, seen = live.link.value, tip(live)
    live.panel.components[0].value = 40.0
    live.step(0.0)
    assert np.linalg.norm(tip(live) - seen) > 0.005
    live.link.value = text
    live.step(0.0)
    np.testing.assert_allclose(tip(live), seen, atol=1e-4)
    assert live.panel.field.value == "φ"
    live.link.value = "?share=9"
    live.step(0.0)
    assert "give 0 to 1" in live.status.content


def test_a_recording_stands_beside_the_hand_as_a_ghost(port: int, shown) -> None:
    recordings = tuple(read_recordings(data_folder("assets") / "experiments"))[:2]
    name = recordings[1].name
    page = LivePage([shown(recordings=recordings)], port=port, text=f"recording={name}&share=1")
    try:
        page.step(0.0)
        page.panel.share.value = 0.999
        page.step(0.0)
        ghost = page.postures.ghost
        assert ghost is not None
        index = ghost.model.joint("index_pip").qposadr[0]
        expected = recordings[1].q[-1, JOINT_NAMES.index("index_pip")]
        assert ghost.data.qpos[index] == pytest.approx(expected, abs=0.05)
        page.panel.recording.value = "none"
        page.step(0.0)
        assert not ghost._root.visible
    finally:
        page.close()


def test_a_text_that_is_no_view_ends_the_server(port: int, shown) -> None:
    with pytest.raises(InputError, match="'colour'"):
        LivePage([shown()], port=port, text="colour=red")
    with socket.socket() as again:
        again.bind(("127.0.0.1", port))


def test_what_cannot_be_played_is_said(live: LivePage) -> None:
    press(live, "grasp")
    assert "Choose a task" in live.status.content
    live.grasps.task.value = "jar-move"
    live.step(0.0)
    press(live, "grasp")
    assert "handsim grasp --task jar-move" in live.status.content
    live.length.value, live.breadth.value = 220, 65
    live.step(0.0)
    assert live.status.content


def test_a_page_can_begin_with_a_task(shown) -> None:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    with pytest.raises(UnknownNameError, match="cube-raise"):
        LivePage([shown()], task="cube-rase")


def test_without_viser_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch, shown) -> None:
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    with pytest.raises(MissingToolError, match=r"pip install 'handsim\[viewer\]'"):
        LivePage([shown()])


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
    until(lambda: live.panel.components[0].value == 40.0)
    until(lambda: np.abs(hand_seen() - before).mean() > 1)
    browser.choose("object", "cube")
    until(lambda: live.grasps.task.value == TASK)
    until(lambda: "pause" in browser.evaluate("document.body.innerText"))
    browser.press("grasp")
    until(lambda: "palm" in browser.evaluate("document.body.innerText"))
    until(lambda: live.grasps.time > 1.0)
    browser.press("pause")
    until(lambda: not live.grasps.playing)
    assert [said for said in browser.complaints() if "exceptionDetails" in said] == []
    assert all(url.startswith(live.address) for url in browser.requests())

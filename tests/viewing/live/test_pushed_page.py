"""A finger is pushed on the page, and the loop brings it back."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from handsim.viewing.live.page import LivePage
from handsim.viewing.live.pushing.push_controls import Grab


def run(page: LivePage, seconds: float) -> None:
    for _ in range(round(30 * seconds)):
        page.step(1 / 30)


def tip(page: LivePage) -> np.ndarray:
    """Where the index finger's last segment is on the page."""
    puppet = page.postures.puppets[0]
    return np.array(puppet.bodies[puppet.model.body("index_distal").id].position) + puppet.origin


@pytest.fixture
def looping(live: LivePage) -> LivePage:
    live.pushing.running.value = True
    run(live, 2.0)
    return live


def test_the_hand_moves_to_its_destination_in_physics(looping: LivePage) -> None:
    (loop,) = looping.postures.loops
    goal = looping.panel.state.goal
    assert np.linalg.norm(loop.place - goal) < np.deg2rad(1)
    here = looping.panel.scene.frame.to_page(loop.place[None])[0]
    np.testing.assert_allclose(looping.panel.scene._here.position, here)
    assert "loop=1" in looping.link.value


def test_a_button_pushes_a_finger_and_what_it_did_is_said(looping: LivePage) -> None:
    looping.pushing.force.value = 30.0
    before = tip(looping)
    looping.pushing.asked.append("index")
    run(looping, 0.2)
    assert np.linalg.norm(tip(looping) - before) > 0.005
    assert looping.status.content.startswith("Pushed with 30 N")
    run(looping, 1.0)
    np.testing.assert_allclose(tip(looping), before, atol=1e-3)
    assert "back within 0.5 deg" in looping.status.content
    assert "<svg" in looping.pushing._trace.content


def test_a_pointer_pulls_until_it_lets_go(looping: LivePage) -> None:
    body = looping.postures.puppets[0].model.body("index_distal").id
    before = tip(looping)
    looping.pushing.grabs[0] = Grab(0, body, before, before + [0.1, 0.0, 0.0], begins=True)
    run(looping, 0.3)
    assert tip(looping)[0] > before[0] + 0.003
    assert set(looping.postures._lines) == {0}
    looping.pushing.grabs[0] = None
    run(looping, 1.0)
    np.testing.assert_allclose(tip(looping), before, atol=1e-3)
    assert looping.postures._lines == {}


def test_the_loop_begins_by_itself_when_a_finger_is_pushed(live: LivePage) -> None:
    live.step(0.0)
    assert live.postures.loops == []
    live.pushing.asked.append("thumb")
    run(live, 1.0)
    assert live.pushing.running.value
    assert "Pushed with 20 N" in live.status.content
    live.pushing.running.value = False
    run(live, 0.1)
    assert live.postures.loops == []
    live.pushing.grabs[0] = Grab(0, 5, np.zeros(3), np.zeros(3), begins=True)
    run(live, 0.1)
    assert live.postures.loops != []


def test_slow_motion_and_another_start(looping: LivePage) -> None:
    (loop,) = looping.postures.loops
    looping.pushing.speed.value = 0.1
    before = loop.time
    run(looping, 1.0)
    assert loop.time - before == pytest.approx(0.1, abs=0.011)
    looping.pushing.restart = True
    looping.step(0.0)
    assert looping.postures.loops[0].time == 0.0


def test_the_loop_goes_on_to_a_destination_that_is_dragged(looping: LivePage) -> None:
    (loop,) = looping.postures.loops
    goal = looping.panel.scene.goal
    goal.position = np.array(goal.position) + [-0.03, 0.0, 0.0]
    run(looping, 2.0)
    assert looping.postures.loops == [loop]
    assert np.linalg.norm(loop.place - looping.panel.state.goal) < np.deg2rad(1)
    looping.panel.components[0].value = 20.0
    looping.step(1 / 30)
    assert looping.postures.loops != [loop], "from another start it begins again"
    looping.pushing.running.value = False
    looping.step(0.0)
    assert looping.postures.loops == []


@pytest.mark.slow
@pytest.mark.ci
def test_a_person_pulls_at_a_fingertip(
    live: LivePage, browser, on_screen: Callable, tmp_path: Path
) -> None:
    def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end
            live.step(1 / 30)
            time.sleep(0.03)

    browser.visit(live.address + "/?loop=1")
    until(lambda: bool(live.postures.loops) and live.postures.loops[0].time > 2)
    until(lambda: browser.screenshot(tmp_path / "s.png")[150:750, 350:850].std() > 10)
    place, before = on_screen(live, tip(live)), tip(live)
    browser.mouse("Moved", place)
    browser.mouse("Pressed", place)
    for step in range(1, 6):
        browser.mouse("Moved", (place[0] + 20 * step, place[1]))
        live.step(1 / 30)
    until(lambda: live.pushing.grabs.get(0) is not None)
    until(lambda: np.linalg.norm(tip(live) - before) > 0.003)
    browser.mouse("Released", (place[0] + 100, place[1]))
    until(lambda: live.pushing.grabs.get(0) is None)
    until(lambda: "back within" in live.status.content)
    run(live, 1.0)
    np.testing.assert_allclose(tip(live), before, atol=2e-3)

"""An object is put elsewhere on the table, and grasped there."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from handsim.viewing.live.page import LivePage
from handsim.viewing.live.table_place import TablePlace

TASK = "cube-raise"


@pytest.fixture
def table(live: LivePage) -> LivePage:
    live.grasps.choose(TASK)
    live.step(0.0)
    return live


def cube(page: LivePage) -> np.ndarray:
    puppet = page.grasps.puppets[0]
    return np.array(puppet.bodies[puppet.model.body("object").id].position)


def test_a_grasp_is_made_where_the_object_was_put(table: LivePage) -> None:
    before = cube(table)
    table.grasps.put(TablePlace(-60, -80, 10))
    table.step(0.0)
    np.testing.assert_allclose(cube(table) - before, [-0.06, -0.08, 0.0], atol=1e-9)
    assert "at -60, -80 mm, +10 deg" in table.status.content
    table.grasps.pressed["grasp"] = True
    table.step(0.0)
    (run,) = table.grasps.runs
    assert run is not None
    assert run.outcome.success
    np.testing.assert_allclose(run.qpos[0, :2] - before[:2], [-0.06, -0.08], atol=1e-4)
    table.step(100.0)
    assert "success" in table.status.content
    assert cube(table)[2] > before[2] + 0.1
    table.grasps.put(TablePlace())
    table.step(0.0)
    assert table.grasps.runs == [], "what was simulated was elsewhere"
    np.testing.assert_allclose(cube(table), before, atol=1e-9)


def test_where_no_arm_gets_is_said_before_the_grasp(table: LivePage) -> None:
    assert "arm" not in table.status.content
    table.grasps.put(TablePlace(150, 0, 90))
    table.step(0.0)
    assert "No arm reaches it" in table.status.content


def test_the_pointer_drags_the_object_and_turns_it(table: LivePage) -> None:
    before, camera = cube(table), np.array([0.4, 0.4, 0.5])
    grabbed = before + [0.0, 0.0, 0.02]
    for phase, pointer in (
        ("start", grabbed), ("update", grabbed + [0.05, 0, 0]), ("end", grabbed + [0.04, 0.02, 0]),
    ):  # fmt: skip
        table.grasps.drags.append((phase, grabbed, pointer, camera, False))
        table.step(0.0)
    assert table.grasps.place == TablePlace(40, 20, 0)
    np.testing.assert_allclose(cube(table) - before, [0.04, 0.02, 0.0], atol=1e-9)
    side = cube(table) + [0.03, 0.0, 0.02]
    for phase, pointer in (("start", side), ("end", cube(table) + [0.0, 0.03, 0.02])):
        table.grasps.drags.append((phase, side, pointer, camera, True))
    table.step(0.0)
    assert table.grasps.place == TablePlace(40, 20, 90)


@pytest.mark.slow
def test_a_person_drags_the_cube(
    table: LivePage, browser, on_screen: Callable, tmp_path: Path
) -> None:
    def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end
            table.step(1 / 30)
            time.sleep(0.03)

    browser.visit(table.address)
    until(lambda: "drag the object" in browser.evaluate("document.body.innerText"))
    until(lambda: browser.screenshot(tmp_path / "s.png")[300:700, 350:850].std() > 10)
    place = on_screen(table, cube(table) + [0.0, 0.0, 0.02])
    wanted = on_screen(table, cube(table) + [-0.05, -0.08, 0.02])
    browser.mouse("Moved", place)
    browser.mouse("Pressed", place)
    for x, y in np.linspace(place, wanted, 9)[1:].tolist():
        browser.mouse("Moved", (x, y))
        table.step(1 / 30)
    until(lambda: table.grasps.place != TablePlace())
    browser.mouse("Released", wanted)
    until(lambda: table.grasps._held is None and not table.grasps.drags)
    found = table.grasps.place
    assert found.x == pytest.approx(-50, abs=15)
    assert found.y == pytest.approx(-80, abs=15)

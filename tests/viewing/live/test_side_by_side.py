"""Two controllers stand side by side, and links show the same again."""

import time
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_controller
from handsim.navigation.paths import at_arc_length
from handsim.recordings.folder import read_recordings
from handsim.viewing.live.page import MOST_SHOWN, LivePage
from handsim.viewing.live.posture_stage import joint_difference
from handsim.viewing.live.shown import ShownController
from handsim.viewing.live.subspace.subspace_state import (
    SubspaceState,
    carried_over,
    seen_from,
)
from handsim.viewing.live.table_place import TablePlace

Make = Callable[..., ShownController]


@pytest.fixture(scope="module")
def other() -> GraspController:
    """A controller with another subspace, of two components."""
    recordings = tuple(read_recordings(data_folder("assets") / "experiments"))[::2]
    return learn_controller(recordings, 2, guided=False, certified=False).controller


@pytest.fixture
def pair(
    port: int, shown: Callable[..., ShownController], other: GraspController
) -> Iterator[LivePage]:
    first = shown("first")
    page = LivePage([first, replace(first, name="second", controller=other)], port=port)
    yield page
    page.close()


def test_another_subspace_gets_the_same_postures_as_far_as_it_can(
    shown: Callable[..., ShownController], other: GraspController
) -> None:
    first = shown().controller
    state = SubspaceState(np.zeros(3), first.demonstrations[0].z_goal, 0.5, "way")
    same, said = carried_over(state, first, first)
    assert same is state
    assert said == ""
    carried, said = carried_over(state, first, other)
    goal = first.subspace.inverse_transform(state.goal)
    np.testing.assert_allclose(carried.goal, other.subspace.transform(goal))
    off = np.abs(other.subspace.inverse_transform(carried.goal) - goal).max()
    assert said == f"Its ends are up to {np.rad2deg(off):.0f} deg from the first one's."
    assert (carried.share, carried.at) == (0.5, "way")
    seen = seen_from(first, other, carried.goal[None])[0]
    q = other.subspace.inverse_transform(carried.goal)
    np.testing.assert_allclose(seen, first.subspace.transform(q))


def test_both_hands_go_the_same_share_of_their_ways(pair: LivePage, other: GraspController) -> None:
    pair.panel.share.value = 0.5
    pair.step(0.0)
    first, second = pair.postures.puppets
    assert np.linalg.norm(second.origin - first.origin) > 0.15
    assert [label.text for label in pair.postures._labels] == ["first", "second"]
    place = at_arc_length(pair.panel.paths[1], np.array([0.5]))[0]
    np.testing.assert_allclose(pair.panel.postures[1], other.subspace.inverse_transform(place))
    assert not np.allclose(first.data.qpos, second.data.qpos, atol=0.02)
    assert "They differ by up to" in pair.status.content
    q = pair.panel.postures[0]
    assert joint_difference([q]) == ""
    assert joint_difference([q, q]) == "They are the same."
    assert (
        joint_difference([q, q + np.eye(22)[5] * 0.2]) == "They differ by up to 11 deg (index_pip)."
    )


def test_both_are_pushed_and_both_come_back(pair: LivePage) -> None:
    pair.pushing.running.value = True
    for _ in range(60):
        pair.step(1 / 30)
    pair.pushing.asked.append("ring")
    for _ in range(40):
        pair.step(1 / 30)
    said = pair.status.content.splitlines()
    assert [line.split(":")[0] for line in said] == ["first", "second"]
    assert all("back within" in line for line in said)


def test_both_grasp_the_same_thing_each_by_its_plan(
    port: int, shown: Callable[..., ShownController]
) -> None:
    def nothing(*_: object) -> None:
        return None

    page = LivePage([shown("one"), shown("none", plans=nothing)], port=port, task="cube-raise")
    try:
        page.step(0.0)
        page.grasps.pressed["grasp"] = True
        page.step(0.0)
        page.step(3.0)
        known, missing = page.grasps.runs
        assert known is not None
        assert missing is None
        assert "one: success" in page.status.content
        assert "none: no plan is stored" in page.status.content
        one, _ = page.grasps.puppets
        i = int(np.searchsorted(known.time - known.time[0], 3.0))
        np.testing.assert_array_equal(one.data.qpos, known.qpos[i])
    finally:
        page.close()


def test_a_link_that_is_opened_shows_the_same_again(live: LivePage) -> None:
    live.grasps.choose("cube-raise")
    live.step(0.0)
    live.grasps.put(TablePlace(-50, -40, 5))
    live.step(0.0)
    live.grasps.grasp()
    live.grasps.playing = False
    live.grasps.go_to(2.0)
    live._camera._seen = (0.0, (0.6, 0.5, 0.4, 0.0, 0.0, 0.1))
    live.step(0.0)
    link = live.link.value
    assert link.startswith(live.address + "/?")
    seen = live.grasps.puppets[0].data.qpos.copy()
    live.grasps.choose("none")
    live.panel.components[0].value = 33.0
    live.step(0.0)
    assert live.link.value != link
    with urllib.request.urlopen(link) as answer:
        assert answer.status == 200
    live.step(0.0)
    assert live.link.value == link
    np.testing.assert_array_equal(live.grasps.puppets[0].data.qpos, seen)
    np.testing.assert_allclose(live._server.initial_camera.position, [0.6, 0.5, 0.4])
    assert f'href="/?{link.partition("?")[2].replace("&", "&amp;")}"' in live.link_shown.content


def test_links_tell_a_camera_that_was_moved_once_it_stands_still(live: LivePage) -> None:
    live.step(0.0)
    usual = (*live._camera._usual[0], *live._camera._usual[1])
    live._camera._seen = (time.monotonic(), (0.5, *usual[1:]))
    live.step(0.0)
    assert "camera" not in live.link.value, "it is still on its way"
    live._camera._seen = (0.0, (0.5, *usual[1:]))
    live.step(0.0)
    assert "camera=0.500," in live.link.value
    live._camera._seen = (0.0, usual)
    live.step(0.0)
    assert "camera" not in live.link.value


def test_a_link_that_makes_no_sense_changes_nothing(live: LivePage) -> None:
    live.step(0.0)
    link = live.link.value
    with urllib.request.urlopen(live.address + "/?hand=160,80&goal=1,2"):
        pass
    live.step(0.0)
    assert "goal '1,2'" in live.status.content
    assert live.length.value == 193
    assert live.link.value == link


def test_a_browser_opens_a_link(live: LivePage, browser, tmp_path: Path) -> None:
    link = live.address + "/?task=cube-raise&object=-30,0,0&time=1.00&camera=0.9,0,0.5,0,0,0.1"
    browser.visit(link)
    end = time.monotonic() + 60
    while "1.00 s" not in browser.evaluate("document.body.innerText"):
        assert time.monotonic() < end
        live.step(1 / 30)
        time.sleep(0.05)
    assert live.grasps.place == TablePlace(-30, 0, 0)
    (client,) = live._server.get_clients().values()
    while not np.allclose(client.camera.position, [0.9, 0.0, 0.5], atol=1e-3):
        assert time.monotonic() < end
        live.step(1 / 30)
        time.sleep(0.05)
    for _ in range(20):
        live.step(1 / 30)
        time.sleep(0.05)
    assert "camera=0.900,0.000,0.500,0.000,0.000,0.100" in live.link.value
    assert browser.evaluate("document.querySelector('a[href^=\"/?\"]').href").startswith(
        live.address
    )


def test_too_many_are_refused(shown: Callable[..., ShownController]) -> None:
    pytest.importorskip("viser", reason="comes with handsim[viewer]")
    with pytest.raises(InputError, match=f"give 1 to {MOST_SHOWN}"):
        LivePage([shown()] * (MOST_SHOWN + 1))

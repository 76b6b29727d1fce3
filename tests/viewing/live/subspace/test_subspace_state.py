from urllib.parse import parse_qsl

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.learning.controller import GraspController
from handsim.recordings.recording import Recording
from handsim.types import MEDIAN_HAND
from handsim.viewing.live.force_rows import FORCE_COLOUR, force_rows
from handsim.viewing.live.subspace.subspace_state import (
    SubspaceFrame,
    SubspaceState,
    ghost_posture,
    read_state,
    state_values,
    way,
)

LOW, HIGH = np.array([-1.0, -0.5, -0.4]), np.array([2.0, 1.0, 0.8])
STATE = SubspaceState(np.array([0.1, 0.2, -0.1]), np.array([1.0, 0.0, 0.3]))


@pytest.mark.parametrize("n", [1, 2, 3])
def test_places_on_the_page_and_in_the_subspace_agree(n: int) -> None:
    frame = SubspaceFrame(LOW[:n], HIGH[:n], size=0.3)
    corners = frame.to_page(np.array([LOW[:n], HIGH[:n]]))
    assert np.ptp(corners, axis=0).max() == pytest.approx(0.3)
    np.testing.assert_allclose(corners.sum(axis=0), 0, atol=1e-12)
    z = LOW[:n] + 0.3 * (HIGH - LOW)[:n]
    np.testing.assert_allclose(frame.to_subspace(frame.to_page(z[None])[0], z), z)
    np.testing.assert_allclose(frame.to_subspace(np.full(3, 9.0), z), HIGH[:n], atol=1e-12)


def test_components_that_are_not_shown_stay() -> None:
    low, high = np.append(LOW, -1.0), np.append(HIGH, 1.0)
    z = SubspaceFrame(low, high).to_subspace(np.zeros(3), np.array([0.0, 0.0, 0.0, 0.7]))
    np.testing.assert_allclose(z, [0.5, 0.25, 0.2, 0.7])


def test_the_hand_is_where_a_control_has_moved() -> None:
    start, goal = STATE.start + 0.01, STATE.goal + 0.01
    path = np.array([STATE.start, [0.5, 0.5, 0.5], STATE.goal])
    assert STATE.moved(STATE.start, STATE.goal, 0.0).at == "start"
    dragged = STATE.moved(STATE.start, goal, 0.0)
    np.testing.assert_array_equal(dragged.place(path), goal)
    np.testing.assert_array_equal(dragged.moved(start, goal, 0.0).place(path), start)
    on_the_way = dragged.moved(STATE.start, goal, 0.25)
    assert on_the_way.at == "way"
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    expected = path[0] + 0.25 * lengths.sum() / lengths[0] * (path[1] - path[0])
    np.testing.assert_allclose(on_the_way.place(path), expected)
    assert on_the_way.moved(STATE.start, goal, 0.25).at == "way", "until something else moves"


def test_the_way_is_the_controllers_and_why_there_is_none_is_said() -> None:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    demonstration = controller.demonstrations[0]
    state = SubspaceState(demonstration.z_start, demonstration.z_goal)
    path, said = way(controller, state)
    assert said == ""
    np.testing.assert_array_equal(path, controller.path(state.start, state.goal).points)
    far = SubspaceState(state.start, state.goal + 50.0)
    path, said = way(controller, far)
    np.testing.assert_array_equal(path, [far.start, far.goal])
    assert "outside" in said


def test_the_ghost_is_the_recorded_posture_at_the_same_share_of_the_way() -> None:
    q = 0.1 * np.linspace(0, 1, 10)[:, None] * np.ones(22)
    recording = Recording("r", 0.01 * np.arange(10.0), q, 1, "a", "cube", "cube-raise", MEDIAN_HAND)
    path = np.array([[0.0], [3.0], [3.5], [4.0], *[[4.0]] * 6])
    for share, row in ((0.0, 0), (0.75, 1), (0.8, 2), (1.0, 3)):
        np.testing.assert_array_equal(ghost_posture(recording, path, share), q[row])


def test_the_text_of_a_view_brings_it_back() -> None:
    state = SubspaceState(
        np.deg2rad([1.25, -3.5, 20.0]), np.deg2rad([50.0, 0.0, -7.75]), 0.4, "way", "φ", "cup-drink"
    )
    values = state_values(state)
    read = read_state(values, STATE, LOW, HIGH)
    assert state_values(read) == values
    np.testing.assert_allclose(read.goal, state.goal)
    part = read_state({"share": "0.5"}, STATE, LOW, HIGH)
    assert (part.share, part.field) == (0.5, "none")
    np.testing.assert_array_equal(part.goal, STATE.goal)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("goal=1,2", "give 3 angles"),
        ("goal=1,2,900", "within the workspace"),
        ("start=a,b,c", "give 3 angles"),
        ("share=2", "give 0 to 1"),
        ("share=nan", "give 0 to 1"),
        ("share=x", "give 0 to 1"),
        ("at=moon", "'moon'"),
        ("field=psi", "'psi'"),
    ],
)
def test_texts_that_are_no_view(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_state(dict(parse_qsl(text)), STATE, LOW, HIGH)


def test_rows_of_forces_are_as_long_as_the_forces() -> None:
    rows = force_rows(np.array([4.0, 1.0, 0.0]), ("thumb", "<index>", "palm"), 2.0, 8.0)
    assert "width:50.0%" in rows
    assert "width:12.5%" in rows
    assert "left:25.0%" in rows
    assert "&lt;index&gt;" in rows
    assert rows.count(FORCE_COLOUR) == 2
    assert "left:" not in force_rows(np.zeros(1), ("thumb",), 0.0, 0.0)

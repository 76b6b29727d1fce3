"""What rules read from traces: rows, means, displacements and turns."""

from dataclasses import replace

import numpy as np
import pytest
from made_traces import ACTION, HOLD, carried
from scipy.spatial.transform import Rotation

from handsim.tasks.traces import AVERAGED


def quats(rotvecs: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(rotvecs).as_quat(scalar_first=True)


def test_action_and_hold_begin_with_the_sample_of_their_time():
    traces = carried()
    assert (traces.first_acting, traces.first_holding) == (ACTION, HOLD)
    between = replace(traces, action_start=1.005, hold_start=2.0 + 1e-12)
    assert (between.first_acting, between.first_holding) == (ACTION + 1, HOLD)


def test_any_part_that_presses_touches():
    traces = carried()
    force = np.zeros_like(traces.force)
    force[7, 5], force[9, 0] = 1e-9, 2.0
    assert np.flatnonzero(replace(traces, force=force).touching).tolist() == [7, 9]


def test_means_are_those_of_each_stretch_of_a_tenth_of_a_second():
    assert AVERAGED == 0.1
    traces, values = carried(), np.arange(520.0) ** 2
    means = traces.averaged(values)
    assert len(means) == 511
    for row in (0, 300, 510):
        assert means[row] == pytest.approx(values[row : row + 10].mean())
    columns = traces.averaged(np.column_stack([values, 2 * values]))
    np.testing.assert_allclose(columns, np.column_stack([means, 2 * means]))


@pytest.mark.parametrize("n", [1, 2, 9])
def test_what_is_shorter_is_averaged_whole(n):
    traces, values = replace(carried(), time=np.arange(n) / 100), np.arange(1.0, n + 1)
    np.testing.assert_allclose(traces.averaged(values), [values.mean()])


def test_other_rates_are_averaged_over_the_same_time():
    traces = replace(carried(), time=np.arange(520) / 50)
    values = np.arange(520.0)
    assert traces.averaged(values)[0] == pytest.approx(values[:5].mean())


def test_slip_is_in_the_palm_and_way_in_the_world():
    traces = carried()
    turn = np.outer(np.linspace(0, 1, 520), [0.0, 0.0, 1.2])
    palm = Rotation.from_rotvec(turn)
    pos = traces.palm_pos + palm.apply([0.1, 0.0, 0.0])
    pos[300:] += palm[300:].apply([0.0, 0.02, 0.0])
    traces = replace(traces, palm_quat=quats(turn), object_pos=pos)
    slip = traces.slip(ACTION)
    np.testing.assert_allclose(slip[:300], 0.0, atol=1e-12)
    np.testing.assert_allclose(slip[300:], 0.02)
    np.testing.assert_allclose(traces.slip(400)[:300], 0.02)
    np.testing.assert_allclose(traces.way(), np.linalg.norm(pos - pos[0], axis=1))


def test_turns_leave_out_what_the_palm_turns_from_a_row_on():
    traces = carried()
    turn = np.outer(np.linspace(0, 1, 520), [0.0, 1.0, 0.0])
    both = replace(traces, object_quat=quats(turn), palm_quat=quats(turn), symmetry=None)
    np.testing.assert_allclose(both.turn(0, None), np.linspace(0, 1, 520), atol=1e-9)
    np.testing.assert_allclose(both.turn(300, None)[[0, 300]], [300 / 519, 0.0], atol=1e-7)
    with_palm = both.turn(0, 200)
    np.testing.assert_allclose(with_palm[:200], np.linspace(0, 1, 520)[:200], atol=1e-9)
    np.testing.assert_allclose(with_palm[200:], 200 / 519, atol=1e-9)


@pytest.mark.parametrize("symmetry", [None, "x", "z"])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turns_about_an_axis_of_symmetry_do_not_count(symmetry, axis):
    traces = carried()
    turn = np.outer(np.linspace(0, 1, 520), [axis == each for each in "xyz"])
    traces = replace(traces, object_quat=quats(turn), symmetry=symmetry)
    expected = np.zeros(520) if axis == symmetry else np.linspace(0, 1, 520)
    np.testing.assert_allclose(traces.turn(0, None), expected, atol=1e-7)

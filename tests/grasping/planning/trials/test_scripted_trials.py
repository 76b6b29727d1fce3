"""How hard a script holds, searched without a change of the reach that is recorded."""

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrated_reach
from handsim.grasping.planning.demonstrator_offsets import (
    SPREADS,
    DemonstratorOffsets,
    demonstrator_offsets,
)
from handsim.grasping.planning.trials import scripted_trials
from handsim.grasping.planning.trials.scripted_trials import GRIP_CHANGES, search_grip
from handsim.recordings.folder import read_recordings
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")
START = DemonstratorOffsets.of(np.linspace(-0.2, 0.2, len(SPREADS)))
GRIP = list(SPREADS).index("grip")


def change_of(offsets: DemonstratorOffsets) -> float:
    """By how much the grip was changed, in units of its spread; nothing else may be."""
    change = offsets.point - START.point
    assert np.abs(np.delete(change, GRIP)).max() < 1e-12
    return round(float(change[GRIP]), 6)


@pytest.fixture
def runs(monkeypatch):
    """Costs of three nominal and two perturbed runs by what the grip was changed by."""
    costs = {}

    def costs_of(task, tried, offsets):
        assert [each.nominal for each in tried] == [True] * 3 + [False] * 2
        assert len({each.seed for each in tried}) == 5
        return costs.get(change_of(offsets), [2.0] * 5)

    monkeypatch.setattr(scripted_trials, "_costs_of", costs_of)
    monkeypatch.setattr(scripted_trials, "_same_reach", lambda task, one, other: True)
    return costs


def searched():
    held, offsets = search_grip(TASK, Conditions(), START, "grip", n_nominal=3, n_perturbed=2)
    return held, change_of(offsets)


def test_it_keeps_what_holds_most_often_as_it_is_then_perturbed_then_what_costs_least(runs):
    runs[0.0] = [-0.9, -0.9, 1.5, -0.9, -0.9]
    assert searched() == ((2, 2), 0.0)
    runs[0.5] = [0.5, 0.5, 0.5, 1.5, 1.5]
    assert searched() == ((3, 0), 0.5)
    runs[1.0] = [0.9, 0.9, 0.9, 0.9, 4.0]
    assert searched() == ((3, 1), 1.0)
    runs[-0.5] = [-0.1, 0.9, 0.9, 0.9, 4.0]
    assert searched() == ((3, 1), -0.5)


def test_what_would_change_the_recorded_reach_is_not_tried(runs, monkeypatch):
    runs[0.5] = [-0.9] * 5
    runs[0.25] = [0.9] * 5
    asked = []

    def same(task, one, other):
        asked.append(change_of(other))
        return task is TASK and one is START and asked[-1] != 0.5

    monkeypatch.setattr(scripted_trials, "_same_reach", same)
    assert searched() == ((3, 2), 0.25)
    np.testing.assert_allclose(asked, GRIP_CHANGES, atol=1e-6)


def test_a_reach_is_the_same_with_another_grip_and_another_with_another_palm():
    usual = DemonstratorOffsets()
    harder, aside = (
        DemonstratorOffsets.of(np.eye(len(SPREADS))[i])
        for i in (GRIP, list(SPREADS).index("beyond"))
    )
    assert scripted_trials._same_reach(TASK, usual, harder)
    assert not scripted_trials._same_reach(TASK, usual, aside)


@pytest.mark.parametrize("name", ["mouse-left-click", "scissors-use"])
def test_the_shipped_recordings_are_those_of_the_stored_offsets(name):
    """Their grips were searched after the recordings had been made.

    Readings in steps of 1 deg may flicker where another processor rounds otherwise.
    """
    shipped = read_recordings(data_folder("assets") / "experiments")
    one = next(each for each in shipped if each.name == name)
    assert name in demonstrator_offsets()
    again = demonstrated_reach(task_by_name(name))
    assert again is not None
    np.testing.assert_allclose(again.time, one.time, atol=1e-9)
    np.testing.assert_allclose(again.q, one.q, atol=np.deg2rad(1.01))
    assert np.isclose(again.q, one.q, atol=1e-9).mean() > 0.99

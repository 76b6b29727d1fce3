"""No rule of the 24 tasks passes a hand that does not grasp."""

import numpy as np
import pytest

from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.tasks.table_one import TASK_NAMES, task_by_name

from .counterfeits import DEPTHS, STIFF, arm_alone, aside, genuine, stiff

SAMPLE = ("tall-glass-drink", "mouse-slide", "pen-move", "stapler-use")
"""Tasks that are tried each time; all others are in the slow tests."""


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


def passed(task_name: str, hand: HandModel) -> list[str]:
    """Return the counterfeits that pass a task's rule."""
    task = task_by_name(task_name)
    found = [
        f"{name} {1000 * depth:+.0f} mm"
        for name in STIFF
        for depth in DEPTHS
        if stiff(task, hand, name, depth).outcome.success
    ]
    angles = np.arange(4) * np.pi / 2
    found += [
        f"aside at {np.rad2deg(angle):.0f} deg"
        for angle in angles
        if aside(task, hand, float(angle)).outcome.success
    ]
    return found + (["arm alone"] if arm_alone(task, hand).outcome.success else [])


@pytest.mark.parametrize("name", SAMPLE[:1])
def test_a_grasp_passes_where_its_counterfeits_fail(name, hand):
    task = task_by_name(name)
    assert genuine(task, hand).outcome.success
    assert not stiff(task, hand, "fist", 0.0).outcome.success
    assert not stiff(task, hand, "relaxed", 0.0).outcome.success
    assert not arm_alone(task, hand).outcome.success


@pytest.mark.slow
@pytest.mark.parametrize("name", TASK_NAMES)
def test_no_counterfeit_passes(name, hand):
    assert passed(name, hand) == []

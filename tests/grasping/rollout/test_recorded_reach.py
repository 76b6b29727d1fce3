"""The committed experiments are what the demonstrator makes.

They are compared by numbers: a reading lies on one of the glove's steps, and a last bit, which
hangs on the processor, may put one that is near the middle of two on the other.
"""

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.grasping.planning.trial_variation import trial_variation
from handsim.grasping.rollout.glove import DataGlove, recorded_reach
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import Recording
from handsim.tasks.table_one import TASK_NAMES, task_by_name

STEP = DataGlove().resolution
DIGIT = 2e-8
"""Of an angle in a file of recordings [rad]."""
OTHERWISE = 0.001
"""Greatest share of readings that may lie on the step beside: one in a thousand."""


@pytest.fixture(scope="module")
def kept() -> dict[str, Recording]:
    return {each.name: each for each in read_recordings(data_folder("assets") / "experiments")}


def made(name: str, seed: int | None = None) -> Recording:
    task = task_by_name(name)
    number = task.number if seed is None else seed
    run = demonstrate(task, Conditions(seed=number), trial_variation(task.number))
    return recorded_reach(run, task)


def differences(made: Recording, kept: Recording) -> list[str]:
    """What tells two recordings of a virtual glove apart."""
    labels = ("name", "number", "subject", "object", "task", "hand")
    found = [label for label in labels if getattr(made, label) != getattr(kept, label)]
    if made.time.shape != kept.time.shape:
        return [*found, "frames"]
    if np.abs(made.time - kept.time).max() > 1e-6:
        found.append("time")
    apart = np.abs(made.q - kept.q)
    if apart.max() > STEP + DIGIT or (apart > DIGIT).mean() > OTHERWISE:
        found.append("angles")
    return found


def test_all_are_committed(kept):
    assert tuple(kept) == TASK_NAMES


@pytest.mark.parametrize(
    "name",
    [
        name if name == "mouse-left-click" else pytest.param(name, marks=pytest.mark.slow)
        for name in TASK_NAMES
    ],
)
def test_committed_experiments_are_what_the_demonstrator_makes(kept, name):
    assert differences(made(name), kept[name]) == []


def test_another_noise_is_told_and_a_single_step_is_not(kept):
    name = "mouse-left-click"
    assert differences(made(name, seed=99), kept[name]) == ["angles"]
    q = kept[name].q.copy()
    q[10, 3] += STEP
    values = {label: getattr(kept[name], label) for label in Recording.__dataclass_fields__}
    assert differences(Recording(**values | {"q": q}), kept[name]) == []
    q[10, 3] += STEP
    assert differences(Recording(**values | {"q": q}), kept[name]) == ["angles"]

from dataclasses import replace
from pathlib import Path

import pytest

from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout_file import read_rollout

SCHEMAS = Path(__file__).parents[1] / "data" / "schemas"


@pytest.fixture(scope="session")
def with_arm() -> Rollout:
    """Twelve samples of a grasp by a hand on an arm, about every half second."""
    kept = read_rollout(SCHEMAS / "rollout-2.npz")
    return replace(kept, z=kept.reading[:, :3])  # as one by a controller has it


@pytest.fixture(scope="session")
def flying() -> Rollout:
    """The first twelve samples, every 10 ms, of a hand without an arm."""
    return read_rollout(SCHEMAS / "rollout-1.npz")

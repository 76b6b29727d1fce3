"""A controller, its recordings and one plan, and baselines of them."""

from dataclasses import replace

import pytest

from handsim.baseline.check import record_baseline
from handsim.baseline.outputs import Questions
from handsim.files import data_folder
from handsim.learning.controller import GraspController
from handsim.motion.recording import read_recordings
from handsim.simulation.plan_store import PlanStore

TASK = "cube-raise"


@pytest.fixture(scope="session")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="session")
def recordings():
    return read_recordings(data_folder("assets") / "experiments")


@pytest.fixture(scope="session")
def plans():
    for path in sorted((data_folder("assets") / "plans").glob("*.json")):
        stored = PlanStore(path).read()
        if TASK in stored:
            return {TASK: stored[TASK]}
    raise AssertionError(f"no plan of {TASK} is stored")


@pytest.fixture(scope="session")
def baseline(controller, recordings, plans):
    return record_baseline(controller, plans, recordings)


@pytest.fixture(scope="session")
def movements(controller):
    return record_baseline(controller)


@pytest.fixture(scope="session")
def grasps(controller, plans):
    return replace(record_baseline(controller, plans), questions=Questions({}, {}, plans))

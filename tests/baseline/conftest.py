"""A controller, its recordings and one plan, and baselines of them."""

from dataclasses import replace

import pytest

from handsim.baseline.check import record_baseline
from handsim.baseline.results import Cases, cases_for, run_cases
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.learning.controller import GraspController
from handsim.recordings.folder import read_recordings

TASK = "cube-raise"
SOME = 8


@pytest.fixture(scope="session")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="session")
def recordings():
    return read_recordings(data_folder("assets") / "experiments")


@pytest.fixture(scope="session")
def plans(controller):
    return {TASK: shipped_plans(controller.digest, Conditions()).read()[TASK]}


@pytest.fixture(scope="session")
def baseline(controller, recordings, plans):
    return record_baseline(controller, plans, recordings)


@pytest.fixture(scope="session")
def movements(controller):
    """Return a baseline of some movements."""
    asked = cases_for(controller)
    names = list(asked.starts)[:SOME]
    cases = Cases(
        {name: asked.starts[name] for name in names},
        {name: asked.goals[name] for name in names},
        {},
    )
    made = record_baseline(replace(controller, demonstrations=controller.demonstrations[:1]))
    return replace(made, cases=cases, results=run_cases(controller, cases))


@pytest.fixture(scope="session")
def grasps(controller, plans):
    return replace(record_baseline(controller, plans), cases=Cases({}, {}, plans))

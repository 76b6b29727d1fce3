"""The shipped controller does what the shipped baseline says, and is learned again as it is."""

from dataclasses import replace

import numpy as np
import pytest

from handsim import data_folder, learn_controller, read_recordings
from handsim.baseline.results import Results
from handsim.baseline.store import read_baseline, write_baseline
from handsim.learning.controller import GraspController
from handsim.testing import assert_as_baseline

ASSETS = data_folder("assets")


TASKS = ("tall-glass-drink", "mouse-left-click", "cube-raise", "pen-write", "jar-unscrew")


def test_the_shipped_controller_does_what_it_did(controller, recordings, tmp_path):
    """Every movement, and grasps of different kinds."""
    kept = read_baseline(ASSETS / "baseline.npz")
    plans = {task: kept.cases.plans[task] for task in TASKS}
    left_out = {f"grasp/{task}" for task in kept.cases.plans} - {f"grasp/{t}" for t in TASKS}
    traces = {name: t for name, t in kept.results.traces.items() if name not in left_out}
    inputs = {
        name: value
        for name, value in kept.results.inputs.items()
        if name.startswith("recordings/") or f"grasp/{name.partition('/')[2]}" not in left_out
    }
    cases, results = replace(kept.cases, plans=plans), Results(traces, inputs)
    some = replace(kept, cases=cases, results=results)
    write_baseline(some, tmp_path / "some.npz")
    report = assert_as_baseline(controller, tmp_path / "some.npz", recordings=recordings)
    assert len(report.changes) == 2 * len(cases.starts) + len(TASKS) > 100


@pytest.mark.ci
@pytest.mark.slow
def test_all_that_the_shipped_baseline_holds(controller, recordings):
    assert_as_baseline(controller, ASSETS / "baseline.npz", recordings=recordings)


def test_the_controller_learned_here_is_the_shipped_one():
    shipped = GraspController.load(ASSETS / "controller.npz")
    learned = learn_controller(read_recordings(ASSETS / "experiments")).controller
    ours, theirs = (each.navigation.obstacle.chi.coefficients for each in (learned, shipped))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)
    assert learned.digest == shipped.digest
    assert dict(learned.options) == dict(shipped.options)

"""The shipped controller does what the shipped baseline says, and is learned again as it is."""

import numpy as np

from handsim import data_folder, learn_controller, read_recordings
from handsim.learning.controller import GraspController
from handsim.testing import assert_as_baseline

ASSETS = data_folder("assets")


def test_the_shipped_controller_does_what_it_did(controller, recordings):
    assert_as_baseline(controller, ASSETS / "baseline.npz", recordings=recordings)


def test_the_controller_learned_here_is_the_shipped_one():
    shipped = GraspController.load(ASSETS / "controller.npz")
    learned = learn_controller(read_recordings(ASSETS / "experiments")).controller
    ours, theirs = (each.navigation.obstacle.chi.coefficients for each in (learned, shipped))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)
    assert learned.digest == shipped.digest
    assert dict(learned.options) == dict(shipped.options)

"""Baselines in the test suites of users.

One line keeps a controller as it is::

    from handsim import GraspController
    from handsim.testing import assert_as_baseline

    def test_the_controller_does_what_it_did():
        assert_as_baseline(GraspController.load("controller.npz"), "baseline.npz")

The baseline is what ``handsim baseline record baseline.npz --controller controller.npz`` wrote;
``handsim baseline check --update REASON`` takes new answers for right. Options are named as on
that command line. The fixture ``as_baseline`` (`handsim.testing.fixture`) does the same, and keeps
a page with curves where something moved.

In: controllers, baselines, recordings. Out: assertions. May import all rooms but `cli`.
"""

import lazy_loader

# pytest loads the fixture in all test suites of an environment, which are not to wait for MuJoCo.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

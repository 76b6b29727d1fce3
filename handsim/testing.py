"""Baselines in the test suites of users.

One line keeps a controller as it is::

    from handsim import GraspController
    from handsim.testing import assert_as_baseline

    def test_the_controller_does_what_it_did():
        assert_as_baseline(GraspController.load("controller.npz"), "baseline.npz")

The baseline is what ``handsim baseline record baseline.npz --controller controller.npz`` wrote;
``handsim baseline check --update REASON`` takes new answers for right.
"""

from pathlib import Path

from handsim.baseline.check import check_baseline
from handsim.baseline.findings import Report
from handsim.baseline.store import read_baseline
from handsim.baseline.tolerances import Tolerances
from handsim.grasping.conditions import Conditions
from handsim.learning.controller import GraspController
from handsim.recordings.recording import RecordingSet


def assert_as_baseline(
    controller: GraspController | Path | str,
    baseline: Path | str,
    *,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    tolerances: Tolerances | None = None,
    ignore_inputs: bool = False,
) -> Report:
    """Assert that a controller answers as a baseline says.

    Parameters
    ----------
    controller
        A controller, or the file of one.
    baseline
        Baseline file.
    recordings
        What to learn from again, where the baseline includes learning.
    conditions
        Of all grasps.
    tolerances
    ignore_inputs
        Judge by what the controller does, and not by the numbers in it.

    Returns
    -------
    Report
        Deviations within the tolerances, for further assertions.

    Raises
    ------
    AssertionError
        With one line for each thing that moved, worst first; what differs between the environment
        of the baseline and this one comes before that.
    FileError
        If the baseline or the controller cannot be read.
    """
    __tracebackhide__ = True  # pytest shows the caller's line
    if isinstance(controller, Path | str):
        controller = GraspController.load(Path(controller))
    report, _ = check_baseline(
        read_baseline(Path(baseline)), controller, recordings, conditions, tolerances, ignore_inputs
    )
    if not report.ok:
        raise AssertionError(f"{baseline}: {report.as_text()}")
    return report

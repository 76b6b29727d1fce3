"""A controller does what its baseline says, as an assertion."""

from pathlib import Path

from handsim.baseline.check import check_baseline
from handsim.baseline.findings import Report
from handsim.baseline.results import Results
from handsim.baseline.store import Baseline, read_baseline
from handsim.baseline.tolerances import Tolerances
from handsim.errors import FileError, InputError
from handsim.grasping.conditions import Conditions
from handsim.learning.controller import GraspController
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import RecordingSet


def assert_as_baseline(
    controller: GraspController | Path | str,
    baseline: Path | str,
    *,
    recordings: RecordingSet | Path | str | None = None,
    conditions: Conditions | None = None,
    tolerances: Tolerances | None = None,
    tolerance_deg: float | None = None,
    grasp_tolerance_deg: float | None = None,
    ignore_inputs: bool = False,
    html: Path | str | None = None,
) -> Report:
    """Assert that a controller answers as a baseline says.

    Parameters
    ----------
    controller
        A controller, or the file of one.
    baseline
        Baseline file.
    recordings
        What to learn from again, where the baseline includes learning; or their folder.
    conditions
        Of all grasps.
    tolerances
        All of them, in place of the next two.
    tolerance_deg, grasp_tolerance_deg
        Largest deviation of a joint in a movement, and in a grasp [deg].
    ignore_inputs
        Judge by what the controller does, and not by the numbers in it.
    html
        Page with curves, written where something moved. Its folder is made.

    Returns
    -------
    Report
        Deviations within the tolerances, for further assertions.

    Raises
    ------
    AssertionError
        With one line for each thing that moved, worst first, or for each cause of several; what
        differs between the environment of the baseline and this one comes before that.
    FileError
        If the baseline, the controller or the recordings cannot be read.
    InputError
        If tolerances are given in both ways.
    """
    __tracebackhide__ = True  # pytest shows the caller's line
    named = Tolerances.of(tolerance_deg, grasp_tolerance_deg)
    if tolerances is not None and named != Tolerances():
        raise InputError("tolerances and tolerance_deg or grasp_tolerance_deg: give one of them")
    if isinstance(controller, Path | str):
        controller = GraspController.load(Path(controller))
    if isinstance(recordings, Path | str):
        recordings = read_recordings(Path(recordings))
    kept = read_baseline(Path(baseline))
    report, results = check_baseline(
        kept, controller, recordings, conditions, tolerances or named, ignore_inputs
    )
    if report.ok:
        return report
    page = "" if html is None else f"\n{_page(Path(html), kept, results, report)}"
    raise AssertionError(f"{baseline}: {report.as_text()}{page}")


def _page(path: Path, kept: Baseline, results: Results, report: Report) -> str:
    """Write the page with curves; say where it is, or why it is nowhere."""
    from handsim.baseline.html_page import write_page

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_page(path, kept, results, report)
    except (FileError, OSError) as error:  # what moved is to be told all the same
        return f"curves: none, {error}"
    return f"curves: {path}"

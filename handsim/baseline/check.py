"""Record a baseline, and run its cases again to compare."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version

from handsim.baseline.comparison import compare, not_numbers
from handsim.baseline.environment import Environment
from handsim.baseline.findings import Report
from handsim.baseline.results import Results, cases_for, run_cases
from handsim.baseline.store import Baseline
from handsim.baseline.tolerances import Tolerances
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.learning.controller import GraspController
from handsim.recordings.recording import RecordingSet
from handsim.types import Progress


def record_baseline(
    controller: GraspController,
    plans: Mapping[str, GraspPlan] | None = None,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    progress: Progress | None = None,
) -> Baseline:
    """Run the demonstrated movements of a controller and grasps by plan, and keep the results.

    Parameters
    ----------
    controller
    plans
        By task of Table I.
    recordings
        If given, learning from them is checked too.
    conditions
        Of all grasps.
    progress
        Called with the fraction done.
    """
    cases = cases_for(controller, plans)
    results = run_cases(controller, cases, recordings, conditions, progress)
    return Baseline(
        cases,
        results,
        relearned=recordings is not None,
        environment=Environment.here(),
        handsim=version("handsim"),
        reasons=("recorded",),
    )


def check_baseline(
    baseline: Baseline,
    controller: GraspController,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    tolerances: Tolerances | None = None,
    ignore_inputs: bool = False,
    progress: Progress | None = None,
) -> tuple[Report, Results]:
    """Run the cases of a baseline with a controller, and compare the results.

    Returns
    -------
    report
    results
        The new ones.

    Raises
    ------
    InputError
        If the baseline includes learning and there are no recordings to learn from.
    """
    if baseline.relearned and recordings is None:
        raise InputError("the baseline includes learning; give the recordings to learn from")
    learned_from = recordings if baseline.relearned else None
    results = run_cases(controller, baseline.cases, learned_from, conditions, progress)
    environments = (baseline.environment, Environment.here())
    now = version("handsim")
    other = f"handsim {baseline.handsim} in the baseline, {now} here"
    notes = () if baseline.handsim == now else (other,)
    report = compare(baseline.results, results, tolerances, environments, ignore_inputs, notes)
    return report, results


def updated(baseline: Baseline, results: Results, reason: str) -> Baseline:
    """Return the baseline with new results, and the reason why they are right.

    Raises
    ------
    InputError
        If there is no reason, or a result holds values that are not finite.
    """
    if not reason.strip():
        raise InputError("an update needs a reason; say why the new answers are right")
    for fault in not_numbers(results):
        raise InputError(f"{fault}; no such answer can be taken for right, the baseline stays")
    return replace(
        baseline,
        results=results,
        environment=Environment.here(),
        handsim=version("handsim"),
        reasons=(*baseline.reasons, " ".join(reason.split())),
    )

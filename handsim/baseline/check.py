"""Record a baseline, and ask the same again."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version

from handsim.baseline.comparison import compare, not_numbers
from handsim.baseline.environment import Environment
from handsim.baseline.findings import Report
from handsim.baseline.results import Results, answer, cases_for
from handsim.baseline.store import Baseline
from handsim.baseline.tolerances import Tolerances
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.learning.controller import GraspController
from handsim.recordings.folder import RecordingSet
from handsim.types import Progress


def record_baseline(
    controller: GraspController,
    plans: Mapping[str, GraspPlan] | None = None,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    progress: Progress | None = None,
) -> Baseline:
    """Ask a controller for its demonstrated movements and for grasps by plan.

    Parameters
    ----------
    controller
    plans
        By task of Table I.
    recordings
        If given, learning from them belongs to what is checked.
    conditions
        Of all grasps.
    progress
        Called with the fraction done.
    """
    questions = cases_for(controller, plans)
    outputs = answer(controller, questions, recordings, conditions, progress)
    return Baseline(
        questions,
        outputs,
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
    """Ask a controller what a baseline was asked, and compare.

    Returns
    -------
    report
    outputs
        The new answers.

    Raises
    ------
    InputError
        If the baseline includes learning and there are no recordings to learn from.
    """
    if baseline.relearned and recordings is None:
        raise InputError("the baseline includes learning; give the recordings to learn from")
    learned_from = recordings if baseline.relearned else None
    outputs = answer(controller, baseline.questions, learned_from, conditions, progress)
    environments = (baseline.environment, Environment.here())
    now = version("handsim")
    other = f"handsim {baseline.handsim} in the baseline, {now} here"
    notes = () if baseline.handsim == now else (other,)
    report = compare(baseline.outputs, outputs, tolerances, environments, ignore_inputs, notes)
    return report, outputs


def updated(baseline: Baseline, outputs: Results, reason: str) -> Baseline:
    """Return the baseline with new answers taken for right, and the reason why.

    Raises
    ------
    InputError
        If there is no reason, or an answer is no number and could not be compared with again.
    """
    if not reason.strip():
        raise InputError("an update needs a reason; say why the new answers are right")
    for fault in not_numbers(outputs):
        raise InputError(f"{fault}; no such answer can be taken for right, the baseline stays")
    return replace(
        baseline,
        outputs=outputs,
        environment=Environment.here(),
        handsim=version("handsim"),
        reasons=(*baseline.reasons, " ".join(reason.split())),
    )

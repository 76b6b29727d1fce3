"""Record a baseline, and ask the same again."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from handsim.baseline.comparison import Report, Tolerances, compare
from handsim.baseline.outputs import Outputs, answer, questions_for
from handsim.baseline.store import Baseline, versions_here
from handsim.errors import InputError
from handsim.learning.controller import GraspController
from handsim.motion.recording import RecordingSet
from handsim.simulation.conditions import Conditions
from handsim.simulation.plan import GraspPlan

Progress = Callable[[float], None]


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
    questions = questions_for(controller, plans)
    outputs = answer(controller, questions, recordings, conditions, progress)
    return Baseline(questions, outputs, recordings is not None, versions_here(), ("recorded",))


def check_baseline(
    baseline: Baseline,
    controller: GraspController,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    tolerances: Tolerances | None = None,
    ignore_inputs: bool = False,
    progress: Progress | None = None,
) -> tuple[Report, Outputs]:
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
    versions = (baseline.versions, versions_here())
    report = compare(baseline.outputs, outputs, tolerances, versions, ignore_inputs)
    return report, outputs


def updated(baseline: Baseline, outputs: Outputs, reason: str) -> Baseline:
    """Return the baseline with new answers taken for right, and the reason why.

    Raises
    ------
    InputError
        If there is no reason.
    """
    if not reason.strip():
        raise InputError("an update needs a reason; say why the new answers are right")
    return replace(
        baseline,
        outputs=outputs,
        versions=versions_here(),
        reasons=(*baseline.reasons, " ".join(reason.split())),
    )

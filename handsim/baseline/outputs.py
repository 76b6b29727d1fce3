"""What a controller does when asked: movements in the subspace, grasps in physics."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from handsim.baseline.inputs import controller_inputs, grasp_inputs, recording_inputs
from handsim.errors import InputError
from handsim.hand.tasks import task_by_name
from handsim.joints import Array, clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_like
from handsim.motion.recording import RecordingSet
from handsim.simulation.closed_loop import Stage
from handsim.simulation.conditions import Conditions
from handsim.simulation.plan import GraspPlan
from handsim.simulation.planner import run_plan

RATE = 50.0
"""Of movements kept [Hz]."""
THINNING = 4
"""Every how many samples of a grasp, of 100 a second, one is kept."""


@dataclass(frozen=True)
class Questions:
    """What a controller is asked for.

    Attributes
    ----------
    starts, goals
        By name of the movement, postures (22,) [rad].
    plans
        By task, where palm and fingers go.
    """

    starts: dict[str, Array]
    goals: dict[str, Array]
    plans: dict[str, GraspPlan]


@dataclass(frozen=True)
class Trace:
    """One answer.

    Attributes
    ----------
    time : (n,) [s]
    q : (n, 22) [rad]
        Of a grasp, what the data glove read.
    verdict
        ``arrived``, ``held``, or what went wrong.
    measures
        Of a grasp, lift and slip [m], tilt [deg], hold [s].
    """

    time: Array
    q: Array
    verdict: str
    measures: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Outputs:
    """Answers by name, and what they depend on as hashes or values by name."""

    traces: dict[str, Trace]
    inputs: dict[str, str]


def questions_for(
    controller: GraspController, plans: Mapping[str, GraspPlan] | None = None
) -> Questions:
    """Ask for every demonstrated movement, and from each start for the next one's destination."""
    demonstrations = controller.demonstrations
    starts, goals = {}, {}
    for i, one in enumerate(demonstrations):
        other = demonstrations[(i + 1) % len(demonstrations)]
        for name, goal in ((one.name, one.q_goal), (f"{one.name} to {other.name}", other.q_goal)):
            starts[name], goals[name] = np.array(one.q_start), np.array(goal)
    return Questions(starts, goals, dict(plans or {}))


def answer(
    controller: GraspController,
    questions: Questions,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    progress: Callable[[float], None] | None = None,
) -> Outputs:
    """Have a controller answer.

    Parameters
    ----------
    controller
    questions
    recordings
        If given, a controller is also learned from them with the same settings, and answers too.
    conditions
        Of all grasps.
    progress
        Called with the fraction done.
    """
    conditions = conditions or Conditions()
    traces: dict[str, Trace] = {}
    inputs = controller_inputs(controller)
    for name in questions.starts:
        traces[f"movement/{name}"] = _move(controller, questions, name)
    if recordings is not None:
        inputs |= recording_inputs(recordings)
        again = learn_like(controller, recordings)
        for name in questions.starts:
            traces[f"relearned/{name}"] = _move(again, questions, name)
    for i, (name, plan) in enumerate(questions.plans.items()):
        stage = Stage.build(task_by_name(name), conditions)
        inputs |= grasp_inputs(stage, plan)
        traces[f"grasp/{name}"] = _grasp(controller, stage, plan)
        if progress:
            progress((i + 1) / len(questions.plans))
    return Outputs(traces, inputs)


def _move(controller: GraspController, questions: Questions, name: str) -> Trace:
    """Ask for one movement; a destination that it cannot have is an answer too."""
    start, goal = questions.starts[name], questions.goals[name]
    try:
        made = controller.postures(start, goal, rate=RATE)
    except InputError as error:
        return Trace(np.zeros(1), clip_to_range(start)[None], f"refused: {error}")
    return Trace(made.time, made.q, made.reason)


def _grasp(controller: GraspController, stage: Stage, plan: GraspPlan) -> Trace:
    try:
        run = run_plan(controller, stage, plan)
    except InputError as error:
        return Trace(np.zeros(1), clip_to_range(plan.q_start)[None], f"refused: {error}")
    outcome = run.outcome
    measures = {
        "lift_m": outcome.lift_m,
        "peak_slip_m": outcome.peak_slip_m,
        "peak_tilt_deg": outcome.peak_tilt_deg,
        "hold_s": outcome.hold_s,
        "penetration_m": outcome.penetration_m,
    }
    kept = slice(None, None, THINNING)
    return Trace(run.time[kept], run.reading[kept], outcome.reason or "held", measures)

"""What a controller does when asked: movements in the subspace, grasps in physics."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from handsim.baseline.inputs import controller_inputs, grasp_inputs, recording_inputs
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.run import Scene
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_like
from handsim.recordings.folder import RecordingSet
from handsim.tasks.table_one import task_by_name
from handsim.types import Array, Progress

RATE = 50.0
"""Of movements kept [Hz]."""
THINNING = 4
"""Every how many samples of a grasp, of 100 a second, one is kept."""


@dataclass(frozen=True)
class Cases:
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
class Results:
    """Answers by name, and what they depend on as hashes or values by name."""

    traces: dict[str, Trace]
    inputs: dict[str, str]


def cases_for(controller: GraspController, plans: Mapping[str, GraspPlan] | None = None) -> Cases:
    """Ask for every demonstrated movement, and from each start for the next one's destination."""
    demonstrations = controller.demonstrations
    starts, goals = {}, {}
    for i, one in enumerate(demonstrations):
        other = demonstrations[(i + 1) % len(demonstrations)]
        for name, goal in ((one.name, one.q_goal), (f"{one.name} to {other.name}", other.q_goal)):
            starts[name], goals[name] = np.array(one.q_start), np.array(goal)
    return Cases(starts, goals, dict(plans or {}))


def answer(
    controller: GraspController,
    questions: Cases,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    progress: Progress | None = None,
) -> Results:
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
        scene = Scene.build(task_by_name(name), conditions)
        inputs |= grasp_inputs(scene, plan)
        traces[f"grasp/{name}"] = _grasp(controller, scene, plan)
        if progress:
            progress((i + 1) / len(questions.plans))
    return Results(traces, inputs)


def _move(controller: GraspController, questions: Cases, name: str) -> Trace:
    """Ask for one movement; a destination that it cannot have is an answer too."""
    start, goal = questions.starts[name], questions.goals[name]
    try:
        made = controller.postures(start, goal, rate=RATE)
    except InputError as error:
        return Trace(np.zeros(1), clip_to_range(start)[None], f"refused: {error}")
    return Trace(made.time, made.q, made.reason)


def _grasp(controller: GraspController, scene: Scene, plan: GraspPlan) -> Trace:
    try:
        run = run_plan(controller, scene, plan)
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

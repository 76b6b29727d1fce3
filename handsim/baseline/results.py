"""Run the cases of a baseline: movements of a controller in its subspace, grasps in physics."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from handsim.baseline.inputs import controller_inputs, grasp_inputs, recording_inputs
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.joints import clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_like
from handsim.learning.transport.stored import shipped_transport
from handsim.recordings.recording import RecordingSet
from handsim.tasks.table_one import task_by_name
from handsim.types import Array, Progress

RATE = 50.0
"""Samples a second of the movements kept [Hz]."""
THINNING = 4
"""One in so many samples of a grasp is kept; a grasp has 100 a second."""


@dataclass(frozen=True)
class Cases:
    """The movements and grasps that a baseline consists of.

    Attributes
    ----------
    starts, goals
        By name of the movement, postures (22,) [rad].
    plans
        Plans of the grasps, by task.
    """

    starts: dict[str, Array]
    goals: dict[str, Array]
    plans: dict[str, GraspPlan]


@dataclass(frozen=True)
class Trace:
    """What a controller did in one case.

    Attributes
    ----------
    time : (n,) [s]
    q : (n, 22) [rad]
        The postures of the movement; of a grasp, the readings of the data glove.
    verdict
        ``arrived``, ``held``, or why the case failed.
    measures
        Of a grasp only: lift, slip and penetration [m], tilt [deg], hold [s], by name.
    """

    time: Array
    q: Array
    verdict: str
    measures: dict[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True)
class Results:
    """What a controller did in all cases.

    Attributes
    ----------
    traces
        By name of the case, such as ``grasp/cube-raise``.
    inputs
        All that the traces depend on, by name: hashes of arrays, values of settings.
    """

    traces: dict[str, Trace]
    inputs: dict[str, str]


def cases_for(controller: GraspController, plans: Mapping[str, GraspPlan] | None = None) -> Cases:
    """Return the cases of a controller: its demonstrated movements, and grasps by plan.

    From the start of each demonstration one movement goes to its own destination, and another to
    that of the next demonstration.
    """
    demonstrations = controller.demonstrations
    starts: dict[str, Array] = {}
    goals: dict[str, Array] = {}
    for i, one in enumerate(demonstrations):
        other = demonstrations[(i + 1) % len(demonstrations)]
        for name, goal in ((one.name, one.q_goal), (f"{one.name} to {other.name}", other.q_goal)):
            starts[name], goals[name] = np.array(one.q_start), np.array(goal)
    return Cases(starts, goals, dict(plans or {}))


def run_cases(
    controller: GraspController,
    cases: Cases,
    recordings: RecordingSet | None = None,
    conditions: Conditions | None = None,
    progress: Progress | None = None,
) -> Results:
    """Run all cases with a controller.

    Parameters
    ----------
    controller
    cases
    recordings
        If given, a controller is learned from them with the settings of ``controller``, and makes
        all movements too.
    conditions
        Of all grasps; nominal if left out.
    progress
        Called with the fraction done.
    """
    conditions = conditions or Conditions()
    traces: dict[str, Trace] = {}
    inputs = controller_inputs(controller)
    for name in cases.starts:
        traces[f"movement/{name}"] = _move(controller, cases, name)
    if recordings is not None:
        inputs |= recording_inputs(recordings)
        again = learn_like(controller, recordings)
        for name in cases.starts:
            traces[f"relearned/{name}"] = _move(again, cases, name)
    for i, (name, known) in enumerate(cases.plans.items()):
        plan = replace(known, transport=shipped_transport())  # which no file of plans holds
        scene = Scene.build(task_by_name(name), conditions)
        inputs |= grasp_inputs(scene, plan)
        traces[f"grasp/{name}"] = _grasp(controller, scene, plan)
        if progress:
            progress((i + 1) / len(cases.plans))
    return Results(traces, inputs)


def _move(controller: GraspController, cases: Cases, name: str) -> Trace:
    """Make one movement; a destination that the controller refuses is a result too."""
    start, goal = cases.starts[name], cases.goals[name]
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

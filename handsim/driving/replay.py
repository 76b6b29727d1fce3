"""A recorded signal drives a controller along its path; scored against what the person did.

Score: root of the mean over time and the 22 joints of the squared difference from the recorded
posture. Beside it stands that of the controller's own time law, which is told how long the person
took.
"""

from dataclasses import dataclass, replace

import numpy as np

from handsim.driving.driver import DriverRule, SignalDriver
from handsim.driving.signal_map import PHASES
from handsim.errors import InputError
from handsim.learning.controller import GraspController
from handsim.learning.guide.likeness import Grasped
from handsim.learning.movement.progress import MAX_DURATION
from handsim.learning.over_time import posture_rms_deg
from handsim.navigation.flow import ARRIVAL
from handsim.navigation.paths import at_arc_length
from handsim.result import Result
from handsim.types import Array


@dataclass(frozen=True)
class Driven(Result):
    """Postures that a signal chose, and how near they are to those recorded.

    Attributes
    ----------
    time : (n,) [s]
    q : (n, 22) [rad], within the person's ranges of motion
    progress : (n,)
        Fraction of the length of the path.
    n_missing
        Frames without a value of the signal.
    arrived
        Whether the last posture is within 4 deg of the destination, over all joints.
    reason
        ``arrived``; ``on the way`` if the signal did not lead to the end; ``stuck`` or ``too long``
        if the path does not arrive; ``clipped`` if the joints' ranges keep the hand away.
    goal_distance
        Euclidean distance over the joints of the last posture from the destination [rad].
    rms_deg, time_law_rms_deg
        Scores of the driven postures and of the controller's time law; None without recorded
        postures. The second is None, too, for recordings of more than 10 minutes.
    """

    time: Array
    q: Array
    progress: Array
    n_missing: int
    arrived: bool
    reason: str
    goal_distance: float
    rms_deg: float | None = None
    time_law_rms_deg: float | None = None


def drive_postures(
    controller: GraspController,
    rule: DriverRule,
    time: Array,
    values: Array,
    q_start: Array,
    q_goal: Array,
    q_recorded: Array | None = None,
    grasped: Grasped | None = None,
) -> Driven:
    """Drive a controller along its path by a recorded signal.

    Parameters
    ----------
    controller
    rule
        Without a curve of its own, progress is what the controller predicts for this movement.
    time : (n,) [s], increasing
    values : (n,)
        The signal; NaN where it is missing.
    q_start, q_goal : (22,) [rad]
    q_recorded : (n, 22) [rad]
        What the person did meanwhile, for the score.
    grasped
        The object, as in `GraspController.path`.

    Raises
    ------
    InputError
        If shapes do not agree, time does not increase, no value is there, or the destination cannot
        be one.
    """
    if np.shape(values) != np.shape(time) or np.ndim(time) != 1 or len(time) < 2:
        raise InputError(
            f"time {np.shape(time)} and signal {np.shape(values)}; both must be (n,), n at least 2"
        )
    steps = np.diff(time, prepend=time[0])
    if not ((steps[1:] > 0).all() and np.isfinite(time).all()):
        raise InputError("times do not increase; sort them")
    missing = int(np.sum(~np.isfinite(values)))
    if missing == len(values):
        raise InputError(f"the signal has no value in {missing} frames; give another channel")
    subspace = controller.subspace
    ends = subspace.transform(q_start), subspace.transform(q_goal)
    path = controller.path(*ends, grasped)
    if rule.curve is None:
        usual = rule.map.pace.duration
        covered = controller.progress(*ends, usual, grasped).covered(PHASES * usual)
        rule = replace(rule, curve=covered)
    driver = SignalDriver(rule)
    progress = np.array([driver.step(value, dt) for value, dt in zip(values, steps, strict=True)])
    q = controller.clipped(subspace.inverse_transform(at_arc_length(path.points, progress)))
    goal = subspace.inverse_transform(subspace.transform(q_goal))
    distance = float(np.linalg.norm(q[-1] - goal))
    arrived = path.arrived and distance <= ARRIVAL
    if arrived:
        reason = "arrived"
    elif progress[-1] < 1:
        reason = "on the way"
    else:
        reason = "clipped" if path.arrived else path.reason
    scores = (None, None) if q_recorded is None else (
        posture_rms_deg(q, q_recorded),
        _time_law_rms(controller, time, q_recorded, q_start, q_goal, grasped),
    )  # fmt: skip
    return Driven(time, q, progress, missing, arrived, reason, distance, *scores)


def _time_law_rms(
    controller: GraspController,
    time: Array,
    q_recorded: Array,
    q_start: Array,
    q_goal: Array,
    grasped: Grasped | None,
) -> float | None:
    duration = float(time[-1] - time[0])
    if duration > MAX_DURATION:
        return None
    made = controller.postures(q_start, q_goal, grasped=grasped, duration=duration)
    since = time - time[0]
    q = np.column_stack([np.interp(since, made.time, column) for column in made.q.T])
    return posture_rms_deg(q, q_recorded)

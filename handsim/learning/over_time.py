"""Scores over time: how far the hand is from a recorded one at each moment of a movement.

The controller's movement lasts as long as the recorded one. Angles are compared joint by joint; the
root of the mean square is over time and the 22 joints. Parts of the error are told apart by taking
one after the other away: the recording projected into the subspace (truncation), that within the
person's ranges of motion (clipping), the controller's path passed as the person passed theirs
(path), and the movement as it is, with the controller's timing.
"""

from dataclasses import dataclass, fields

import numpy as np

from handsim.learning.controller import GraspController
from handsim.learning.guide.likeness import Grasped
from handsim.navigation.flow import FlowPath
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.recordings.recording import Recording
from handsim.types import Array


@dataclass(frozen=True)
class OverTime:
    """How far a movement is from a recorded one at each moment.

    Attributes
    ----------
    rms_over_time_deg
        Over time and the 22 joints.
    rms_truncation_deg, rms_clipping_deg, rms_path_deg
        What would be left of it with a perfect path and timing in the subspace; with them within
        the ranges of motion; and with the controller's path and the recorded timing.
    speed_correlation
        Of the speeds of the hand, the norm over the joints; None where one does not vary.
    peak_time_error
        Difference between the times of the greatest speeds, as a fraction of the duration.
    """

    rms_over_time_deg: float
    rms_truncation_deg: float
    rms_clipping_deg: float
    rms_path_deg: float
    speed_correlation: float | None
    peak_time_error: float


SCORED = tuple(each.name for each in fields(OverTime))
"""Names of the scores."""


def over_time(
    controller: GraspController,
    recording: Recording,
    followed: FlowPath,
    grasped: Grasped | None,
) -> OverTime:
    """Compare a controller's movement with a recording, at each of its frames.

    Parameters
    ----------
    controller
    recording
    followed
        The controller's path between the ends of the recording.
    grasped
        What it was told of the object.
    """
    subspace, time = controller.subspace, recording.time - recording.time[0]
    z = subspace.transform(recording.q)
    length = arc_length(z)
    law = controller.progress(z[0], z[-1], recording.duration, grasped)
    as_recorded = at_arc_length(followed.points, length / max(float(length[-1]), 1e-12))
    projected = subspace.inverse_transform(z)
    on_path = controller.clipped(subspace.inverse_transform(as_recorded))
    points = at_arc_length(followed.points, law.covered(time))
    moved = controller.clipped(subspace.inverse_transform(points))
    speed, recorded = _speed(moved, time), _speed(recording.q, time)
    peaks = time[[int(np.argmax(speed)), int(np.argmax(recorded))]] / recording.duration
    return OverTime(
        rms_over_time_deg=posture_rms_deg(moved, recording.q),
        rms_truncation_deg=posture_rms_deg(projected, recording.q),
        rms_clipping_deg=posture_rms_deg(controller.clipped(projected), recording.q),
        rms_path_deg=posture_rms_deg(on_path, recording.q),
        speed_correlation=_correlation(speed, recorded),
        peak_time_error=float(abs(peaks[0] - peaks[1])),
    )


def posture_rms_deg(q: Array, reference: Array) -> float:
    """Return the root of the mean squared difference of postures, both (n, 22) [rad], in deg."""
    return float(np.rad2deg(np.sqrt(np.mean((q - reference) ** 2))))


def _speed(q: Array, time: Array) -> Array:
    """Return the norm of the joint velocities (n,) [rad/s]."""
    velocity: Array = np.gradient(q, time, axis=0)
    return np.linalg.norm(velocity, axis=1)


def _correlation(a: Array, b: Array) -> float | None:
    if a.std() == 0.0 or b.std() == 0.0:
        return None
    return float(np.corrcoef(a, b)[0, 1])

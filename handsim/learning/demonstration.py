"""What a controller keeps of each recording: both ends of the movement, and its duration."""

from dataclasses import dataclass

from handsim.learning.subspace import PostureSubspace
from handsim.recordings.recording import RecordingSet
from handsim.types import Array


@dataclass(frozen=True)
class Demonstration:
    """What a controller keeps of one recording.

    Attributes
    ----------
    name, task, object
        As in the recording.
    q_start, q_goal : (22,) [rad]
        First and last posture recorded, whole.
    z_start, z_goal : (n_components,) [rad]
        The same in the subspace.
    hand_length, hand_breadth : [m]
    duration : [s]
    """

    name: str
    task: str
    object: str
    q_start: Array
    q_goal: Array
    z_start: Array
    z_goal: Array
    hand_length: float
    hand_breadth: float
    duration: float


def demonstrations_of(
    recordings: RecordingSet, subspace: PostureSubspace
) -> tuple[Demonstration, ...]:
    """Return what is kept of recordings."""
    return tuple(
        Demonstration(
            name=r.name,
            task=r.task,
            object=r.object,
            q_start=r.q[0],
            q_goal=r.q[-1],
            z_start=subspace.transform(r.q[0]),
            z_goal=subspace.transform(r.q[-1]),
            hand_length=r.hand.length,
            hand_breadth=r.hand.breadth,
            duration=r.duration,
        )
        for r in recordings
    )

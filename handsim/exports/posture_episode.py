"""Recordings and posture sequences as episodes."""

from collections.abc import Mapping

from handsim.exports.episode import Episode, Quantity
from handsim.exports.task_sentences import sentence_of
from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.recordings.posture_file import CHANNEL
from handsim.recordings.recording import Recording
from handsim.types import Array

WHAT = "angles of the hand's joints, in the order of a data glove"


def recording_episode(recording: Recording) -> Episode:
    """Return a recording as an episode; a channel keeps its name, which says its unit."""
    return Episode(
        name=recording.name,
        kind="recording",
        task=recording.task,
        sentence=sentence_of(recording.task, recording.object),
        time=recording.time,
        quantities=_quantities(recording.q, recording.channels),
        facts={
            "number": recording.number,
            "subject": recording.subject,
            "object": recording.object,
            "hand_length_m": recording.hand.length,
            "hand_breadth_m": recording.hand.breadth,
            "side": recording.hand.side,
            "session": recording.session,
            "notes": list(recording.notes),
            "extra": dict(recording.extra),
        },
        hand=recording.hand,
    )


def posture_episode(
    name: str, time: Array, q: Array, channels: Mapping[str, Array] | None = None
) -> Episode:
    """Return postures as an episode.

    Parameters
    ----------
    name
    time : (n,) [s]
    q : (n, 22) [rad]
    channels : name to (n,)
    """
    return Episode(
        name=name,
        kind="postures",
        task="",
        sentence=sentence_of(""),
        time=time,
        quantities=_quantities(q, channels or {}),
        facts={},
    )


def _quantities(q: Array, channels: Mapping[str, Array]) -> tuple[Quantity, ...]:
    joints = Quantity("joints", JOINT_NAMES, ("rad",) * N_JOINTS, q, WHAT)
    further = (
        Quantity(
            CHANNEL + name, (CHANNEL + name,), ("",), values[:, None], "recorded beside the hand"
        )
        for name, values in channels.items()
    )
    return (joints, *further)

"""Left hands whose gloves give the angles in the signs of a right hand.

Within this project flexion and spreading are positive on either side, so that a left hand's angles
are those of its mirror image and right and left hands are learned from together. A glove that keeps
the signs of the right hand gives a left hand's abductions and its deviation with the opposite sign.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, JOINT_NAMES, LOWER, UPPER
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import Array, Index

MIRRORED_JOINTS = tuple(name for name in JOINT_NAMES if name.endswith(("_abduction", "_deviation")))
"""Joints whose sign the mirror turns around where it is that of the other hand."""
_COLUMNS: Index = np.array([JOINT_INDEX[name] for name in MIRRORED_JOINTS])
_ABDUCTIONS = _COLUMNS[:-1]
START = np.deg2rad(-3.0)
"""Thumb abduction at the start, on the average, below which signs are judged [rad]."""
EVIDENCE = 1.5
"""How much farther the abductions leave their ranges as given than turned around."""


def mirrored(q: Array) -> Array:
    """Return postures with the signs of the other hand's glove.

    Parameters
    ----------
    q : (..., 22) [rad]
    """
    turned = np.array(q, dtype=float)
    turned[..., _COLUMNS] *= -1
    return turned


def looks_mirrored(postures: Sequence[Array]) -> bool:
    """Whether abductions have the sign of the other hand's glove.

    People reach with the thumb open and the fingers spread or straight, and converge them around
    the object. Signs are those of the other hand if at the start, on the average, the thumb is
    below `START` and at least two of the three fingers are spread negatively, and if over all
    frames the abductions leave their lopsided ranges (a thumb opens by 65 deg and closes by 5) by
    `EVIDENCE` times what they do turned around.

    Parameters
    ----------
    postures
        Of recordings of one hand, (n, 22) [rad] each.
    """
    start = np.mean([each[0, _ABDUCTIONS] for each in postures], axis=0)
    if start[0] > START or (start < 0).sum() < 3:
        return False
    q = np.vstack([each[:, _ABDUCTIONS] for each in postures])
    lower, upper = LOWER[_ABDUCTIONS], UPPER[_ABDUCTIONS]
    return _outside(q, lower, upper) > EVIDENCE * _outside(-q, lower, upper)


def on_one_side(recordings: Iterable[Recording], where: str, remedy: str = "") -> RecordingSet:
    """Return recordings as a set, left hands in the signs of this project, hand by hand.

    Parameters
    ----------
    recordings
    where
        What messages begin with, such as a file.
    remedy
        What they end with.

    Raises
    ------
    FileError
        If there is none, or two have one name.
    """
    recordings = list(recordings)
    left = [r for r in recordings if r.hand.side == "left"]
    turned: set[str] = set()
    for hand in dict.fromkeys((r.subject, r.session) for r in left):
        of_hand = [r for r in left if (r.subject, r.session) == hand]
        if looks_mirrored([r.q for r in of_hand]):
            turned |= {r.name for r in of_hand}
    note = f"left hand in the signs of a right glove: {', '.join(MIRRORED_JOINTS)} turned around"
    try:
        return RecordingSet(
            tuple(
                replace(r, q=mirrored(r.q), notes=(*r.notes, note)) if r.name in turned else r
                for r in recordings
            )
        )
    except InputError as error:
        raise FileError(f"{where}: {error}{remedy}") from error


def _outside(q: Array, lower: Array, upper: Array) -> float:
    """Mean over frames of the sum of angles outside the ranges [rad]."""
    return float((np.maximum(lower - q, 0) + np.maximum(q - upper, 0)).sum(axis=1).mean())

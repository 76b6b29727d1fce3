"""Left hands whose gloves give the angles in the signs of a right hand.

Within this project flexion and spreading are positive on either side, so that a left hand's angles
are those of its mirror image and right and left hands are learned from together. A glove that keeps
the signs of the right hand gives a left hand's abductions and its deviation with the opposite sign.
"""

from collections.abc import Sequence

import numpy as np

from handsim.joints import JOINT_INDEX, JOINT_NAMES, LOWER, UPPER
from handsim.types import Array, Index, Mask

MIRRORED_JOINTS = tuple(name for name in JOINT_NAMES if name.endswith(("_abduction", "_deviation")))
"""Joints whose sign the mirror turns around where it is that of the other hand."""
_COLUMNS: Index = np.array([JOINT_INDEX[name] for name in MIRRORED_JOINTS])
_ABDUCTIONS = _COLUMNS[:-1]
MIN_EVIDENCE = np.deg2rad(4.0)
"""Mean angle outside the ranges of the abductions from which signs are judged [rad]."""


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

    They do if, on the average over frames, they leave the joint ranges by more than `MIN_EVIDENCE`
    in all, turning them around leaves a third of that at most, and the thumb and most fingers are
    spread negatively on the average. The ranges are lopsided: a thumb opens by 65 deg and closes by
    5.

    Parameters
    ----------
    postures
        Of recordings of one hand, (n, 22) [rad] each.
    """
    q = np.vstack([each[:, _ABDUCTIONS] for each in postures])
    lower, upper = LOWER[_ABDUCTIONS], UPPER[_ABDUCTIONS]
    as_given, turned = _outside(q, lower, upper), _outside(-q, lower, upper)
    negative: Mask = q.mean(axis=0) < 0
    spread = bool(negative[0]) and int(negative.sum()) >= 3
    return bool(as_given > MIN_EVIDENCE and turned < as_given / 3 and spread)


def _outside(q: Array, lower: Array, upper: Array) -> float:
    """Mean over frames of the sum of angles outside the ranges [rad]."""
    return float((np.maximum(lower - q, 0) + np.maximum(q - upper, 0)).sum(axis=1).mean())

"""The line that a finger runs along, from anchors of joints that may be anywhere on their axes."""

from itertools import pairwise

import numpy as np

from handsim.types import Array, Mask

_PARALLEL = 0.7
"""Joints whose axes have at least this cosine with that of the last one bend the finger."""


def finger_line(anchors: Array, axes: Array, tip: Array, slides: Mask) -> Array:
    """Return the places that a finger runs through, from where it begins to its tip, (k, 3) [m].

    Between them are the joints that bend as the last one does. Where an anchor lies along that
    axis is the maker's choice: some put it in the motor beside the finger. So all are moved along
    it into the plane of the tip; where the finger begins, only if the first joint bends, too.

    Parameters
    ----------
    anchors, axes : (n, 3)
        Of the joints of a finger, from the palm outwards, the finger being straight [m; unit].
    tip : (3,) [m]
    slides : (n,)
        Which of the joints do not turn.
    """
    if slides.all():
        return np.vstack([anchors, tip])
    anchors, axes = anchors[~slides], axes[~slides]
    last = axes[-1]
    bends = np.abs(axes @ last) > _PARALLEL
    places = anchors + ((tip - anchors) @ last)[:, None] * last
    if not bends[0]:
        places[0] = anchors[0]
    kept = bends.copy()
    kept[0] = True
    return np.vstack([places[kept], tip])


def length_of(line: Array) -> float:
    """Return the length of a line through places (k, 3) [m]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def first_part(line: Array, least: float) -> Array:
    """Return the unit vector along the first part of a line that is longer than ``least`` [m]."""
    for inner, outer in pairwise(line):
        size = float(np.linalg.norm(outer - inner))
        if size > least:
            return (outer - inner) / size
    along = line[-1] - line[0]
    size = float(np.linalg.norm(along))
    return along / size if size > 1e-9 else np.array([1.0, 0.0, 0.0])

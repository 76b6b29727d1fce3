"""Postures at both ends of the eigengrasps: what a few principal components move, made visible.

The numbers are those of ``models/hand/eigengrasps.csv``, which ``models/hand/make.py``
writes from the built-in experiments: the hand knows nothing of learning.
"""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.files import data_folder
from handsim.joints import JOINT_NAMES, clip_to_range
from handsim.types import Array

EXTENT = 2.0
"""How far the postures are from the mean [standard deviations]: 95 % of what was recorded."""
DEEPEST = 0.0019
"""Penetration of the hand by itself that is let be [m], a little under the 2 mm that are tested."""
_STEP = 0.01
_COLUMNS = ("name", *(f"{joint}_deg" for joint in JOINT_NAMES))


def eigengrasp_postures(
    penetration: Callable[[Array], float], file: Path | None = None
) -> dict[str, Array]:
    """Return ``eigengrasp_1_plus``, ``eigengrasp_1_minus`` ..., (22,) [rad] each.

    They are the mean and `EXTENT` standard deviations along a component. A joint that comes to the
    end of its range stays there, and all are drawn back to the mean, by steps of 1 %, until the
    hand penetrates itself by less than `DEEPEST`.

    Parameters
    ----------
    penetration
        How deep the hand penetrates itself in a posture [m].
    file
        The table; by default the one of the built-in experiments.

    Raises
    ------
    FileError
        If the table is missing or is another one.
    """
    mean, deviations = read_eigengrasps(file or data_folder("models") / "hand" / "eigengrasps.csv")
    postures = {}
    for name, deviation in deviations.items():
        for end, sign in (("plus", EXTENT), ("minus", -EXTENT)):
            postures[f"{name}_{end}"] = _draw_back(mean, sign * deviation, penetration)
    return postures


def _draw_back(mean: Array, offset: Array, penetration: Callable[[Array], float]) -> Array:
    """Return the posture farthest along ``offset`` that does not penetrate too deep."""
    for part in np.arange(1.0, 0.0, -_STEP):
        q = clip_to_range(mean + part * offset)
        if penetration(q) < DEEPEST:
            return q
    return clip_to_range(mean)


def read_eigengrasps(file: Path) -> tuple[Array, dict[str, Array]]:
    """Read the mean posture, (22,) [rad], and by name the standard deviations, (22,) [rad] each.

    Raises
    ------
    FileError
        If the file is missing or holds something else.
    """
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            columns, *rows = csv.reader(stream)
        angles = {name: np.deg2rad([float(angle) for angle in row]) for name, *row in rows}
        well = tuple(columns) == _COLUMNS and all(q.shape == (22,) for q in angles.values())
        if not well:
            raise ValueError("columns are not the name and the 22 joints")
        return angles.pop("mean"), angles
    except (OSError, ValueError, KeyError) as error:
        raise FileError(
            f"{file}: not a table of eigengrasps ({error}); "
            "make it again: python models/hand/make.py"
        ) from error

"""The layout ``west-rtg`` of published recordings.

The reach-and-grasp source data of A. M. West Jr. and N. Hogan, "Kinematic Hand
Synergies Differ Between Reach-and-Grasp and Functional Object Manipulation" (Zenodo,
doi:10.5281/zenodo.14532969): two MATLAB 5 files with the cells ``X_R2G_SUBJECTbyOBJECT`` (joint
angles [rad], 23 columns) and ``t_R2G_SUBJECTbyOBJECT`` (times [s]), subjects x 5 objects, the
trials of a cell one after the other; a trial starts where time jumps back.

Signs. The source gives flexion negative. The other joints were decided on the data of four
subjects, all of whom start with the flat hand and end in a grasp:

- thumb rotation runs from near 0 to -80 deg, which is opposition: reversed;
- abductions are turns about one axis for all fingers. Flat hands show the index at +3, the little
  finger at -8 deg: both are spread, so positive is a turn to the thumb's side, spreading for the
  index only. Ring and little are reversed; all three then converge (index -9, ring -13 deg from
  near 0) as fingers do when they flex. The thumb reads -25 deg flat (away from the palm) and -7 in
  the grasp: reversed;
- the wrist's pitch reads +5 to +30 deg, the extension of a hand over a table: reversed. Its yaw
  reads 0 to -10 deg; about the abductions' axis that is the slight turn to the little finger's
  side in which hands work: kept;
- the palm's arch grows with the sum of finger flexions in all four subjects (correlations 0.3 to
  0.6), as cupping does: kept.

The middle finger's abduction is the reference of the others, nearly constant (standard deviation
1 to 2 deg), and dropped.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import FileError, InputError
from handsim.recordings.importers._matlab import read_variables
from handsim.recordings.importers.layout import UNKNOWN_HAND, ImportOptions, Layout
from handsim.recordings.phases import cut_reach_to_grasp
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import Array

_WEST_OBJECTS = ("scissors", "zip-tie", "screwdriver", "wire-harness-tied", "wire-harness-untied")
_WEST_N_COLUMNS = 23
_LARGEST = 1e6
"""Angles beyond are damage, of which products overflow [rad]."""
# For each of the 22 joints in glove order: the source's column and the sign that brings it to
# this project's convention.
_WEST_COLUMNS = np.array(
    [0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 7, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22]
)
_WEST_SIGNS = np.array(
    [-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 1, -1, -1, -1, -1, -1, -1, -1, -1, 1, -1, 1], float
)


def read_west_rtg(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read the two published files, cut to the reach-to-grasp phase.

    Parameters
    ----------
    files
        In any order.
    options
        With the number of the subject, from 1; all subjects where it is left out. The source does
        not give hand sizes.

    Raises
    ------
    FileError
        If a file is missing, damaged or not of the layout.
    InputError
        If the subject is not among those in the files.
    """
    angles, times = _west_cells([Path(file) for file in files])
    n_subjects, subject = angles.shape[0], options.subject
    if subject is not None and not 1 <= subject <= n_subjects:
        raise InputError(f"subject {subject} is not in the files; give 1 to {n_subjects}")
    chosen = range(1, n_subjects + 1) if subject is None else [subject]
    recordings = [r for number in chosen for r in _west_subject(angles, times, number)]
    return RecordingSet(tuple(recordings))


def _west_subject(angles: Array, times: Array, subject: int) -> list[Recording]:
    recordings: list[Recording] = []
    for column, object_name in enumerate(_WEST_OBJECTS):
        q = _west_postures(angles[subject - 1, column], subject, object_name)
        time = np.asarray(times[subject - 1, column], dtype=float).ravel()
        if len(time) != len(q):
            raise FileError(
                f"subject {subject}, {object_name}: {len(time)} times for {len(q)} postures; "
                "give the pair of files of one publication"
            )
        edges = np.flatnonzero(np.diff(time) < 0) + 1
        trials = zip(np.split(time, edges), np.split(q, edges), strict=True)
        for trial, (trial_time, trial_q) in enumerate(trials, start=1):
            name = f"subject-{subject}-{object_name}-{trial}"
            try:
                phase_time, phase_q = cut_reach_to_grasp(trial_time, trial_q)
            except InputError as error:
                raise FileError(f"{name}: {error}") from error
            recordings.append(
                Recording(
                    name=name,
                    time=phase_time,
                    q=phase_q,
                    number=len(recordings) + 1,
                    subject=str(subject),
                    object=object_name,
                    task=f"{object_name}-grasp",
                    hand=UNKNOWN_HAND,
                )
            )
    return recordings


def _west_postures(cell: npt.ArrayLike, subject: int, object_name: str) -> Array:
    raw = np.asarray(cell, dtype=float)
    if raw.ndim != 2 or raw.shape[1] != _WEST_N_COLUMNS or not (np.abs(raw) < _LARGEST).all():
        raise FileError(
            f"subject {subject}, {object_name}: angles of shape {raw.shape}; the layout has finite "
            f"angles of shape (n, {_WEST_N_COLUMNS}), below {_LARGEST:g} rad"
        )
    return raw[:, _WEST_COLUMNS] * _WEST_SIGNS


def _west_cells(files: list[Path]) -> tuple[Array, Array]:
    wanted = ("X_R2G_SUBJECTbyOBJECT", "t_R2G_SUBJECTbyOBJECT")
    cells: dict[str, Any] = {}
    for file in files:
        cells.update(read_variables(file, wanted))
    for name in wanted:
        if name not in cells:
            raise FileError(
                f"{', '.join(file.name for file in files)}: no variable {name}; "
                "west-rtg needs the X_ and the t_ file"
            )
        shape = cells[name].shape
        if cells[name].dtype != object or len(shape) != 2 or shape[1] != len(_WEST_OBJECTS):
            raise FileError(
                f"{name}: not a cell array of subjects x {len(_WEST_OBJECTS)} objects; "
                "download the file again"
            )
    if cells[wanted[0]].shape != cells[wanted[1]].shape:
        raise FileError(f"{wanted[0]} and {wanted[1]} differ in subjects; give one publication's")
    return cells[wanted[0]], cells[wanted[1]]


LAYOUT = Layout(
    "west-rtg",
    "two MATLAB files of West and Hogan (2024), glove, cut to the reach",
    read_west_rtg,
    frozenset({"subject"}),
)

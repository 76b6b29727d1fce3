"""Repetitions of movements in files of Ninapro, each a recording."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, JOINT_NAMES
from handsim.recordings.columns.frames import Frames, Labels, recording_of
from handsim.recordings.columns.labels import hand_of
from handsim.recordings.glove.calibration import GloveCalibration, calibrated, calibration_of_counts
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.importers.ninapro.mat_file import NinaproFile, read_file
from handsim.recordings.posture_file import filled_dips
from handsim.recordings.recording import MIN_FRAMES, Recording, RecordingSet
from handsim.recordings.sides import on_one_side
from handsim.types import Array

REST_BEFORE = 0.5
"""Longest rest before a movement that its recording starts with [s]."""


def read_ninapro(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read files of Ninapro, one recording a repetition of a movement.

    Parameters
    ----------
    files
        In any order.
    options

    Raises
    ------
    FileError
        If a file is missing, damaged, of MATLAB 7.3, or not of the layout.
    InputError
        If counts come without a calibration, or the rate cannot be told.
    """
    calibration = calibration_of_counts(options.calibration, options.units)
    recordings: list[Recording] = []
    for file in files:
        content = read_file(Path(file), options)
        recordings += _recordings(content, calibration, options, len(recordings))
    return on_one_side(recordings, str(files[0]), "; give files of different exercises")


def _recordings(
    content: NinaproFile,
    calibration: GloveCalibration | None,
    options: ImportOptions,
    first: int,
) -> list[Recording]:
    angles, notes = _angles(content, calibration, options)
    runs, short = _runs(content)
    if short:
        notes = (*notes, f"{short} repetitions of fewer than {MIN_FRAMES} frames left out")
    if not runs:
        raise FileError(
            f"{content.path}: holds no movement of {MIN_FRAMES} frames, labels are all rest; "
            "check the file"
        )
    recordings: list[Recording] = []
    for start, onset, stop, repetition in runs:
        rows = np.arange(start, stop)
        movement = f"{content.movement[onset]:02d}"
        frames = Frames(
            where=str(content.path),
            time=rows / content.rate,
            angles=angles[rows],
            numbers=rows + 1,
            columns=("the row's", *(f"{name} of glove" for name in JOINT_NAMES)),
            channels={
                **{name: values[rows] for name, values in content.channels.items()},
                "label": content.movement[rows].astype(float),
            },
            notes=(*content.notes, *notes, f"starts {(onset - start) / content.rate:.3g} s before "
                   "its label"),
        )  # fmt: skip
        labels = Labels(
            name=f"s{content.subject}-e{content.exercise}-m{movement}-r{repetition:02d}",
            number=first + len(recordings) + 1,
            subject=str(options.subject) if options.subject is not None else content.subject,
            object=options.object or "unknown",
            task=options.task or f"movement-{movement}",
            hand=hand_of({}, options),
            extra={
                "movement": str(int(movement)),
                "repetition": str(repetition),
                "exercise": content.exercise,
            },
        )
        recordings.append(
            recording_of(frames, labels, bridge_s=options.bridge_s, unwrap=options.unwrap)
        )
    return recordings


def _runs(content: NinaproFile) -> tuple[list[tuple[int, int, int, int]], int]:
    """First row, onset, end and number of each repetition, and how many were too short."""
    label = np.stack([content.movement, content.repetition])
    changes = np.flatnonzero((np.diff(label, axis=1) != 0).any(axis=0)) + 1
    edges = [0, *changes.tolist(), len(content.movement)]
    before = int(REST_BEFORE * content.rate)
    runs: list[tuple[int, int, int, int]] = []
    counted: dict[tuple[int, int], int] = {}
    short, rest_from = 0, 0
    for onset, stop in pairwise(edges):
        movement, repetition = (int(value) for value in label[:, onset])
        if movement <= 0:
            continue
        if stop - onset < MIN_FRAMES:
            short += 1
        else:
            earlier = content.movement[rest_from:onset] > 0
            rest = rest_from + int(np.flatnonzero(earlier)[-1]) + 1 if earlier.any() else rest_from
            times = counted[(movement, repetition)] = counted.get((movement, repetition), 0) + 1
            number = times if repetition <= 0 else repetition
            if repetition > 0 and times > 1:
                number = max(r for *_, r in runs if r) + 1
            runs.append((max(rest, onset - before), onset, stop, number))
        rest_from = stop
    return runs, short


def _angles(
    content: NinaproFile, calibration: GloveCalibration | None, options: ImportOptions
) -> tuple[Array, tuple[str, ...]]:
    """Return the angles of all rows [deg], and what was done."""
    values, notes = content.values, list[str]()
    known = values[np.isfinite(values)]
    with np.errstate(over="ignore", invalid="ignore"):
        if options.units in ("deg", "rad") or content.calibrated:
            radians = options.units == "rad" and not content.calibrated
            angles = np.rad2deg(values) if radians else np.array(values)
            notes.append("signs of abductions and wrist as in the file, not compared")
            index = JOINT_INDEX["index_abduction"]
            if content.calibrated and not np.isfinite(angles[:, index]).any():
                angles[:, index] = 0.0
                notes.append("index_abduction taken as constant, 0 deg: not in the file")
        elif calibration is not None:
            angles, notes = calibrated(calibration, values, str(content.path))
        else:
            found = f" from {known.min():g} to {known.max():g}" if known.size else ""
            raise InputError(
                f"{content.path}: glove has uncalibrated values{found}; calibrate with `handsim "
                "recordings calibrate FILE.mat --ranges` and give --calibration, or say --units "
                "deg if these are angles"
            )
        angles, filled = filled_dips(angles)
    return angles, (*notes, *filled)


LAYOUT = Layout(
    "ninapro",
    "MATLAB files of Ninapro with glove, labels and EMG: one recording a repetition",
    read_ninapro,
    frozenset(
        {"subject", "side", "units", "calibration", "hand", "bridge_s", "rate_hz", "object"}
        | {"task", "unwrap"}
    ),
)

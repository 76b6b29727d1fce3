"""The layout ``cyberglove``: raw files of CyberGlove of 22 or 18 sensors, one recording a file.

`handsim.recordings.glove.counts` says what a file holds and in which order its sensors are. Counts
become angles by a calibration (``handsim recordings calibrate``), and each recording says by which
and how good it is; without one they are refused. Files whose values are angles already, in the same
order and with flexion and spreading positive, are read with the units deg or rad.

Where a file has no times, its rate must be given. DIP joints without a sensor are filled
(`posture_file.DIP_OF_PIP`). ``experiments.csv`` beside the files, or named in their place, gives
subject, object, task, side and hand size. Left hands with the signs of a right hand's glove are
turned around.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handsim.errors import InputError
from handsim.joints import JOINT_NAMES
from handsim.recordings.columns.frames import Frames, recording_of
from handsim.recordings.columns.labels import labels_of, listed_files
from handsim.recordings.glove.calibration import GloveCalibration, calibrated, calibration_of_counts
from handsim.recordings.glove.counts import RawGlove, check_counts, read_raw
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.posture_file import filled_dips
from handsim.recordings.recording import RecordingSet
from handsim.recordings.sides import on_one_side


def read_gloves(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read raw files, one recording each.

    Parameters
    ----------
    files
        Raw files, folders of them, or their ``experiments.csv``.
    options

    Raises
    ------
    FileError
        If a file is missing, damaged or of another number of sensors.
    InputError
        If counts come without a calibration, or frames without times and without a rate.
    """
    calibration = calibration_of_counts(options.calibration, options.units)
    recordings = [
        recording_of(
            _frames(read_raw(path), calibration, options),
            labels_of(path, number, said, options),
            bridge_s=options.bridge_s,
            unwrap=options.unwrap,
        )
        for number, (path, said) in enumerate(listed_files(files), start=1)
    ]
    return on_one_side(recordings, str(files[0]))


def _frames(raw: RawGlove, calibration: GloveCalibration | None, options: ImportOptions) -> Frames:
    path = raw.table.path
    time = raw.time
    notes = list(raw.notes)
    if time is None:
        if options.rate_hz is None:
            raise InputError(f"{path}: has no column of time; give the rate in Hz by --rate")
        time = np.arange(len(raw.values)) / options.rate_hz
        notes.append(f"times by a rate of {options.rate_hz:g} Hz")
    with np.errstate(over="ignore", invalid="ignore"):
        if options.units in ("deg", "rad"):
            angles = np.rad2deg(raw.values) if options.units == "rad" else raw.values
        else:
            angles, said = _calibrated(raw, calibration)
            notes += said
        angles, filled = filled_dips(angles)
    names = [
        raw.table.header[place] if place is not None and raw.table.header else joint
        for place, joint in zip(raw.places, JOINT_NAMES, strict=True)
    ]
    return Frames(
        where=str(path),
        time=time,
        angles=angles,
        numbers=raw.table.numbers,
        columns=("time", *names),
        notes=(*notes, *filled),
        cell=raw.cell,
    )


def _calibrated(
    raw: RawGlove, calibration: GloveCalibration | None
) -> tuple[np.ndarray, list[str]]:
    known = raw.values[np.isfinite(raw.values)]
    if calibration is None:
        found = f" from {known.min():g} to {known.max():g}" if known.size else ""
        raise InputError(
            f"{raw.table.path}: raw counts{found}; calibrate the glove with `handsim recordings "
            "calibrate` and give --calibration, or say --units deg if these are angles"
        )
    check_counts(raw)
    return calibrated(calibration, raw.values, str(raw.table.path))


LAYOUT = Layout(
    "cyberglove",
    "raw counts of CyberGlove, 22 or 18 sensors a row, with a calibration, one file each",
    read_gloves,
    frozenset(
        {"subject", "side", "units", "calibration", "hand", "bridge_s", "rate_hz", "object"}
        | {"task", "unwrap"}
    ),
)

"""Variables of a file of Ninapro, checked; the room's docstring says what they are."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handsim.disk import naming
from handsim.errors import FileError, InputError
from handsim.files import is_file
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.glove.counts import SENSORS
from handsim.recordings.importers._matlab import read_variables
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.recording import MIN_FRAMES
from handsim.types import Array, Index

_CHANNELS = ("emg", "acc", "inclin")
_NAMES = (
    *("glove", "angles", "stimulus", "restimulus", "repetition", "rerepetition", "frequency"),
    *("subject", "exercise", *_CHANNELS),
)
_FILE_NAME = re.compile(r"s(?P<subject>\d{1,4})_(?:a\d+_)?e(?P<exercise>\d{1,2})", re.IGNORECASE)
_HDF5 = b"\x89HDF\r\n\x1a\n"


@dataclass(frozen=True)
class NinaproFile:
    """Variables of a file.

    Attributes
    ----------
    path
    values : (n, 22)
        Of the glove; NaN where there is no sensor.
    calibrated
        Whether they are degrees already.
    movement : (n,)
        Label, 0 at rest.
    repetition : (n,)
        0 where not said.
    channels : name to (n,)
    rate
        [Hz]
    subject, exercise
    notes
        How these were found.
    """

    path: Path
    values: Array
    calibrated: bool
    movement: Index
    repetition: Index
    channels: Mapping[str, Array]
    rate: float
    subject: str
    exercise: str
    notes: tuple[str, ...]


def glove_counts(path: Path) -> Array:
    """Return the uncalibrated values of a file, (n, 22), NaN without a sensor.

    Raises
    ------
    FileError
        If it is missing, damaged or has no ``glove`` of 22 or 18 columns.
    """
    return _glove(path, _variables(path), "glove")


def _variables(path: Path) -> dict[str, Any]:
    if is_file(path):
        with naming(path, "read"), path.open("rb") as stream:
            start = stream.read(1024)
        if _HDF5 in start or start.startswith(b"MATLAB 7.3"):
            raise FileError(
                f"{path}: is of MATLAB 7.3 (HDF5), which is not read; load it in MATLAB and write "
                "it by save(NAME, '-v7'), or in Python by h5py and scipy.io.savemat"
            )
    return read_variables(path, _NAMES)


def read_file(path: Path, options: ImportOptions) -> NinaproFile:
    """Read a file.

    Raises
    ------
    FileError
        If it is missing, damaged, of MATLAB 7.3, or not of the layout.
    InputError
        If its rate cannot be told.
    """
    variables = _variables(path)
    ready = "angles" in variables and options.calibration is None and options.units is None
    values = _glove(path, variables, "angles" if ready else "glove")
    n = len(values)
    notes = ["variable angles taken, calibrated by the authors of the database"] if ready else []
    movement, said = _labels(path, variables, ("restimulus", "stimulus"), n)
    if movement is None:
        raise FileError(f"{path}: no variable restimulus or stimulus; give files of Ninapro")
    notes.append(f"movements by {said}")
    repetition, said = _labels(path, variables, ("rerepetition", "repetition"), n)
    notes.append(f"repetitions by {said}" if said else "repetitions counted")
    channels = {
        f"{name}_{i + 1:02d}": column
        for name in _CHANNELS
        for i, column in enumerate(_columns(path, variables, name, n).T)
    }
    rate, how = _rate(path, variables, channels, options)
    of_name = _FILE_NAME.search(path.stem)
    numbers = {
        key: _scalar(variables.get(key)) or (str(int(of_name[key])) if of_name else "1")
        for key in ("subject", "exercise")
    }
    return NinaproFile(
        path=path,
        values=values,
        calibrated=ready,
        movement=movement,
        repetition=np.zeros(n, dtype=np.int64) if repetition is None else repetition,
        channels=channels,
        rate=rate,
        subject=numbers["subject"],
        exercise=numbers["exercise"],
        notes=(*notes, how),
    )


def _glove(path: Path, variables: Mapping[str, Any], name: str) -> Array:
    """Return the values of the glove, (n, 22)."""
    raw = _matrix(path, variables, name)
    if raw is None or raw.shape[1] not in SENSORS or len(raw) < MIN_FRAMES:
        found = "missing" if raw is None else f"of shape {raw.shape}"
        raise FileError(
            f"{path}: variable {name} is {found}; the layout has {MIN_FRAMES} rows or more of "
            f"{' or '.join(map(str, SENSORS))} sensors"
        )
    values = np.full((len(raw), N_JOINTS), np.nan)
    values[:, [JOINT_INDEX[joint] for joint in SENSORS[raw.shape[1]]]] = raw
    return values


def _matrix(path: Path, variables: Mapping[str, Any], name: str) -> Array | None:
    if name not in variables:
        return None
    value = np.asarray(variables[name])
    if value.ndim != 2 or value.dtype.kind not in "fiub":
        raise FileError(
            f"{path}: variable {name} holds {value.dtype} of shape {value.shape}, not rows of "
            "numbers; download the file again"
        )
    return value.astype(float)


def _columns(path: Path, variables: Mapping[str, Any], name: str, n: int) -> Array:
    """Return a further signal, (n, columns); none where it is missing or of another length."""
    values = _matrix(path, variables, name)
    if values is None or len(values) != n:
        return np.empty((n, 0))
    return values


def _labels(
    path: Path, variables: Mapping[str, Any], names: Sequence[str], n: int
) -> tuple[Index | None, str]:
    """Return the first of some columns of labels that is there, and its name."""
    for name in names:
        values = _matrix(path, variables, name)
        if values is None:
            continue
        if values.size != n:
            raise FileError(
                f"{path}: variable {name} has {values.size} values for {n} rows of glove; download "
                "the file again"
            )
        labels = values.ravel()
        if not np.isfinite(labels).all() or np.abs(labels).max() > 1e6:
            raise FileError(f"{path}: variable {name} holds values that are no labels; download "
                            "the file again")  # fmt: skip
        return np.round(labels).astype(np.int64), name
    return None, ""


def _scalar(value: Any) -> str:
    """Return a whole number as text; empty where there is none."""
    array = np.asarray(value) if value is not None else np.empty(0)
    if array.size < 1 or array.dtype.kind not in "fiu":
        return ""
    number = float(array.ravel()[0])
    return str(int(number)) if 0 <= number < 1e6 else ""


def _rate(
    path: Path, variables: Mapping[str, Any], channels: Mapping[str, Array], options: ImportOptions
) -> tuple[float, str]:
    """Return the rate [Hz], and how it is known."""
    if options.rate_hz is not None:
        return options.rate_hz, f"rate {options.rate_hz:g} Hz as given"
    stated = _scalar(variables.get("frequency"))
    if stated and 1 <= float(stated) <= 100_000:
        return float(stated), f"rate {stated} Hz by variable frequency"
    emg, acc = (sum(name.startswith(f"{kind}_") for name in channels) for kind in ("emg", "acc"))
    known: Iterator[tuple[float, str]] = (
        (rate, f"rate {rate:g} Hz, that of {database}, by {emg} columns of emg")
        for columns, rate, database, fits in (
            ((10,), 100.0, "DB1", True),
            ((12,), 2000.0, "DB2, DB3, DB4 and DB7", True),
            ((16,), 200.0, "DB5", acc == 3),
            ((14, 16), 2000.0, "DB6 and DB8", acc != 3),
        )
        if emg in columns and fits
    )
    found = next(known, None)
    if found is None:
        raise InputError(
            f"{path}: {emg} columns of emg and {acc} of acc are of no database that is known, so "
            "that the rate is not; give it in Hz by --rate"
        )
    return found

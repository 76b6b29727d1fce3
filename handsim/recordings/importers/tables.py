"""The layout ``table``: any text table of joint angles, one recording a file.

Files are CSV, TSV and what spreadsheets and loggers export as text, of any locale and encoding
(`handsim.recordings.delimited`). What the columns are is said by a map
(`handsim.recordings.columns.column_map`), or found by the likeness of their names
(`handsim.recordings.columns.vocabulary`); what is uncertain is refused, and
``handsim recordings map FILE -o FILE.toml`` then drafts a map to be corrected. handsim's own files
need none.

- Angles are degrees, radians, or counts, which need ``scale`` in the map or a calibration.
- Times are s, ms, us, frames of a rate, or wall-clock stamps; they start at 0 in the recording.
  Frames that repeat the time before them are left out; time that runs backwards is refused.
- Distal joints of fingers without a sensor are filled (`posture_file.DIP_OF_PIP`); other joints
  without one need ``constant = 0.0`` in the map.
- ``experiments.csv`` beside the files gives subject, object, task, session, side, hand size and
  further columns by the name of the file; it, or the folder, may be named in place of the files.
- Left hands with the signs of a right hand's glove are turned around, and their notes say so.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from handsim.recordings.columns.clock import TIME_UNITS, clock_seconds
from handsim.recordings.columns.column_map import ColumnMap, MappedColumn, place_of, read_column_map
from handsim.recordings.columns.frames import Frames, Labels, recording_of
from handsim.recordings.columns.guess import guess_map
from handsim.recordings.columns.labels import labels_of, listed_files
from handsim.recordings.columns.sections import brief
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.glove.calibration import GloveCalibration, calibrated, read_calibration
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.posture_file import CHANNEL, filled_dips
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.sides import on_one_side
from handsim.types import Array

_CALIBRATE = "calibrate the glove with `handsim recordings calibrate` and give --calibration"


def read_tables(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read tables, one recording each.

    Parameters
    ----------
    files
        Tables, folders of them, or their ``experiments.csv``.
    options

    Raises
    ------
    FileError
        If a file is missing or no table, a column is not found or uncertain, or values are missing.
    InputError
        If counts come without a calibration, or frames without a rate.
    """
    column_map = read_column_map(options.column_map) if options.column_map else None
    calibration = read_calibration(options.calibration) if options.calibration else None
    recordings: list[Recording] = []
    for number, (path, said) in enumerate(listed_files(files), start=1):
        table = read_table(path, header=False)
        found = column_map or _found(table, options)
        of_map = {key: str(value) for key, value in found.labels.items()}
        labels = labels_of(path, number, {**of_map, **said}, options)
        recordings.append(_recording(table, found, calibration, labels, options))
    return on_one_side(recordings, str(files[0]))


def _found(table: Table, options: ImportOptions) -> ColumnMap:
    """Return the map that the names of the columns tell, if they leave no doubt."""
    guess = guess_map(table, options.side, options.units)
    if guess.doubts:
        more = f" and {len(guess.doubts) - 2} more" if len(guess.doubts) > 2 else ""
        row = f"row {table.header_line}: " if table.header else ""
        divided = f" ({table.found})" if table.found else ""
        raise FileError(
            f"{table.path}: {row}columns are not certain{divided}: "
            f"{brief('; '.join(guess.doubts[:2]), 200)}{more}; draft a map to correct with "
            f"`handsim recordings map {table.path} -o {table.path.stem}.toml` and give it by --map"
        )
    return guess.found


def _recording(
    table: Table,
    found: ColumnMap,
    calibration: GloveCalibration | None,
    labels: Labels,
    options: ImportOptions,
) -> Recording:
    if not len(table):
        raise FileError(f"{table.path}: holds no rows of values; check the file")
    measured = [column for column in found.columns if column.sensor is not None]
    places = [place_of(table, c.sensor, found.where) for c in measured if c.sensor is not None]
    time_place = _time_place(table, found)
    numbers = [] if time_place is None or found.time.unit == "clock" else [time_place]
    values = table.values([*places, *numbers])  # at once: files are long
    of_name = {column.name: i for i, column in enumerate(measured)}
    time = _times(table, found, values[:, -1] if numbers else None, options)
    with np.errstate(over="ignore", invalid="ignore"):
        angles, notes = _angles(table, found, values, of_name, calibration, options)
        channels = {
            c.name.removeprefix(CHANNEL).strip(): c.sign * c.scale * (values[:, i] - c.offset)
            for c, i in ((c, of_name[c.name]) for c in measured)
            if c.name.startswith(CHANNEL)
        }
        angles, filled = filled_dips(angles)
    names = tuple(
        str(measured[of_name[j]].sensor) if j in of_name else f"{j}_deg" for j in JOINT_NAMES
    )
    place_of_joint = [places[of_name[j]] if j in of_name else None for j in JOINT_NAMES]

    def cell(number: int, joint: int) -> str:
        place = place_of_joint[joint] if joint >= 0 else time_place
        row = int(np.searchsorted(table.numbers, number))
        return table.cells(row)[place] if place is not None else "nan"

    said = [table.found] if table.found else []
    frames = Frames(
        where=str(table.path),
        time=time,
        angles=angles,
        numbers=table.numbers,
        columns=(str(found.time.column or "frames"), *names),
        channels=channels,
        notes=(*said, *found.notes, *_left_out(table, places, found), *notes, *filled),
        cell=cell,
    )
    return recording_of(frames, labels, bridge_s=options.bridge_s, unwrap=options.unwrap)


def _time_place(table: Table, found: ColumnMap) -> int | None:
    column = found.time.column
    return None if column is None else place_of(table, column, found.where)


def _times(table: Table, found: ColumnMap, values: Array | None, options: ImportOptions) -> Array:
    """Return the times of the rows [s], from the numbers in their column unless it is a clock."""
    place, unit = _time_place(table, found), found.time.unit
    rate = options.rate_hz or found.time.rate_hz
    if (place is None or unit == "frames") and rate is None:
        said = "no column of time" if place is None else f"frames in column {found.time.column}"
        raise InputError(
            f"{table.path}: {said} ({found.where}); give the rate in Hz by --rate, or rate_hz in "
            "the [time] of a map"
        )
    if place is None:
        return np.arange(len(table)) / (rate or 1.0)
    if values is None:
        return clock_seconds([cells[0] for cells in table.texts([place])])
    with np.errstate(over="ignore"):
        times = values * TIME_UNITS[unit]
    return times / (rate or 1.0) if unit == "frames" else times


def _angles(
    table: Table,
    found: ColumnMap,
    values: Array,
    of_name: Mapping[str, int],
    calibration: GloveCalibration | None,
    options: ImportOptions,
) -> tuple[Array, list[str]]:
    """Return the angles (n, 22) [deg], NaN where a joint has no column, and notes."""
    angles, notes = np.full((len(table), N_JOINTS), np.nan), list[str]()
    counted: list[MappedColumn] = []
    for column in found.columns:
        if column.name not in JOINT_INDEX:
            continue
        joint, unit = JOINT_INDEX[column.name], options.units or column.unit
        if column.constant is not None:
            degrees = np.rad2deg(column.constant) if unit == "rad" else column.constant
            angles[:, joint] = degrees
            notes.append(f"{column.name} taken as constant, {degrees:g} deg")
        elif unit == "counts" and not (column.scaled and calibration is None):
            counted.append(column)
        else:
            raw = values[:, of_name[column.name]]
            angle = column.sign * column.scale * (raw - column.offset)
            angles[:, joint] = np.rad2deg(angle) if unit == "rad" else angle
    if counted:
        joints = [JOINT_INDEX[column.name] for column in counted]
        counts = np.full_like(angles, np.nan)
        counts[:, joints] = values[:, [of_name[column.name] for column in counted]]
        of_counts, said = _of_counts(table, counts, counted, calibration)
        angles[:, joints] = of_counts[:, joints]
        notes += said
    return angles, notes


def _of_counts(
    table: Table,
    counts: Array,
    columns: Sequence[MappedColumn],
    calibration: GloveCalibration | None,
) -> tuple[Array, list[str]]:
    """Return the angles [deg] of counts, (n, 22) each, and notes."""
    if calibration is None:
        known = counts[np.isfinite(counts)]
        found = f" from {known.min():g} to {known.max():g}" if known.size else ""
        raise InputError(
            f"{table.path}: raw counts{found}; {_CALIBRATE}, or give their scale in a map"
        )
    angles, notes = calibrated(calibration, counts, str(table.path))
    unused = [c.name for c in columns if (c.sign, c.offset, c.scale) != (1, 0.0, 1.0)]
    if unused:
        notes.append(f"of the map not used, but of the calibration: {', '.join(unused)}")
    return angles, notes


def _left_out(table: Table, places: Sequence[int], found: ColumnMap) -> list[str]:
    """Say which columns of the table are not used."""
    used = {*places, _time_place(table, found)}
    names = [brief(name) for i, name in enumerate(table.header) if name and i not in used]
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    return [f"columns ignored: {', '.join(names[:6])}{more}"] if names else []


LAYOUT = Layout(
    "table",
    "CSV, TSV or text exports of joint angles, any names of columns (by a map), one file each",
    read_tables,
    frozenset(
        {"subject", "side", "units", "column_map", "calibration", "hand", "bridge_s", "rate_hz"}
        | {"object", "task", "unwrap"}
    ),
)

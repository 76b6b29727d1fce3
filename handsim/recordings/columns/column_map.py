"""What each column of a table is, as a TOML file says it.

::

    [time]                      # left out: frames of a stated rate
    column = "t"                # name in the header, or number from 1
    unit = "ms"                 # s, ms, us, frames (with rate_hz) or clock (stamps, dates too)
    rate_hz = 120               # for frames, or where there is no column of time

    [[column]]
    name = "index_mcp"          # one of the 22 joints, or "channel:<name>"
    sensor = "IndexMPJ"         # name in the header, or number from 1
    unit = "deg"                # deg, rad or counts; what says --units overrides it
    sign = 1                    # -1 turns it around
    offset = 0.0                # angle = sign * scale * (value - offset), in its unit
    scale = 1.0                 # with counts: degrees a count

    [[column]]
    name = "palm_arch"          # a joint without a sensor
    constant = 0.0              # its angle, in its unit

    [recording]                 # all optional
    subject = "P1"
    object = "cup"
    task = "cup-drink"
    side = "right"
    hand_length_m = 0.19
    hand_breadth_m = 0.085

Distal joints of fingers that are not named are filled from the joint before them. Any other joint
must be named.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from handsim.errors import FileError
from handsim.joints import JOINT_NAMES
from handsim.recordings.columns.clock import TIME_UNITS, TimeUnit
from handsim.recordings.columns.sections import Section, read_sections
from handsim.recordings.columns.vocabulary import AngleUnit
from handsim.recordings.delimited import Table
from handsim.recordings.posture_file import CHANNEL, DIP_JOINTS
from handsim.wording import number_of

ANGLE_UNITS: tuple[AngleUnit, ...] = ("deg", "rad", "counts")
_COLUMN_KEYS = ("name", "sensor", "unit", "sign", "offset", "scale", "constant")
_LABEL_KEYS = ("subject", "object", "task", "side", "hand_length_m", "hand_breadth_m")


@dataclass(frozen=True)
class MappedColumn:
    """A column of the table, or a constant, and what it is.

    Attributes
    ----------
    name
        A joint, or ``channel:<name>``.
    sensor
        Name in the header or number from 1; None for a constant.
    unit, sign, offset, scale
        The value is ``sign * scale * (value - offset)`` in its unit.
    constant
        Angle of a joint without a sensor, in its unit.
    scaled
        Whether the scale was said, by which counts are degrees without a calibration.
    """

    name: str
    sensor: str | int | None
    unit: AngleUnit = "deg"
    sign: int = 1
    offset: float = 0.0
    scale: float = 1.0
    constant: float | None = None
    scaled: bool = False


@dataclass(frozen=True)
class TimeColumn:
    """The column of time; None where frames are counted by the rate."""

    column: str | int | None = None
    unit: TimeUnit = "s"
    rate_hz: float | None = None


@dataclass(frozen=True)
class ColumnMap:
    """What the columns of a table are.

    Attributes
    ----------
    where
        What messages begin with.
    time
    columns
    labels
        Of the section ``recording``.
    notes
        What was decided without being said.
    """

    where: str
    time: TimeColumn
    columns: tuple[MappedColumn, ...]
    labels: Mapping[str, str | float] = field(default_factory=dict[str, str | float])
    notes: tuple[str, ...] = ()

    def missing(self) -> list[str]:
        """Return the joints that are neither named nor can be filled."""
        named = {column.name for column in self.columns}
        return [
            joint
            for joint in JOINT_NAMES
            if joint not in named
            and not (joint in DIP_JOINTS and joint.replace("_dip", "_pip") in named)
        ]


def read_column_map(path: Path) -> ColumnMap:
    """Read a map.

    Raises
    ------
    FileError
        If it is missing, no TOML, has unknown words or names, names a joint twice or leaves one
        out.
    """
    content = read_sections(Path(path), ("time", "column", "recording"))
    columns = tuple(map(_column, content.sections("column", _COLUMN_KEYS)))
    names = [column.name for column in columns]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise FileError(f"{path}: {twice} is named twice; name each joint and channel once")
    found = ColumnMap(
        where=str(path),
        time=_time(content),
        columns=columns,
        labels=_labels(content.section("recording", _LABEL_KEYS)),
    )
    missing = found.missing()
    if missing:
        raise FileError(
            f"{path}: no column for {', '.join(missing)}; name their sensors, or give "
            "'constant = 0.0' for joints that have none"
        )
    return found


def _time(content: Section) -> TimeColumn:
    section = content.section("time", ("column", "unit", "rate_hz"))
    unit = cast("TimeUnit", section.text("unit", "s", tuple(TIME_UNITS)))
    rate = section.number("rate_hz", 0.0)
    if "rate_hz" in section and not 1 <= rate <= 100_000:
        raise FileError(f"{section.where}: rate_hz = {rate:g}; give 1 to 100000 Hz")
    return TimeColumn(section.column("column"), unit, rate or None)


def _column(section: Section) -> MappedColumn:
    name = section.text("name")
    if name not in JOINT_NAMES and not name.startswith(CHANNEL):
        raise FileError(
            f"{section.where}: name = '{name}' is no joint; use one of {', '.join(JOINT_NAMES)}, "
            f"or '{CHANNEL}<name>'"
        )
    sensor = section.column("sensor")
    if (sensor is None) == ("constant" not in section):
        raise FileError(f"{section.where}: {name} needs either a sensor or a constant")
    sign = section.number("sign", 1)
    if sign not in (1, -1):
        raise FileError(f"{section.where}: sign = {sign:g}; use 1 or -1")
    return MappedColumn(
        name=name,
        sensor=sensor,
        unit=cast("Any", section.text("unit", "deg", ANGLE_UNITS)),
        sign=int(sign),
        offset=section.number("offset", 0.0),
        scale=section.number("scale", 1.0),
        constant=section.number("constant", 0.0) if "constant" in section else None,
        scaled="scale" in section,
    )


def _labels(section: Section) -> dict[str, str | float]:
    labels: dict[str, str | float] = {}
    for key in section.values:
        if key.startswith("hand_"):
            labels[key] = section.number(key, 0.0)
        else:
            labels[key] = section.text(key, "", ("right", "left") if key == "side" else ())
    return labels


def place_of(table: Table, column: str | int, where: str) -> int:
    """Return the place of a column, from 0, by its name in the header or its number from 1.

    Raises
    ------
    FileError
        If the table has no such column, or two of the name.
    """
    if isinstance(column, int):
        if column > table.n_columns:
            raise FileError(
                f"{table.path}: has {number_of(table.n_columns, 'column')}; {where} names number "
                f"{column}"
            )
        return column - 1
    count = table.header.count(column)
    if count != 1:
        found = "missing" if count == 0 else "there twice"
        divided = f" ({table.found})" if table.found else ""
        raise FileError(
            f"{table.path}: row {table.header_line}: column '{column}', named by {where}, is "
            f"{found}{divided}; correct the map, or name the column by its number from 1"
        )
    return table.header.index(column)

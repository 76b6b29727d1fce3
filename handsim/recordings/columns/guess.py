"""The map of a table found by the likeness of its names; what is uncertain is said."""

import re
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from handsim.errors import FileError
from handsim.joints import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from handsim.recordings.columns.clock import TimeUnit, is_clock, unit_by_steps
from handsim.recordings.columns.column_map import ColumnMap, MappedColumn, TimeColumn
from handsim.recordings.columns.vocabulary import (
    AngleUnit,
    likeness,
    side_of,
    turned_around,
    unit_of,
    words_of,
)
from handsim.recordings.delimited import Table
from handsim.recordings.posture_file import CHANNEL, DIP_JOINTS
from handsim.types import Array, Side

CERTAIN, LIKELY = 0.8, 0.5
"""Likeness from which a column is taken without asking, and from which it is drafted."""
_LOOKED_AT = 2000  # rows by which units are judged
_TIMES = ("time", "t", "timestamp", "zeit", "temps", "datetime", "clock", "uhrzeit", "elapsed",
          "seconds", "zeitstempel", "stamp", "sec", "utc")  # fmt: skip
_COUNTED = ("frame", "sample", "frames", "samples", "bild", "nr", "no")
_TIME_UNITS: dict[str, TimeUnit] = {
    **dict.fromkeys(("s", "sec", "secs", "seconds", "sekunden"), "s"),
    **dict.fromkeys(("ms", "msec", "milliseconds", "millis"), "ms"),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microseconds", "micros"), "us"),
}
_RADIANS_AT_MOST, _MAX_COUNT = 6.5, 255.0
Header = tuple[str, ...]


@dataclass(frozen=True)
class Guess:
    """A map that was found, and how sure it is.

    Attributes
    ----------
    found
    scores
        Likeness of each joint's column.
    doubts
        What has to be said by the user; none if the map can be used as it is.
    """

    found: ColumnMap
    scores: dict[str, float]
    doubts: tuple[str, ...]


def guess_map(table: Table, side: Side | None = None, units: AngleUnit | None = None) -> Guess:
    """Find out what the columns of a table are.

    Parameters
    ----------
    table
    side
        Which hand is meant where the table holds two.
    units
        Of the angles, where that is known.
    """
    header = table.header or tuple(f"{i}" for i in range(1, table.n_columns + 1))
    doubts: list[str] = [] if table.header else ["the file has no header"]
    notes: list[str] = []
    head = replace(table, lines=table.lines[:_LOOKED_AT], numbers=table.numbers[:_LOOKED_AT])
    if not len(table):
        raise FileError(f"{table.path}: holds no rows of values; check the file")
    values = head.values(range(table.n_columns))
    with np.errstate(over="ignore", invalid="ignore"):
        time, time_place = _time(head, header, values, doubts, notes)
    scores, labels = _scores(header, time_place, side, doubts, notes)
    places = _assigned(scores)
    if sum(joint not in ("palm_arch", "wrist_flexion") for joint in places) < 5:
        places, scores = _numbered(header, time_place) or (places, scores)
    of_rows = table.units or ("",) * len(header)
    said: dict[str, AngleUnit | None] = {
        j: unit_of(header[p], of_rows[p] if p < len(of_rows) else "") for j, p in places.items()
    }
    silent = [p for joint, p in places.items() if said[joint] is None]
    unit: AngleUnit = units or "deg"
    if silent and units is None:
        unit, sure = _unit_by_values(values[:, silent])
        if sure:
            notes.append(f"angles taken as {unit} by their size")
        else:
            doubts.append(
                f"the unit of the angles is not said ({unit} by their size); give --units deg, "
                "rad or counts"
            )
    columns = [
        MappedColumn(
            name=joint,
            sensor=header[p] if table.header.count(header[p]) == 1 else p + 1,
            unit=units or said[joint] or unit,
            sign=-1 if turned_around(header[p]) else 1,
        )
        for joint, p in places.items()
    ]
    columns += [
        MappedColumn(name, name) for name in table.header
        if name.startswith(CHANNEL) and table.header.count(name) == 1
    ]  # fmt: skip
    found = ColumnMap(f"the header of {table.path.name}", time, tuple(columns), labels,
                      tuple(notes))  # fmt: skip
    doubts += _doubts(scores, places, header, found)
    best = {joint: float(scores[p, JOINT_INDEX[joint]]) for joint, p in places.items()}
    return Guess(found, best, tuple(doubts))


def _doubts(scores: Array, places: dict[str, int], header: Header, found: ColumnMap) -> list[str]:
    doubts: list[str] = []
    for joint, place in places.items():
        column = scores[:, JOINT_INDEX[joint]]
        score = column[place]
        rivals = [header[i] for i in np.flatnonzero(column >= score - 0.1) if i != place]
        if rivals:
            doubts.append(f"{joint} may be {header[place]} or {rivals[0]}")
        elif score < CERTAIN:
            doubts.append(f"{joint} may be {header[place]}")
        elif turned_around(header[place]):
            doubts.append(f"the sign of {header[place]}")
    missing = found.missing()
    if missing:
        doubts.append(f"no column for {', '.join(missing)}")
    return doubts


def _scores(
    header: Header, time_place: int | None, side: Side | None, doubts: list[str], notes: list[str]
) -> tuple[Array, dict[str, str | float]]:
    """Likeness of each column to each joint, (n columns, 22), those of the other hand 0."""
    words = [words_of(name) for name in header]
    numbers = {int(w) for each in words if "finger" in each for w in each if w.isdecimal()
               and len(w) < 3}  # fmt: skip
    thumb = int(not (numbers and (0 in numbers or any("thumb" in each for each in words))))
    scores = np.zeros((len(header), N_JOINTS))
    for i, name in enumerate(header):
        if i != time_place and not name.startswith(CHANNEL):
            for joint, score in likeness(name, thumb).items():
                scores[i, JOINT_INDEX[joint]] = score
    hands = [side_of(name) if scores[i].max() >= LIKELY else None for i, name in enumerate(header)]
    sides = {hand for hand in hands if hand is not None}
    labels: dict[str, str | float] = {}
    if len(sides) == 2:
        if side is None:
            doubts.append("the table holds two hands; give --side right or left")
        wanted: Side = side or "right"
        scores[[hand not in (wanted, None) for hand in hands]] = 0
        labels["side"] = wanted
        notes.append(f"columns of the {wanted} hand taken of two")
    elif sides and hands.count(None) < len(hands) / 2:
        labels["side"] = sides.pop()
    return scores, labels


def _assigned(scores: Array) -> dict[str, int]:
    """Columns of joints, at most one each, so that the sum of likenesses is largest."""
    rows, joints = linear_sum_assignment(scores, maximize=True)
    found = {int(j): int(p) for p, j in zip(rows, joints, strict=True) if scores[p, j] >= LIKELY}
    return {JOINT_NAMES[j]: found[j] for j in sorted(found)}


def _numbered(header: Header, time_place: int | None) -> tuple[dict[str, int], Array] | None:
    """22 or 18 columns of one name and rising numbers: glove order, with a likeness of 0.6."""
    ended = [re.fullmatch(r"(.*?)(\d+)\D*", name) for name in header]
    stems: dict[str, list[int]] = {}
    for i, match in enumerate(ended):
        if match and i != time_place:
            stems.setdefault(match[1], []).append(i)
    for places in stems.values():
        joints = [n for n in JOINT_NAMES if len(places) == N_JOINTS or n not in DIP_JOINTS]
        if len(places) == len(joints):
            scores = np.zeros((len(header), N_JOINTS))
            for joint, place in zip(joints, places, strict=True):
                scores[place, JOINT_INDEX[joint]] = 0.6
            return dict(zip(joints, places, strict=True)), scores
    return None


def _unit_by_values(values: Array) -> tuple[AngleUnit, bool]:
    """Return the unit of angles by their size, and whether it can be no other."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return "deg", False
    if np.abs(finite).max() <= _RADIANS_AT_MOST:
        return "rad", False
    whole = bool((finite == np.round(finite)).all()) and finite.min() >= 0
    return ("counts", False) if whole and finite.max() <= _MAX_COUNT else ("deg", True)


def _time(
    table: Table, header: Header, values: Array, doubts: list[str], notes: list[str]
) -> tuple[TimeColumn, int | None]:
    """Return the column of time, with the doubts and notes about it."""
    bare = [_time_word(name) for name in header]
    named = [i for i, (word, _) in enumerate(bare) if word in _TIMES]
    counted = [i for i, (word, _) in enumerate(bare) if word in _COUNTED]
    if not named and not counted:
        first = table.cells(0)[0]
        rising = bool((np.diff(values[:, 0]) > 0).all()) and len(values) > 1
        if not (is_clock(first) or (rising and not likeness(header[0]))):
            notes.append("no column of time")
            return TimeColumn(), None
        named = [0]
        if not is_clock(first):
            doubts.append(f"column {header[0]} may be the time")
    place = (named or counted)[0]
    sensor = header[place] if table.header.count(header[place]) == 1 else place + 1
    unit = bare[place][1] or _TIME_UNITS.get(
        (table.units or ("",) * len(header))[place].strip("[]() ").lower()
    )
    if not named:
        return TimeColumn(sensor, "frames"), place
    if is_clock(table.cells(0)[place]):
        return TimeColumn(sensor, "clock"), place
    if unit is None:
        unit = unit_by_steps(values[:, place])
        if unit is None:
            doubts.append(f"the unit of {header[place]} is not said")
        elif unit != "s":
            notes.append(f"{header[place]} taken as {unit} by its steps")
    return TimeColumn(sensor, unit or "s"), place


def _time_word(name: str) -> tuple[str, TimeUnit | None]:
    """The word of a name of a time column, and the unit that it says."""
    words = [w for w in re.split(r"[\s_\-.\[\]()/:#]+", name.strip().lower()) if w]
    if not words:
        return "", None
    unit = _TIME_UNITS.get(words[-1]) if len(words) > 1 else None
    if words[0] in ("system", "host", "unix", "epoch", "elapsed", "recording") and len(words) > 1:
        words = words[1:]
    camel = re.fullmatch(r"(time|timestamp|stamp)(s|ms|us|sec)", words[0])
    if camel:
        return camel[1], _TIME_UNITS[camel[2]]
    if len(words) > 1 and unit is None and words[0] not in ("time", "timestamp", *_COUNTED):
        return "", None
    return words[0], unit

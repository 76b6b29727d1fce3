"""Draft the map of a table from its names, for the user to correct."""

import io
from collections.abc import Iterator
from pathlib import Path

from handsim.joints import JOINTS
from handsim.recordings.columns.clock import TIME_UNITS
from handsim.recordings.columns.column_map import MappedColumn, place_of
from handsim.recordings.columns.guess import CERTAIN, Guess, guess_map
from handsim.recordings.columns.sections import quoted
from handsim.recordings.columns.vocabulary import AngleUnit
from handsim.recordings.delimited import Table, read_table
from handsim.recordings.posture_file import DIP_JOINTS, DIP_OF_PIP
from handsim.types import Side

_HEAD = """\
# What the columns of {name} are. Correct it, then:
#   handsim recordings import {name} --format table --map THIS.toml -o FOLDER
# angle = sign * scale * (value - offset), in its unit (deg, rad or counts). Flexion and spreading
# are positive. sensor: name in the header, or number of the column from 1.
"""


def draft_map(path: Path, side: Side | None = None, units: AngleUnit | None = None) -> str:
    """Return a map of a table as TOML, with the likeness of each name to its joint as a comment.

    Columns that are like no joint, joints without a column, and guesses below a likeness of 0.5
    stand as comments. The text is a valid map as soon as every joint has a column or a constant.

    Parameters
    ----------
    path
        The table.
    side
        Which hand is meant where the table holds two.
    units
        Of the angles, where that is known.

    Raises
    ------
    FileError
        If the file is no table.
    """
    table = read_table(Path(path), header=False)
    guess = guess_map(table, side, units)
    text = io.StringIO()
    text.write(_HEAD.format(name=table.path.name))
    if table.found:
        text.write(f"# found: {table.found}\n")
    for doubt in guess.doubts:
        text.write(f"# to decide: {_line(doubt)}\n")
    text.write("\n" + "\n".join(_time_lines(guess)) + "\n")
    of_joint = {column.name: column for column in guess.found.columns}
    for joint in JOINTS:
        column = of_joint.pop(joint.name, None)
        lines = _missing_lines(joint.name) if column is None else _column_lines(column, guess)
        text.write("\n" + "\n".join(lines) + "\n")
    for column in of_joint.values():
        text.write("\n" + "\n".join(_column_lines(column, guess)) + "\n")
    for sensor in _unmapped(table, guess):
        text.write(f'\n# [[column]]\n# name = "channel:..."\n# sensor = {sensor}\n')
    text.write("\n" + "\n".join(_label_lines(guess)) + "\n")
    return text.getvalue()


def _line(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)


def _sensor(sensor: str | int | None) -> str:
    return quoted(sensor) if isinstance(sensor, str) else str(sensor)


def _time_lines(guess: Guess) -> Iterator[str]:
    time = guess.found.time
    yield "[time]"
    if time.column is None:
        yield "# no column of time was found"
        yield "rate_hz = 100  # to decide"
        return
    yield f"column = {_sensor(time.column)}"
    yield f"unit = {quoted(time.unit)}  # {', '.join(TIME_UNITS)}"
    if time.unit == "frames":
        yield "rate_hz = 100  # to decide"


def _column_lines(column: MappedColumn, guess: Guess) -> Iterator[str]:
    score = guess.scores.get(column.name)
    yield "[[column]]"
    yield f"name = {quoted(column.name)}"
    said = "" if score is None else f"  # likeness {score:.2f}"
    doubtful = ", check it" if score is not None and score < CERTAIN else ""
    yield f"sensor = {_sensor(column.sensor)}{said}{doubtful}"
    if score is None:
        return
    yield f"unit = {quoted(column.unit)}"
    yield f"sign = {column.sign}"
    yield "offset = 0.0"
    yield "# scale = 0.5  # degrees a count" if column.unit == "counts" else "scale = 1.0"


def _missing_lines(joint: str) -> Iterator[str]:
    if joint in DIP_JOINTS:
        yield f"# {joint}: no column; filled as {DIP_OF_PIP:g} times {joint.replace('dip', 'pip')}"
    else:
        yield f"# {joint}: no column; name its sensor, or give it a constant angle"
    yield "# [[column]]"
    yield f"# name = {quoted(joint)}"
    yield "# constant = 0.0"


def _unmapped(table: Table, guess: Guess) -> Iterator[str]:
    used = {
        place_of(table, each, "the draft")
        for each in (guess.found.time.column, *(c.sensor for c in guess.found.columns))
        if each is not None
    }
    for place in range(table.n_columns):
        if place not in used:
            name = table.header[place] if table.header else ""
            unique = bool(name) and table.header.count(name) == 1
            yield quoted(name) if unique else f"{place + 1}" + (f"  # {_line(name)}" * bool(name))


def _label_lines(guess: Guess) -> Iterator[str]:
    yield "[recording]"
    for key in ("subject", "object", "task"):
        yield f'# {key} = ""'
    side = guess.found.labels.get("side")
    yield f"side = {quoted(str(side))}" if side else '# side = "right"'
    yield "# hand_length_m = 0.19"
    yield "# hand_breadth_m = 0.085"

"""A signal over time, from a file: a recording with channels, or a table of time and values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.joints import JOINT_NAMES
from handsim.learning.demonstration import Demonstration
from handsim.recordings.columns.text_table import Table
from handsim.recordings.delimited import read_table
from handsim.recordings.posture_file import CHANNEL, checked_postures, read_posture_table
from handsim.recordings.recording import check_times
from handsim.recordings.signals import DISTANCE, ENVELOPE, signals_of
from handsim.types import Array

TIME = "time_s"
_SECONDS = frozenset({"s", "sec", ""})


@dataclass(frozen=True, eq=False)
class SignalFile:
    """What a file says over time.

    Attributes
    ----------
    path
    time : (n,) [s], increasing
    signals : name to (n,)
        Its channels and what is derived from them (`handsim.recordings.signals`); NaN where a value
        is missing.
    q : (n, 22) [rad]
        Postures recorded at the same time; None if the file holds none.
    """

    path: Path
    time: Array
    signals: Mapping[str, Array]
    q: Array | None


def read_signal_file(path: Path) -> SignalFile:
    """Read a recording, or a table of ``time_s`` and one or more signals.

    Columns of a table without joints may be called ``channel:<name>`` or ``<name>``.

    Raises
    ------
    FileError
        If the file is missing or no table, a column is missing or twice, time does not increase,
        there are fewer than 10 frames or no signals, or joints have gaps.
    """
    path = Path(path)
    table = read_table(path)
    q = None
    if any(f"{name}_deg" in table.header for name in JOINT_NAMES):
        content = read_posture_table(path)
        time, q = checked_postures(content)
        channels = dict(content.channels)
    else:
        time, channels = _columns(table)
    known = {name: np.where(np.isfinite(x), x, np.nan) for name, x in channels.items()}
    signals = signals_of(time, known)
    if not signals:
        raise FileError(f"{path}: holds no signal; add a column channel:<name>")
    return SignalFile(path, time, signals, q)


def chosen_channel(
    file: SignalFile, demonstrations: Sequence[Demonstration], channel: str | None, given: bool
) -> tuple[str, Array]:
    """Return which channel drives, and its values (n,) in the file.

    Parameters
    ----------
    file
    demonstrations
    channel
        The name that was asked for. In a file of one signal it says what that is. By default
        ``distance_m``, then ``emg_envelope``, then the only one.
    given
        Whether the map is given, so that the recordings need not hold the channel.

    Raises
    ------
    UnknownNameError, InputError
        If there is no such channel, or several could be meant.
    """
    if channel is not None:
        if channel in file.signals:
            return channel, file.signals[channel]
        if len(file.signals) == 1:
            return channel, next(iter(file.signals.values()))
        raise UnknownNameError(f"channel of {file.path}", channel, tuple(file.signals))
    recorded = {name for d in demonstrations for name in d.signals}
    usable = [name for name in file.signals if given or name in recorded]
    for name in (DISTANCE, ENVELOPE, *(usable if len(usable) == 1 else ())):
        if name in usable:
            return name, file.signals[name]
    if usable:
        raise InputError(f"{file.path}: holds {_some(usable)}; name one with --channel")
    known = f"hold {_some(sorted(recorded))}" if recorded else "hold no channels"
    raise InputError(
        f"{file.path}: holds {_some(list(file.signals))}; the controller's recordings {known}; say "
        "with --channel which it is, or give the values at rest and at the grasp with --range"
    )


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return ", ".join(names[:5]) + more


def _columns(table: Table) -> tuple[Array, dict[str, Array]]:
    """Return time (n,) [s] and the other columns of a table without joints."""
    names = [name.removeprefix(CHANNEL).strip() for name in table.header]
    for i, name in enumerate(names):
        if name and name in names[:i]:
            raise FileError(_at(table, table.header_line, name, "is there twice; name it once"))
    if TIME not in names:
        raise FileError(
            _at(table, table.header_line, TIME, "is missing; name the columns time_s,value")
        )
    place = names.index(TIME)
    unit = table.units[place].strip("[]() ").lower() if table.units else ""
    if unit not in _SECONDS:
        raise FileError(_at(table, table.header_line + 1, TIME, f"unit '{unit}'; give seconds"))
    values = table.values(range(len(names)))
    time = values[:, place]
    wrong = np.flatnonzero(~np.isfinite(time))
    if wrong.size:
        row = int(table.numbers[wrong[0]])
        raise FileError(_at(table, row, TIME, "is not a finite number; remove the row"))
    check_times(str(table.path), time, table.numbers)
    return time, {n: values[:, i] for i, n in enumerate(names) if n and i != place}


def _at(table: Table, row: int, column: str, said: str) -> str:
    return f"{table.path}: row {row}, column {column} {said}"

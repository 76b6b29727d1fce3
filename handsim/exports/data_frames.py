"""Movements as data frames of pandas, and those as Parquet or CSV.

Columns are named as in the CSV files of this package: ``time_s``, joints with ``_deg``, channels as
``channel:<name>``. Angles are degrees in them and radians everywhere else.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.exports.episode import Episode
from handsim.exports.export_sources import Exported, episodes_of, is_one
from handsim.exports.libraries import library
from handsim.files import replacing
from handsim.types import Array

if TYPE_CHECKING:
    import pandas

_ENDS = {"rad": "_deg", "rad/s": "_deg_s", "m": "_m", "m/s": "_m_s", "N": "_n", "": ""}
"""How the name of a column ends, by the unit of what it is made from."""


def to_frame(exported: Exported) -> "pandas.DataFrame":
    """Return movements as a data frame, a row a sample.

    Parameters
    ----------
    exported
        A rollout, a recording, a posture sequence; or several, or a set of recordings. Several are
        below each other, with the columns ``episode`` (from 0), ``name`` and ``task`` before all
        others; what one of them lacks is NaN there.

    Returns
    -------
    pandas.DataFrame
        Its ``attrs["episodes"]`` holds what is known of each movement as a whole: outcome,
        conditions, subject, hand.

    Raises
    ------
    MissingToolError
        If pandas is not installed.
    InputError
        If there is nothing to export.
    """
    pandas = library("pandas")
    episodes = episodes_of(exported)
    tables = [pandas.DataFrame(_columns(episode)) for episode in episodes]
    if not is_one(exported):
        for number, (episode, table) in enumerate(zip(episodes, tables, strict=True)):
            for place, (column, value) in enumerate(
                (("episode", number), ("name", episode.name), ("task", episode.task))
            ):
                table.insert(place, column, value)
    frame = tables[0] if len(tables) == 1 else pandas.concat(tables, ignore_index=True)
    frame.attrs["episodes"] = [_facts(episode) for episode in episodes]
    return frame


def write_frame(frame: "pandas.DataFrame", path: Path) -> None:
    """Write a data frame as CSV where the suffix is ``.csv``, else as Parquet.

    It is written as a whole or not at all. Parquet keeps what is known of each movement
    (``attrs``). CSV has as many digits as it takes: either gives the same numbers back.

    Raises
    ------
    MissingToolError
        If pyarrow is not installed, for Parquet.
    FileError
        If the file cannot be written.
    """
    as_text = path.suffix.lower() == ".csv"
    if not as_text:
        library("pyarrow")
    with replacing(path) as temporary:
        if as_text:
            frame.to_csv(temporary, index=False)
        else:
            frame.to_parquet(temporary, engine="pyarrow", index=False)


def _columns(episode: Episode) -> dict[str, Any]:
    columns: dict[str, Any] = {"time_s": episode.time}
    if episode.phases:
        columns["phase"] = phases_at(episode, episode.time)
    for quantity in episode.quantities:
        for i, (column, unit) in enumerate(zip(quantity.columns, quantity.units, strict=True)):
            values = quantity.values[:, i]
            in_degrees = np.rad2deg(values) if unit.startswith("rad") else values
            columns[column + _ENDS[unit]] = in_degrees
    return columns


def _facts(episode: Episode) -> dict[str, Any]:
    return {
        "name": episode.name,
        "kind": episode.kind,
        "task": episode.task,
        "sentence": episode.sentence,
        **episode.facts,
    }


def phases_at(episode: Episode, time: Array) -> list[str]:
    """Return the name of the phase at each time (n,) [s]; empty before the first."""
    starts = np.array([start for _, start in episode.phases])
    names = ["", *(name for name, _ in episode.phases)]
    return [names[i] for i in np.searchsorted(starts, time + 1e-9, side="right")]

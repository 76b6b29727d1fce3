"""The Parquet files of a LeRobot data set: a row a frame, an episode a row group."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.exports.lerobot.data_set_layout import DATA_MB, DATA_PATH, file_of, made
from handsim.exports.lerobot.features import Take
from handsim.exports.libraries import library

Columns = dict[str, npt.NDArray[Any]]
"""What a data set holds of an episode, by name: (n,) or (n, k)."""

COUNTED: tuple[str, ...] = ("frame_index", "episode_index", "index", "task_index")
"""What LeRobot counts frames by, from 0."""


@dataclass(frozen=True)
class Rows:
    """Where the frames of an episode are.

    Attributes
    ----------
    file
        Number of the file, from 0.
    start, end
        In the whole data set; the last is not of them.
    """

    file: int
    start: int
    end: int


def columns_of(takes: Sequence[Take], tasks: Sequence[str]) -> list[Columns]:
    """Return what the data set holds of each episode.

    Parameters
    ----------
    takes
    tasks
        Sentences, in the order of their numbers.
    """
    found: list[Columns] = []
    start = 0
    for number, take in enumerate(takes):
        n = len(take.time)
        features = {
            each.name: each.values[:, 0] if each.values.shape[1] == 1 else each.values
            for each in take.features
        }
        counted = (
            *(np.arange(n), np.full(n, number), np.arange(start, start + n)),
            np.full(n, tasks.index(take.episode.sentence)),
        )
        time = {"timestamp": take.time.astype(np.float32)}
        found.append({**features, **time, **dict(zip(COUNTED, counted, strict=True))})
        start += n
    return found


def write_frames(
    episodes: Sequence[Columns], folder: Path, max_bytes: int = DATA_MB * 2**20
) -> list[Rows]:
    """Write the frames of all episodes, and return where they are."""
    arrow, parquet = library("pyarrow"), library("pyarrow.parquet")
    rows: list[Rows] = []
    with ExitStack() as open_file:
        writer, size, file = None, 0, -1
        for columns in episodes:
            table = arrow.table({name: _array(arrow, each) for name, each in columns.items()})
            if writer is None or size + table.nbytes > max_bytes:
                open_file.close()
                file, size = file + 1, 0
                path = made(folder / DATA_PATH.format(**file_of(file)))
                writer = parquet.ParquetWriter(path, table.schema, compression="snappy")
                open_file.enter_context(writer)
            writer.write_table(table)
            size += table.nbytes
            start = rows[-1].end if rows else 0
            rows.append(Rows(file, start, start + table.num_rows))
    return rows


def _array(arrow: Any, values: npt.NDArray[Any]) -> Any:
    """Return a column as Parquet holds it; vectors as lists of one length."""
    if values.ndim == 1:
        return arrow.array(values)
    return arrow.FixedSizeListArray.from_arrays(arrow.array(values.ravel()), values.shape[1])

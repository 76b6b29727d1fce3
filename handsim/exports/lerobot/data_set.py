"""Movements as a LeRobot data set, in one call.

`handsim.exports.lerobot.data_set_layout` shows its files.
"""

from dataclasses import dataclass
from pathlib import Path

from handsim.exports.export_sources import Exported, episodes_of
from handsim.exports.lerobot.data_set_layout import check_data_set_folder
from handsim.exports.lerobot.features import plan_of, take_of
from handsim.exports.lerobot.film_files import check_even, write_films
from handsim.exports.lerobot.frame_files import columns_of, write_frames
from handsim.exports.lerobot.meta_files import Written, info_of, write_meta
from handsim.exports.libraries import library
from handsim.files import replacing_folder
from handsim.result import Result
from handsim.types import Progress
from handsim.viewing.film.offscreen import View


@dataclass(frozen=True)
class DataSet(Result):
    """What was written.

    Attributes
    ----------
    fps
        Frames a second.
    n_episodes, n_frames
    features
        Names of what a frame holds.
    tasks
        Sentences, in the order of their numbers.
    resampled
        Names of the movements that were interpolated to the frames.
    left_out
        Columns that not all movements have, or that have gaps.
    """

    fps: int
    n_episodes: int
    n_frames: int
    features: tuple[str, ...]
    tasks: tuple[str, ...]
    resampled: tuple[str, ...]
    left_out: tuple[str, ...]


def write_lerobot(
    exported: Exported,
    folder: Path,
    *,
    fps: int | None = None,
    camera: str | None = None,
    size: tuple[int, int] = (320, 240),
    progress: Progress | None = None,
) -> DataSet:
    """Write movements as a LeRobot data set, as a whole or not at all.

    Parameters
    ----------
    exported
        Rollouts, or recordings and posture sequences: one or several, an episode each.
    folder
        One that holds such a data set by this function is replaced.
    fps
        Frames a second; by default the median of the movements' own rates. Movements that were not
        sampled so are interpolated.
    camera
        Films what a camera sees of each (see `render`), as ``observation.images.<camera>``.
    size
        Width and height of the films [pixels], even.
    progress
        Called with the fraction done.

    Raises
    ------
    MissingToolError
        If pandas or pyarrow is not installed, or nothing renders on this machine.
    InputError
        If there is nothing to export, or movements do not belong together.
    FileError
        If the folder holds anything else, or cannot be written.
    """
    folder = Path(folder)
    check_data_set_folder(folder)
    for name in ("pandas", "pyarrow"):
        library(name)
    episodes = episodes_of(exported)
    plan = plan_of(episodes, fps)
    view = None if camera is None else View(camera, *size, plan.fps)
    if view is not None:
        check_even(view)
    takes = [take_of(episode, plan) for episode in episodes]
    tasks = tuple(dict.fromkeys(episode.sentence for episode in episodes))
    with replacing_folder(folder) as fresh:
        films = None if view is None else write_films(takes, fresh, view, progress)
        columns = columns_of(takes, tasks)
        rows = write_frames(columns, fresh)
        written = Written(takes, tasks, plan, columns, rows, films)
        write_meta(written, fresh)
    return DataSet(
        fps=plan.fps,
        n_episodes=len(takes),
        n_frames=rows[-1].end,
        features=tuple(info_of(written)["features"]),
        tasks=tasks,
        resampled=tuple(take.episode.name for take in takes if take.resampled),
        left_out=plan.left_out,
    )

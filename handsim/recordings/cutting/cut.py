"""Make recordings of the reaches that were found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handsim.errors import InputError
from handsim.recordings.cutting.find import WHOLE, find_reaches
from handsim.recordings.cutting.motion import on_grid
from handsim.recordings.cutting.reach import CutOptions, Reach
from handsim.recordings.cutting.times import COLUMNS, GivenReach
from handsim.recordings.phases import CUTOFF, RATE, low_pass, resample
from handsim.recordings.recording import MIN_FRAMES, Recording, RecordingSet
from handsim.types import Array, Progress
from handsim.wording import number_of

STEPWISE = ("label",)
"""Channels that have no values in between."""


@dataclass(frozen=True)
class Cut:
    """What cutting made.

    Attributes
    ----------
    recordings
        One for each certain reach, from 0 s on at 100 Hz, named ``<recording>-01`` and so on.
    reaches
        All reaches found, by recording and time, the doubtful ones among them.
    """

    recordings: RecordingSet
    reaches: tuple[Reach, ...]

    @property
    def doubtful(self) -> tuple[Reach, ...]:
        """The reaches that were not cut out, since two readings are as likely."""
        return tuple(reach for reach in self.reaches if not reach.certain)


def cut_recordings(
    recordings: RecordingSet,
    options: CutOptions | None = None,
    times: Sequence[GivenReach] = (),
    progress: Progress | None = None,
) -> Cut:
    """Find the reaches of continuous recordings and cut the certain ones out.

    Parameters
    ----------
    recordings
    options
        By default those of `CutOptions`.
    times
        Reaches given by hand. A recording that they speak of is cut as they say and not otherwise.
    progress
        Called with the fraction of the recordings looked through.

    Raises
    ------
    InputError
        If no reach is certain; the message says what is doubtful and how to settle it.
    UnknownNameError
        If a recording has not the channel of the options.
    """
    reaches = find_all(recordings, options or CutOptions(), times, progress)
    return Cut(cut_out(recordings, reaches, times), reaches)


def find_all(
    recordings: RecordingSet,
    options: CutOptions,
    times: Sequence[GivenReach] = (),
    progress: Progress | None = None,
) -> tuple[Reach, ...]:
    """Find the reaches of every recording, the doubtful ones among them."""
    found: list[Reach] = []
    for i, recording in enumerate(recordings):
        given = [each.reach for each in times if each.reach.recording == recording.name]
        given.sort(key=lambda reach: reach.start_s)
        found += given or find_reaches(recording, options)
        if progress is not None:
            progress((i + 1) / len(recordings))
    return tuple(found)


def cut_out(
    recordings: RecordingSet, reaches: Sequence[Reach], times: Sequence[GivenReach] = ()
) -> RecordingSet:
    """Make a recording of each certain reach.

    Raises
    ------
    InputError
        If there is none.
    """
    words = {each.reach: each for each in times}
    parts: list[Recording] = []
    for recording in recordings:
        certain = [r for r in reaches if r.recording == recording.name and r.certain]
        if not certain:
            continue
        grid, uniform = resample(recording.time, recording.q)
        q = low_pass(uniform)
        for count, reach in enumerate(certain, start=1):
            part = _part(recording, reach, grid, q, count)
            said = words.get(reach)
            if said is not None:
                part = replace(part, object=said.object or part.object, task=said.task or part.task)
            parts.append(replace(part, number=len(parts) + 1))
    if not parts:
        raise InputError(_nothing(recordings, reaches))
    return RecordingSet(tuple(parts))


def _part(recording: Recording, reach: Reach, grid: Array, q: Array, count: int) -> Recording:
    first = min(round((reach.start_s - grid[0]) * RATE), len(grid) - MIN_FRAMES)
    last = max(round((reach.end_s - grid[0]) * RATE), first + MIN_FRAMES - 1)
    frames = slice(first, min(last, len(grid) - 1) + 1)
    channels = {
        name: _channel(recording.time, values, grid[frames], stepwise=_stepwise(name))
        for name, values in recording.channels.items()
    }
    note = f"cut from {reach.start_s:.2f} to {reach.end_s:.2f} s of {recording.name}"
    how = f"resampled at {RATE:g} Hz, angles low-passed at {CUTOFF:g} Hz"
    whole = (WHOLE,) if reach.reason == WHOLE else ()
    return replace(
        recording,
        name=f"{recording.name}-{count:02d}",
        time=np.arange(frames.stop - frames.start) / RATE,
        q=q[frames],
        channels=channels,
        notes=(*recording.notes, note, how, *whole),
    )


def _stepwise(name: str) -> bool:
    """Whether a channel has no values in between: labels, and quaternions, which change sign."""
    return name in STEPWISE or name.rpartition("_")[2] in ("qw", "qx", "qy", "qz")


def _channel(time: Array, values: Array, grid: Array, *, stepwise: bool) -> Array:
    """Bring a channel to other times; what was missing for long stays missing."""
    if stepwise:
        middles = (time[1:] + time[:-1]) / 2
        return values[np.searchsorted(middles, grid, side="left")]
    smooth, seen = on_grid(time, values, grid)
    return np.where(seen, smooth, np.nan)


def _nothing(recordings: RecordingSet, reaches: Sequence[Reach]) -> str:
    """Say why nothing can be cut out, and what to do."""
    remedy = f"give times with --times FILE.csv (columns {','.join(COLUMNS)})"
    if not reaches:
        return (
            f"no reach in {number_of(len(recordings), 'recording')}: the hand nowhere leaves one "
            "posture for another; check units and columns with handsim recordings info, or "
            f"{remedy}"
        )
    one = reaches[0]
    return (
        f"none of {len(reaches)} reaches is certain, such as {one.recording} from "
        f"{one.start_s:.2f} to {one.end_s:.2f} s{other_reading(one)}: {one.reason}; {remedy}"
    )


def other_reading(reach: Reach) -> str:
    """Return the second reading in words; empty where there is none."""
    if reach.second is None:
        return ""
    return f" or from {reach.second[0]:.2f} to {reach.second[1]:.2f} s"

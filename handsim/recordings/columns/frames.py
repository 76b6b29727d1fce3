"""Frames of a file on their way to a recording: times mended, jumps and gaps taken out, checked.

What the importers of tables, raw gloves and Ninapro share. Everything that is done is said in the
notes of the recording.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_NAMES, LOWER, N_JOINTS, UPPER
from handsim.recordings.columns.sections import brief
from handsim.recordings.gaps import bridge_joints
from handsim.recordings.recording import Recording, check_frames
from handsim.types import Array, HandSize, Index
from handsim.wording import number_of

_TURN = 360.0
_MIDDLES = np.rad2deg(LOWER + UPPER) / 2


def _no_cell(_row: int, _joint: int) -> str:
    return "nan"


@dataclass(frozen=True)
class Frames:
    """What a file holds of one movement, not yet checked.

    Attributes
    ----------
    where
        What messages begin with: the file.
    time : (n,) [s]
    angles : (n, 22) [deg]
        NaN where missing.
    numbers : (n,)
        What messages call each frame: rows of the file.
    columns
        What messages call the time and the 22 joints.
    channels : name to (n,)
    notes
    cell
        Returns the text of a cell, by the number of the row and the joint, -1 for the time.
    """

    where: str
    time: Array
    angles: Array
    numbers: Index
    columns: Sequence[str] = ("time_s", *(f"{name}_deg" for name in JOINT_NAMES))
    channels: Mapping[str, Array] = field(default_factory=dict[str, Array])
    notes: tuple[str, ...] = ()
    cell: Callable[[int, int], str] = _no_cell

    def taken(self, rows: Index) -> "Frames":
        """Return some of the frames."""
        return replace(
            self,
            time=self.time[rows],
            angles=self.angles[rows],
            numbers=self.numbers[rows],
            channels={name: values[rows] for name, values in self.channels.items()},
        )

    def noted(self, *notes: str) -> "Frames":
        """Return the frames with further notes."""
        return replace(self, notes=(*self.notes, *notes))


@dataclass(frozen=True)
class Labels:
    """What a recording is called, and who did what with what hand."""

    name: str
    number: int
    subject: str
    object: str
    task: str
    hand: HandSize
    session: str = ""
    extra: Mapping[str, str] = field(default_factory=dict[str, str])


def recording_of(
    frames: Frames, labels: Labels, *, bridge_s: float = 0.0, unwrap: bool = False
) -> Recording:
    """Return a recording of frames: time from 0, no time twice, no gaps, nothing beyond +-180 deg.

    Parameters
    ----------
    frames, labels
    bridge_s
        Longest gap that is bridged [s].
    unwrap
        Whether jumps of 360 deg are taken out.

    Raises
    ------
    FileError
        If a time or an angle is missing, time runs backwards, there are too few frames, or an angle
        is beyond +-180 deg; the message names row and column.
    """
    frames = _with_times(frames)
    if unwrap:
        frames = _unwrapped(frames)
    angles, bridged = bridge_joints(frames.time, frames.angles, bridge_s)
    frames = replace(frames, angles=angles).noted(*bridged)
    missing = np.argwhere(~np.isfinite(frames.angles))
    if missing.size:
        row, joint = (int(i) for i in missing[0])
        cell = brief(frames.cell(int(frames.numbers[row]), joint))
        raise FileError(
            f"{_place(frames, row, joint)}: '{cell}' is not a finite number "
            f"({_length(frames, row, joint)}); correct or remove the row, or bridge longer gaps by "
            "--bridge"
        )
    check_frames(frames.where, frames.time, frames.angles, frames.numbers)
    try:
        return Recording(
            name=labels.name,
            time=frames.time,
            q=np.deg2rad(frames.angles),
            number=labels.number,
            subject=labels.subject,
            object=labels.object,
            task=labels.task,
            hand=labels.hand,
            session=labels.session,
            channels={n: np.where(np.isinf(v), np.nan, v) for n, v in frames.channels.items()},
            extra=labels.extra,
            notes=frames.notes,
        )
    except FileError:
        raise
    except InputError as error:
        raise FileError(f"{frames.where}: {error}") from error


def _place(frames: Frames, row: int, joint: int) -> str:
    return f"{frames.where}: row {frames.numbers[row]}, column {brief(frames.columns[joint + 1])}"


def _with_times(frames: Frames) -> Frames:
    """Return frames whose time starts at 0 and increases, times that repeat left out."""
    missing = np.flatnonzero(~np.isfinite(frames.time))
    if missing.size:
        row = int(missing[0])
        cell = brief(frames.cell(int(frames.numbers[row]), -1))
        raise FileError(
            f"{_place(frames, row, -1)}: '{cell}' is no time; correct or remove the row"
        )
    with np.errstate(over="ignore"):
        steps = np.diff(frames.time)
    back = np.flatnonzero(steps < 0)
    if back.size:
        row = int(back[0]) + 1
        raise FileError(
            f"{_place(frames, row, -1)}: {frames.time[row]:.10g} s follows "
            f"{frames.time[row - 1]:.10g} s; time runs backwards: sort the rows, or split the file "
            "where a new movement starts"
        )
    new = np.flatnonzero(np.concatenate([[True], steps > 0])[: len(frames.time)])
    dropped = len(frames.time) - len(new)
    if dropped:
        frames = frames.taken(new).noted(
            f"{dropped} of {dropped + len(new)} frames left out, which repeat the time before them"
        )
    if not len(frames.time):
        raise FileError(f"{frames.where}: holds no frames; check the file")
    with np.errstate(over="ignore"):
        return replace(frames, time=frames.time - frames.time[0])


def _unwrapped(frames: Frames) -> Frames:
    """Return frames without jumps of about 360 deg, joints as near their ranges as turns do."""
    angles, notes = np.array(frames.angles), list[str]()
    for joint in range(N_JOINTS):
        known = np.isfinite(angles[:, joint])
        column = angles[known, joint]
        if not column.size or np.abs(column).max() > 1e6:
            continue
        smooth = np.unwrap(column, period=_TURN)
        smooth -= _TURN * np.round((np.median(smooth) - _MIDDLES[joint]) / _TURN)
        changed = np.abs(smooth - column) > 1.0
        if changed.any():
            angles[known, joint] = smooth
            notes.append(
                f"jumps of 360 deg taken out of {JOINT_NAMES[joint]} "
                f"({number_of(changed.sum(), 'frame')})"
            )
    return replace(frames, angles=angles).noted(*notes)


def _length(frames: Frames, row: int, joint: int) -> str:
    """Say how long a gap that starts at a row is, from value to value."""
    known = np.flatnonzero(np.isfinite(frames.angles[:, joint]))
    if not known.size:
        return "as is the whole column"
    after = known[known > row]
    start = frames.time[max(row - 1, 0)]
    end = frames.time[after[0]] if after.size else frames.time[-1]
    return f"a gap of {end - start:.3g} s"

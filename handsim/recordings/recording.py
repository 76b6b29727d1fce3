"""Recordings of reach-to-grasp movements, one by one and in sets."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, SupportsIndex, overload

import numpy as np
import numpy.typing as npt

from handsim.content import ByContent
from handsim.errors import FileError, InputError
from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.types import Array, HandSize, Index
from handsim.wording import number_of

SYNTHETIC = "synthetic"
"""What recordings call the person that were made by script and simulation."""
NOT_SEEN = "not seen: kept at 0"
"""How a note ends that names joints of which a recording tells nothing."""
MIN_FRAMES = 10
MAX_ANGLE_DEG = 180.0


@dataclass(frozen=True, eq=False)
class Recording(ByContent):
    """One movement of one hand, from rest to grasp; equal to another that holds the same.

    Attributes
    ----------
    name
        Unique in its set; also the name of its file, without the suffix.
    time : (n,) [s], increasing
    q : (n, 22) [rad], glove order; may leave the joint ranges, as angles of real gloves do
    number
        Number of the experiment (Table I of the paper for the built-in ones).
    subject, object, task
        Who moved, what was grasped, what for.
    hand
        Size and side of the recorded hand. The angles of a left hand are those of its mirror image:
        flexion and spreading are positive on either side.
    session
        When or where it was recorded; empty if not said.
    channels : name to (n,)
        What was recorded beside the hand, such as ``palm_x_m`` or ``emg_01``; NaN where missing.
    extra
        Further columns of ``experiments.csv``, kept as they are.
    notes
        What was done to the recording, such as ``index_dip filled as 0.67 index_pip``.
    """

    name: str
    time: Array
    q: Array
    number: int
    subject: str
    object: str
    task: str
    hand: HandSize
    session: str = ""
    channels: Mapping[str, Array] = field(default_factory=dict[str, Array])
    extra: Mapping[str, str] = field(default_factory=dict[str, str])
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check the values and make the arrays read-only."""
        time = np.array(self.time, dtype=float)
        q = np.array(self.q, dtype=float)
        check_postures(f"recording '{self.name}'", time, q)
        if not self.name or Path(self.name).name != self.name or self.name.startswith("."):
            raise InputError(f"'{self.name}' cannot name a file; use letters, digits and hyphens")
        for label, size in (
            ("hand_length", self.hand.length),
            ("hand_breadth", self.hand.breadth),
        ):
            if not 0 < size < 1:
                raise InputError(
                    f"recording '{self.name}': {label} is {size} m; give metres between 0 and 1"
                )
        time.flags.writeable = False
        q.flags.writeable = False
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "channels", MappingProxyType(self._checked_channels()))
        object.__setattr__(self, "extra", MappingProxyType(dict(self.extra)))
        object.__setattr__(self, "notes", tuple(self.notes))

    def _checked_channels(self) -> dict[str, Array]:
        """Return the further channels as read-only arrays, one value a frame."""
        checked: dict[str, Array] = {}
        for name, values in self.channels.items():
            channel = np.array(values, dtype=float)
            if channel.shape != self.time.shape or np.isinf(channel).any():
                raise InputError(
                    f"recording '{self.name}', channel {name}: {channel.shape} values for "
                    f"{len(self.time)} frames; give one number for each, NaN where it is missing"
                )
            if not name or name != name.strip() or set(name) & set(',;"\n\t:'):
                raise InputError(f"'{name}' cannot name a channel; use letters, digits and _")
            channel.flags.writeable = False
            checked[name] = channel
        return checked

    def __reduce__(self) -> tuple[Any, ...]:
        """Let it go to another process: what its fields are, the mappings as plain ones."""
        values = (getattr(self, each.name) for each in fields(self))
        return type(self), tuple(dict(v) if isinstance(v, MappingProxyType) else v for v in values)

    @property
    def not_seen(self) -> frozenset[str]:
        """Joints of which the recording tells nothing, by its notes."""
        told = {word for note in self.notes if note.endswith(NOT_SEEN) for word in note.split()}
        return frozenset({word.strip(",") for word in told} & set(JOINT_NAMES))

    @property
    def duration(self) -> float:
        """Time from the first to the last frame [s]."""
        return float(self.time[-1] - self.time[0])


@dataclass(frozen=True)
class RecordingSet:
    """Recordings in order, each with a name of its own; equal to another that holds the same.

    Examples
    --------
    >>> from handsim import data_folder, read_recordings
    >>> recordings = read_recordings(data_folder("assets") / "experiments")
    >>> len(recordings[:3]), recordings[-1].task
    (3, 'stapler-use')
    >>> len(recordings[[each.object == "cup" for each in recordings]])
    4
    """

    recordings: tuple[Recording, ...]

    def __post_init__(self) -> None:
        """Check that there are recordings and that each has a name of its own."""
        object.__setattr__(self, "recordings", tuple(self.recordings))
        names = [recording.name for recording in self.recordings]
        if not names:
            raise InputError("a set of 0 recordings; give at least 1")
        if len(set(names)) < len(names):
            counts = Counter(names)
            twice = next(name for name in names if counts[name] > 1)
            raise InputError(f"two recordings are named '{twice}'; rename one")

    def __len__(self) -> int:
        """Return the number of recordings."""
        return len(self.recordings)

    def __iter__(self) -> Iterator[Recording]:
        """Iterate over the recordings in order."""
        return iter(self.recordings)

    @overload
    def __getitem__(self, index: SupportsIndex) -> Recording: ...

    @overload
    def __getitem__(self, index: slice | Sequence[int] | npt.NDArray[Any]) -> "RecordingSet": ...

    def __getitem__(
        self, index: SupportsIndex | slice | Sequence[int] | npt.NDArray[Any]
    ) -> "Recording | RecordingSet":
        """Return one recording by its place, from 0, or some of them as a set.

        Parameters
        ----------
        index
            A place, negative from the end; or for a set a slice, places, or one bool for each
            recording that says whether to take it.

        Raises
        ------
        IndexError
            If there is no such place.
        InputError
            If it is nothing that chooses, or none are left to make a set of.
        """
        if isinstance(index, slice):
            return RecordingSet(self.recordings[index])
        if isinstance(index, SupportsIndex) and not (isinstance(index, np.ndarray) and index.ndim):
            return self.recordings[index]
        return RecordingSet(tuple(self.recordings[place] for place in self._places(index)))

    def _places(self, chosen: Any) -> list[int]:
        """Return places, given as such or by one bool for each recording."""
        array = np.asarray(chosen)
        if array.shape == (0,):
            return []
        if array.ndim == 1 and array.dtype == bool and len(array) == len(self):
            return np.flatnonzero(array).tolist()
        if array.ndim == 1 and np.issubdtype(array.dtype, np.integer):
            return array.tolist()
        raise InputError(
            f"{array.dtype} of shape {array.shape} chooses no recordings; give a slice, whole "
            f"numbers or {len(self)} bools"
        )

    def without(self, index: int) -> "RecordingSet":
        """Return the set with one recording, by its place as in ``[]``, left out."""
        left_out = range(len(self))[index]
        return RecordingSet(self.recordings[:left_out] + self.recordings[left_out + 1 :])

    def without_object(self, name: str) -> "RecordingSet":
        """Return the recordings of all other objects.

        Raises
        ------
        InputError
            If none are left.
        """
        kept = tuple(each for each in self.recordings if each.object != name)
        if not kept:
            raise InputError(f"no recordings are left without object '{name}'; add some of others")
        return RecordingSet(kept)


def check_postures(where: str, time: Array, q: Array) -> None:
    """Check a sequence of postures, (n,) [s] and (n, 22) [rad].

    Raises
    ------
    InputError
        If it is none; the message begins with ``where`` and names row and column, from 0.
    """
    if time.ndim != 1 or q.shape != (len(time), N_JOINTS):
        raise InputError(
            f"{where}: time {time.shape} and postures {q.shape}; shapes must be (n,) and (n, 22)"
        )
    if not (np.isfinite(time).all() and np.isfinite(q).all()):
        raise InputError(f"{where}: holds NaN or infinite values; remove those frames")
    check_frames(where, time, np.rad2deg(q), np.arange(len(time)))


def check_frames(where: str, time: Array, angles: Array, rows: Index) -> None:
    """Check what holds for files and for arrays alike.

    Parameters
    ----------
    where
        What the message begins with.
    time : (n,) [s]
    angles : (n, 22) [deg]
    rows : (n,)
        What the message calls each frame.
    """
    check_times(where, time, rows)
    beyond = np.argwhere(np.abs(angles) > MAX_ANGLE_DEG)
    if beyond.size:
        row, joint = (int(i) for i in beyond[0])
        raise FileError(
            f"{where}: row {rows[row]}, column {JOINT_NAMES[joint]}_deg: {angles[row, joint]:g} "
            f"deg is beyond +-{MAX_ANGLE_DEG:g} deg; correct it, or import the file: raw counts "
            "with --calibration, turns of 360 deg with --unwrap"
        )


def check_times(where: str, time: Array, rows: Index) -> None:
    """Check that there are enough frames and that their times increase; see `check_frames`."""
    if len(time) < MIN_FRAMES:
        raise FileError(
            f"{where}: {number_of(len(time), 'frame')}; at least {MIN_FRAMES} are needed"
        )
    backward = np.flatnonzero(np.diff(time) <= 0)
    if backward.size:
        row = int(backward[0]) + 1
        raise FileError(
            f"{where}: row {rows[row]}, column time_s: {time[row]:g} s follows "
            f"{time[row - 1]:g} s; time must increase"
        )

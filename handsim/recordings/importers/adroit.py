"""The layout ``adroit``: demonstrations of a simulated Adroit hand, driven by a person's glove.

Arrays (frames, 39) as in the door demonstrations of A. Rajeswaran and others (2018), "Learning
complex dexterous manipulation with deep reinforcement learning and demonstrations": three
rotations of the arm, then the 24 joints WRJ1, WRJ0, FFJ3 to FFJ0, MFJ3 to MFJ0, RFJ3 to RFJ0, LFJ4
to LFJ0 and THJ4 to THJ0 [rad]; latch [rad]; a velocity; palm and handle [m]; the rest is left out.

Signs, by the geometry of the Shadow hand, which Adroit is, and by 25 published demonstrations:

- flexions (J2, J1 and J0 of the fingers) are positive as here; those of the thumb (THJ1 from -34
  to 4 deg, THJ0 from -93 to 0) are negative and reversed;
- J3 of all fingers turns about one axis, to the thumb's side: at rest the index stands at +4, ring
  and little at -4 and -11 deg, which is spread. Reversed for ring and little. That of the middle
  finger is the reference here and goes to a channel;
- WRJ1 (range -30 to 10 deg) is the deviation, to the thumb's side as here; WRJ0 the flexion;
- LFJ4, by which the little finger's metacarpal is lifted to the palm, is the palm's arch;
- the thumb's base has three joints (THJ4 turns the thumb, THJ3 lifts it from the palm, THJ2 is at
  its hub) where handsim has rotation and abduction. The coefficients are those with which, over the
  demonstrations, the tips of thumb and fingers lie to each other as those of the Shadow hand do:
  distances from thumb to finger correlate by 0.98.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import FileError
from handsim.files import as_floats, read_arrays
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.gaps import bridge
from handsim.recordings.importers.layout import UNKNOWN_HAND, ImportOptions, Layout
from handsim.recordings.recording import MIN_FRAMES, Recording, RecordingSet
from handsim.types import Array
from handsim.wording import number_of

RATE_HZ = 100.0
START_S = 0.25
"""Time in which the simulated hand moves from zero to where the person's is [s]."""
N_COLUMNS = 39
JOINTS_ONLY = (27, 28)
"""Columns of arrays that hold arm and joints alone, with or without the latch."""
_JOINTS: tuple[str, ...] = (
    "WRJ1", "WRJ0", *(f"{finger}J{i}" for finger in ("FF", "MF", "RF") for i in (3, 2, 1, 0)),
    *(f"LFJ{i}" for i in (4, 3, 2, 1, 0)), *(f"THJ{i}" for i in (4, 3, 2, 1, 0)),
)  # fmt: skip
_FIRST = 3
_FLEXIONS = [i for i, name in enumerate(_JOINTS) if name[:2] != "TH" and name[3] in "210"][2:]
_OFFSETS_DEG = {"thumb_rotation": 16.0}
# For each joint: the sums of Adroit's joints that make it.
_SUMS: dict[str, dict[str, float]] = {
    "wrist_deviation": {"WRJ1": 1.0},
    "wrist_flexion": {"WRJ0": 1.0},
    "thumb_rotation": {"THJ4": 0.7, "THJ3": 0.85, "THJ2": 0.7},
    "thumb_abduction": {"THJ4": -0.6, "THJ3": 0.6, "THJ2": 0.5},
    "thumb_mcp": {"THJ1": -1.0},
    "thumb_ip": {"THJ0": -1.0},
    "index_abduction": {"FFJ3": 1.0},
    "ring_abduction": {"RFJ3": -1.0},
    "little_abduction": {"LFJ3": -1.0},
    "palm_arch": {"LFJ4": 1.0},
    **{
        f"{finger}_{place}": {f"{letters}J{i}": 1.0}
        for finger, letters in (("index", "FF"), ("middle", "MF"), ("ring", "RF"), ("little", "LF"))
        for place, i in (("mcp", 2), ("pip", 1), ("dip", 0))
    },
}
_CHANNELS: dict[str, int] = {
    "arm_x_rad": 0, "arm_y_rad": 1, "arm_z_rad": 2,
    "middle_abduction_rad": _FIRST + _JOINTS.index("MFJ3"), "latch_rad": 27,
    "palm_x_m": 29, "palm_y_m": 30, "palm_z_m": 31,
    "handle_x_m": 32, "handle_y_m": 33, "handle_z_m": 34,
}  # fmt: skip
_MOST_RAD = 2.5
"""No joint of the hand goes so far [rad]."""
_BENT_BACK = np.deg2rad(-25.0)
"""Fingers are not bent back farther for most of a demonstration [rad]."""


def postures_of_adroit(joints: Array) -> Array:
    """Return postures (n, 22) [rad] of the 24 joints of Adroit, (n, 24) [rad]."""
    q = np.zeros((len(joints), N_JOINTS))
    for name, parts in _SUMS.items():
        angle = np.full(len(joints), np.deg2rad(_OFFSETS_DEG.get(name, 0.0)))
        for source, factor in parts.items():
            angle += factor * joints[:, _JOINTS.index(source)]
        q[:, JOINT_INDEX[name]] = angle
    return q


def read_adroit(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read ``.npz`` or ``.npy`` files of demonstrations, one continuous recording each.

    Raises
    ------
    FileError
        If a file is missing, damaged, or holds no arrays of the layout.
    """
    made: list[Recording] = []
    for path in files:
        found = _demonstrations(path, read_arrays(path))
        taken = {recording.name for recording in made}
        for name, rows in found.items():
            unique = name if name not in taken else f"{path.stem}-{name}"
            made.append(_recording(path, unique, rows, len(made) + 1, options))
    return RecordingSet(tuple(made))


def _demonstrations(path: Path, arrays: dict[str, npt.NDArray[Any]]) -> dict[str, Array]:
    """Return the arrays that have the layout's columns, by name, those of a stack one by one."""
    found: dict[str, Array] = {}
    for key, array in arrays.items():
        if array.dtype.kind != "f" or array.ndim not in (2, 3) or not array.size:
            continue
        if array.shape[-1] not in (N_COLUMNS, *JOINTS_ONLY):
            continue
        name = "".join(c if c.isalnum() or c in "-_" else "-" for c in key or path.stem)
        name = name.strip("-") or path.stem
        stack = array[None] if array.ndim == 2 else array
        for i, rows in enumerate(stack):
            found[name if len(stack) == 1 else f"{name}-{i:02d}"] = as_floats(rows)
    if not found:
        shapes = ", ".join(f"{name or 'array'} {array.shape}" for name, array in arrays.items())
        raise FileError(
            f"{path}: no array of shape (frames, {N_COLUMNS}) among {shapes[:300]}; give the "
            "observations of door demonstrations"
        )
    return found


def _recording(
    path: Path, name: str, rows: Array, number: int, options: ImportOptions
) -> Recording:
    rate = options.rate_hz or RATE_HZ
    rows, notes = _without_start(rows, rate)
    if len(rows) < MIN_FRAMES:
        raise FileError(
            f"{path}: {name} has {number_of(len(rows), 'frame')}; at least {MIN_FRAMES} are needed"
        )
    time = np.arange(len(rows)) / rate
    rows = np.where(np.abs(np.nan_to_num(rows, nan=np.inf)) < 1e6, rows, np.nan)
    rows, bridged = bridge(time, rows, options.bridge_s)
    if bridged.any():
        notes.append(f"bridged {number_of(bridged.any(axis=1).sum(), 'frame')}")
    joints = rows[:, _FIRST : _FIRST + len(_JOINTS)]
    _check_joints(f"{path}: {name}", joints)
    channels = {key: rows[:, i] for key, i in _CHANNELS.items() if i < rows.shape[1]}
    return Recording(
        name=name,
        time=time,
        q=postures_of_adroit(joints),
        number=number,
        subject=str(options.subject or 1),
        object=options.object or "door",
        task=options.task or "door-open",
        hand=options.hand or UNKNOWN_HAND,
        channels=channels,
        notes=(*notes, *NOTES),
    )


NOTES = (
    "palm_arch from LFJ4",
    "middle_abduction kept as a channel",
    "a reach ends where the latch first moves, cut it out with --channel latch_rad",
)


def _without_start(rows: Array, rate: float) -> tuple[Array, list[str]]:
    """Return the frames after the start from zero, where there is one, and what was dropped."""
    hand = rows[:1, _FIRST + 2 : _FIRST + len(_JOINTS)]
    if not len(hand) or np.abs(hand).max() > 1e-6:  # also where it is NaN
        return rows, []
    n = round(START_S * rate)
    return rows[n:], [f"first {START_S:g} s dropped, in which the simulated hand starts from zero"]


def _check_joints(where: str, joints: Array) -> None:
    missing = np.argwhere(~np.isfinite(joints))
    if len(missing):
        row, column = missing[0]
        raise FileError(
            f"{where}: frame {row + 1} after the start has no {_JOINTS[column]}; bridge short gaps "
            "(--bridge) or remove it"
        )
    most = np.abs(joints).max(axis=0)
    column = int(np.argmax(most))
    if most[column] > _MOST_RAD:
        raise FileError(
            f"{where}: {_JOINTS[column]} reaches {most[column]:.3g}, beyond {_MOST_RAD} rad; the "
            "columns are others, or no radians"
        )
    bent = np.median(joints[:, _FLEXIONS], axis=0)
    column = int(np.argmin(bent))
    if bent[column] < _BENT_BACK:
        raise FileError(
            f"{where}: {_JOINTS[_FLEXIONS[column]]} is {np.rad2deg(bent[column]):.0f} deg for most "
            "of it, which no finger does; the columns are others"
        )


LAYOUT = Layout(
    "adroit",
    "demonstrations of a simulated Adroit hand (door): .npz or .npy of (frames, 39)",
    read_adroit,
    frozenset({"bridge_s", "hand", "object", "rate_hz", "subject", "task"}),
)

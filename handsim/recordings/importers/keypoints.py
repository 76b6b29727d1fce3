"""The layout ``keypoints``: 21 points of a hand a frame, as networks, headsets and suits give them.

The angles are those with which handsim's own hand, its size fitted too, comes nearest to the points
(`handsim.recordings.fitting`). The signs follow from the geometry: the side is the one of which a
hand fits better, since fingers flex to the palm only.

The wrist's angles cannot be seen, because the forearm is not among the points: they stay 0.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.recordings.fitting.fit_hand import BAD_FIT_M, HandFit, fit_hand, root_mean_square
from handsim.recordings.gaps import bridge
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.points.channels import channels_of_fit
from handsim.recordings.points.clocks import clock_of
from handsim.recordings.points.keypoint_files import read_keypoint_file
from handsim.recordings.points.keypoint_order import expected_places, in_order, metres_per_unit
from handsim.recordings.recording import MIN_FRAMES, NOT_SEEN, Recording, RecordingSet
from handsim.types import Array
from handsim.wording import number_of

BRIDGED_S = 0.1
"""Longest gap of a keypoint or marker that is bridged where nothing was said [s]."""


def read_keypoints(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read files of keypoints, one recording each.

    Raises
    ------
    FileError
        If a file is missing, damaged, or holds no 21 keypoints a frame.
    InputError
        If the side of the hand cannot be told, or it is seen in too few frames.
    """
    made = [_recording(file, number, options) for number, file in enumerate(files, start=1)]
    return RecordingSet(tuple(made))


def _recording(path: Path, number: int, options: ImportOptions) -> Recording:
    content = read_keypoint_file(path)
    n = len(content.points)
    if n < MIN_FRAMES:
        raise FileError(f"{path}: {number_of(n, 'frame')}; at least {MIN_FRAMES} are needed")
    clock = clock_of(str(path), n, content.stamps, options.rate_hz, content.rate_hz)
    points, notes = _in_metres(path, content.points[clock.kept], options)
    flat, bridged = bridge(
        clock.time, points.reshape(len(points), -1), options.bridge_s or BRIDGED_S
    )
    if bridged.any():
        notes.append(
            f"{number_of(bridged.any(axis=1).sum(), 'frame')} with points missing for at most "
            f"{options.bridge_s or BRIDGED_S:g} s bridged"
        )
    fit = fit_hand(
        str(path),
        expected_places(),
        flat.reshape(points.shape),
        hand=options.hand,
        side=options.side,
        step_s=float(np.median(np.diff(clock.time))),
    )
    return Recording(
        name=path.stem,
        time=clock.time,
        q=fit.q,
        number=number,
        subject=str(options.subject or 1),
        object=options.object or "unknown",
        task=options.task or "unknown",
        hand=fit.hand,
        channels=channels_of_fit(fit),
        notes=(*content.notes, *clock.notes, *notes, *notes_of_fit(fit)),
    )


def _in_metres(path: Path, points: Array, options: ImportOptions) -> tuple[Array, list[str]]:
    """Return the points in MediaPipe's order and metres, NaN where a value is none."""
    points = np.where(np.abs(np.nan_to_num(points, nan=np.inf)) < 1e9, points, np.nan)
    points, order = in_order(points)
    factor, unit = metres_per_unit(points, options.hand.length if options.hand else None)
    if factor == 0.0:
        raise FileError(
            f"{path}: wrist and middle finger coincide or are missing; check the order of points"
        )
    notes = [] if order == "MediaPipe" else [f"points brought from {order}'s order"]
    if unit == "a unit of their own":
        notes.append(
            "points in a unit of their own, scaled to a hand of usual size: lengths are no measures"
        )
    else:
        notes.append(f"points taken as {unit}")
    return points * factor, notes


def notes_of_fit(fit: HandFit, *, wrist: bool = False) -> list[str]:
    """Return what has to be said of a fit.

    Parameters
    ----------
    fit
    wrist
        Whether the wrist's angles were found in another way.
    """
    error = 1000 * float(root_mean_square(fit.residual))
    notes = [
        f"hand {1000 * fit.hand.length:.0f} mm long and {1000 * fit.hand.breadth:.0f} mm broad "
        f"fitted to {fit.residual.shape[1]} points, {error:.1f} mm rms left over"
    ]
    if np.isfinite(fit.other_side):
        notes.append(
            f"taken for a {fit.hand.side} hand: the other one fits {fit.other_side:.1f} times worse"
        )
    if fit.bad.any():
        notes.append(
            f"{fit.bad.sum()} of {len(fit.q)} frames marked fit_bad: more than "
            f"{1000 * BAD_FIT_M:g} mm left over, or the hand lost"
        )
    if not wrist:
        notes.append(f"wrist_flexion, wrist_deviation {NOT_SEEN}")
    return notes


LAYOUT = Layout(
    "keypoints",
    "21 hand keypoints a frame (MediaPipe, MANO, headsets): .npz, .npy, .csv or .json",
    read_keypoints,
    frozenset({"bridge_s", "hand", "object", "rate_hz", "side", "subject", "task"}),
)

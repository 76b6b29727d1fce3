"""What a set of recordings holds, joint by joint, beside the ranges of the joints."""

from typing import TYPE_CHECKING

import numpy as np

from handsim.joints import JOINTS
from handsim.recordings.contents import out_of_range
from handsim.recordings.recording import RecordingSet
from handsim.types import Array, Mask
from handsim.viewing.figures.style import BLUE, VERMILION, WIDE, LineStyle, add_legend, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS, ROWS = 4, 6
MAX_POINTS = 1500
"""Points drawn of one trace; more are not seen in a panel of 1.7 inch."""
OUTSIDE: LineStyle = {
    "marker": ".",
    "linestyle": "none",
    "color": VERMILION,
    "markersize": 2.5,
    "markeredgewidth": 0,
    "label": "outside the range",
}
RANGE: LineStyle = {"color": "#E3E8EE", "linewidth": 6, "label": "range of the joint"}


def recordings_figure(recordings: RecordingSet) -> "Figure":
    """Draw all recordings over one another, a panel a joint.

    Time is in seconds for one recording and a share of its duration for several. Titles count the
    frames outside the range.

    Parameters
    ----------
    recordings
    """
    outside = [out_of_range(r.q) for r in recordings]
    each_frame = np.vstack(outside)
    n_out = int(each_frame.any(axis=1).sum())
    line: LineStyle = {
        "color": BLUE,
        "linewidth": 0.9 if len(recordings) < 10 else 0.6,
        "alpha": 0.9 if len(recordings) < 3 else max(0.25, 0.9 - 0.12 * np.log(len(recordings))),
    }
    with drawing(WIDE, 7.6) as figure:
        panels = figure.subplots(ROWS, COLUMNS, sharex=True)
        for j, axes in enumerate(panels.flat[: len(JOINTS)]):
            for recording, out in zip(recordings, outside, strict=True):
                clock = _clock(recording.time, len(recordings))
                _trace(axes, clock, np.rad2deg(recording.q[:, j]), out[:, j], line)
            _dress(axes, j, int(each_frame[:, j].sum()))
        for axes in panels.flat[len(JOINTS) :]:
            axes.set_axis_off()
        for axes in panels[ROWS - 2, len(JOINTS) % COLUMNS :]:  # nothing below them
            axes.tick_params(labelbottom=True)
        for axes in panels[ROWS - 1, : len(JOINTS) % COLUMNS]:
            axes.set_xlabel("time [s]" if len(recordings) == 1 else "time / duration")
        figure.supylabel("angle [deg]", fontsize=8)
        figure.suptitle(_title(recordings, n_out, len(each_frame)), fontsize=9)
        add_legend(figure, {**line, "alpha": 1, "label": "recording"}, RANGE, _larger(OUTSIDE))
    return figure


def _clock(time: Array, n_recordings: int) -> Array:
    since = time - time[0]
    return since if n_recordings == 1 else since / since[-1]


def _trace(axes: "Axes", clock: Array, angles: Array, outside: Mask, line: LineStyle) -> None:
    step = max(1, len(angles) // MAX_POINTS)
    axes.plot(clock[::step], angles[::step], **line)
    out = np.flatnonzero(outside)
    out = out[:: max(1, len(out) // MAX_POINTS)]
    axes.plot(clock[out], angles[out], **OUTSIDE, zorder=3)


def _dress(axes: "Axes", joint: int, n_outside: int) -> None:
    """Shade the range, name the joint, count what is outside."""
    lower, upper = JOINTS[joint].lower_deg, JOINTS[joint].upper_deg
    axes.axhspan(lower, upper, color=RANGE["color"], zorder=0, linewidth=0)
    least, greatest = axes.get_ylim()
    margin = 0.06 * (upper - lower)
    axes.set_ylim(min(least, lower - margin), max(greatest, upper + margin))
    axes.margins(x=0)
    axes.set_title(JOINTS[joint].name.replace("_", " "), loc="left", fontsize=7.5, pad=2)
    if n_outside:
        axes.set_title(f"{n_outside} out", loc="right", fontsize=7, color=VERMILION, pad=2)
    axes.tick_params(labelsize=6.5, length=2)


def _larger(style: LineStyle) -> LineStyle:
    return {**style, "markersize": 6}


def _title(recordings: RecordingSet, n_outside: int, n_frames: int) -> str:
    what = recordings[0].name if len(recordings) == 1 else f"{len(recordings)} recordings"
    return (
        f"{what}: {n_frames} frames, {n_outside} of them ({100 * n_outside / n_frames:.1f} %) "
        "with a joint outside its range"
    )

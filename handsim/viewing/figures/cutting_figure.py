"""What was cut out of continuous recordings: their speed over time, with the reaches marked."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.recordings.cutting.motion import motion_of
from handsim.recordings.cutting.reach import Reach
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import Array
from handsim.viewing.figures.style import BLUE, GREEN, WIDE, LineStyle, drawing
from handsim.wording import number_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_STRIPS = 30
"""Rows drawn; recordings with doubtful reaches come first where there are more."""
MAX_POINTS = 4000
MAX_WRITTEN = 24
"""Reaches in one row whose confidences can be written beside one another."""
AMBER = "#E69F00"
SPEED: LineStyle = {"color": BLUE, "linewidth": 0.7}
REACH: dict[str, Any] = {"facecolor": GREEN, "alpha": 0.35, "linewidth": 0}
HOLD: dict[str, Any] = {"facecolor": GREEN, "alpha": 0.12, "linewidth": 0}
RETURN: dict[str, Any] = {"facecolor": "#8A95A1", "alpha": 0.25, "linewidth": 0}
DOUBTFUL: dict[str, Any] = {"facecolor": AMBER, "alpha": 0.45, "linewidth": 0}
RETURNED = 0.15
"""A return is drawn until its speed falls under this share of its peak,"""
STARTED = 0.2
"""once that peak is over this share of the fastest movement in the recording."""


def cutting_figure(recordings: RecordingSet, reaches: Sequence[Reach]) -> "Figure":
    """Draw the speed of every recording and what was found in it, a row each or more for long ones.

    Reaches are green, holds light green and returns grey, with the confidence above. Doubtful
    reaches are amber, and a bracket shows their second reading.

    Parameters
    ----------
    recordings
        The continuous ones.
    reaches
        What `find_all` or a `Cut` lists.
    """
    chosen = _chosen(recordings, reaches)
    strips = [strip for recording in chosen for strip in _strips(recording, reaches)][:MAX_STRIPS]
    whole = len(strips) == len(chosen)
    height = 0.95 + max(0.6, min(1.6, 8.0 / len(strips))) * len(strips)
    with drawing(WIDE, height) as figure:
        panels = figure.subplots(len(strips), 1, squeeze=False, sharex=whole)[:, 0]
        for axes, strip in zip(panels, strips, strict=True):
            _draw(axes, strip)
        if whole:
            panels[-1].set_xlim(min(s.start_s for s in strips), max(s.end_s for s in strips))
        panels[-1].set_xlabel("time [s]")
        left_out = len(recordings) - len({strip.recording.name for strip in strips})
        figure.suptitle(_title(recordings, reaches, left_out), fontsize=9)
        _legend(figure)
    return figure


def _chosen(recordings: RecordingSet, reaches: Sequence[Reach]) -> list[Recording]:
    """Return the recordings that are drawn, in order."""
    doubtful = {reach.recording for reach in reaches if not reach.certain}
    first = sorted(recordings, key=lambda recording: recording.name not in doubtful)
    names = {recording.name for recording in first[:MAX_STRIPS]}
    return [recording for recording in recordings if recording.name in names]


@dataclass(frozen=True)
class _Strip:
    """A stretch of a recording that fills one row, and all reaches of that recording."""

    recording: Recording
    reaches: tuple[Reach, ...]
    start_s: float
    end_s: float
    heading: str

    def shows(self, reach: Reach) -> bool:
        """Whether a reach begins in this stretch."""
        return self.start_s <= reach.start_s <= self.end_s


def _strips(recording: Recording, reaches: Sequence[Reach]) -> list[_Strip]:
    """Divide a recording so that the reaches of a row can be told apart."""
    own = tuple(reach for reach in reaches if reach.recording == recording.name)
    count = max(1, -(-len(own) // MAX_WRITTEN))
    bounds = np.linspace(recording.time[0], recording.time[-1], count + 1)
    heading = _heading(recording, own)
    return [
        _Strip(recording, own, float(start), float(end), heading if i == 0 else "")
        for i, (start, end) in enumerate(pairwise(bounds))
    ]


def _draw(axes: "Axes", strip: _Strip) -> None:
    recording, reaches = strip.recording, strip.reaches
    motion = motion_of(recording.time, recording.q, recording.channels)
    speed = 100 * motion.speed if motion.palm else np.rad2deg(motion.speed)
    top = 1.38 * max(float(speed.max()), 1e-9)
    inside = np.flatnonzero((motion.time >= strip.start_s) & (motion.time <= strip.end_s))
    inside = inside[:: max(1, len(inside) // MAX_POINTS)]
    axes.plot(motion.time[inside], speed[inside], **SPEED)
    for i, reach in enumerate(reaches):
        following = reaches[i + 1].start_s if i + 1 < len(reaches) else float(motion.time[-1])
        _spans(axes, reach, _return_end(motion.time, speed, reach.hold_end_s, following))
        if strip.shows(reach):
            _write(axes, reach, top)
            if reach.second is not None and not reach.certain:
                _bracket(axes, reach.second, top)
    axes.set(xlim=(strip.start_s, strip.end_s), ylim=(0, top))
    axes.set_ylabel("palm\n[cm/s]" if motion.palm else "joints\n[deg/s]", fontsize=6.5)
    axes.set_title(strip.heading, loc="left", fontsize=7, pad=2)
    axes.tick_params(labelsize=6.5, length=2)


def _spans(axes: "Axes", reach: Reach, return_end: float) -> None:
    axes.axvspan(reach.start_s, reach.end_s, **(REACH if reach.certain else DOUBTFUL))
    axes.axvspan(reach.end_s, reach.hold_end_s, **HOLD)
    axes.axvspan(reach.hold_end_s, return_end, **RETURN)


def _return_end(time: Array, speed: Array, start: float, following: float) -> float:
    """Return when the movement after the hold is over: it has been fast and is slow again."""
    part = np.flatnonzero((time >= start) & (time <= following))
    if part.size < 2:
        return start
    so_far = np.maximum.accumulate(speed[part])
    slow = (speed[part] < RETURNED * so_far) & (so_far > STARTED * speed.max())
    return float(time[part[int(np.argmax(slow)) if slow.any() else -1]])


def _bracket(axes: "Axes", second: tuple[float, float], top: float) -> None:
    axes.plot(second, (0.8 * top,) * 2, color=AMBER, linewidth=1.6, marker="|", markersize=6)


def _write(axes: "Axes", reach: Reach, top: float) -> None:
    axes.text(
        (reach.start_s + reach.end_s) / 2,
        0.97 * top,
        f"{reach.confidence:.2f}",
        ha="center",
        va="top",
        fontsize=6,
        color="black" if reach.certain else "#9A5B00",
        weight="normal" if reach.certain else "bold",
        clip_on=True,
    )


def _heading(recording: Recording, reaches: Sequence[Reach]) -> str:
    doubtful = [reach for reach in reaches if not reach.certain]
    if not reaches:
        return f"{recording.name}: no reach found"
    if not doubtful:
        return f"{recording.name}: {len(reaches)} cut"
    why = doubtful[0].reason if len(doubtful) == 1 else f"{len(doubtful)} doubtful"
    return f"{recording.name}: {len(reaches) - len(doubtful)} cut; {why}"


def _title(recordings: RecordingSet, reaches: Sequence[Reach], left_out: int) -> str:
    certain = sum(reach.certain for reach in reaches)
    n = len(recordings)
    said = f"{number_of(certain, 'reach', 'reaches')} cut from {number_of(n, 'recording')}"
    if certain < len(reaches):
        said += f", {len(reaches) - certain} doubtful"
    missing = number_of(left_out, "recording is", "recordings are")
    return f"{said}; {missing} not drawn" if left_out else said


def _legend(figure: "Figure") -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [
        Line2D([], [], **SPEED, label="speed"),
        Patch(**REACH, label="reach, cut out"),
        Patch(**HOLD, label="hold"),
        Patch(**RETURN, label="return, or moving on"),
        Patch(**DOUBTFUL, label="doubtful reach"),
        Line2D([], [], color=AMBER, linewidth=1.6, marker="|", label="its second reading"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))

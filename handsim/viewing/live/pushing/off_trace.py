"""How far pushes took the hand off its way, over the latest seconds, as a picture for a page."""

from collections.abc import Sequence
from html import escape

import numpy as np

from handsim.viewing.live.pushing.loop_hand import KEPT_S

TRACE_COLOURS = ("#D55E00", "#0072B2", "#CC79A7", "#009E73")
_WIDTH, _HEIGHT, _BELOW = 240.0, 70.0, 14.0
LEAST_TOP_DEG = 2.0
"""Least deviation that the picture has room for, so that it is calm where nothing happens [deg]."""
BACK_DEG = 0.5
"""A hand that is closer than this to where it would be has come back [deg]."""


def off_trace(pasts: Sequence[Sequence[tuple[float, float, float]]], names: Sequence[str]) -> str:
    """Return deviations over time as SVG, a line a hand, with pushes shaded.

    Parameters
    ----------
    pasts
        Of each hand, in order of time: time [s], deviation [rad], force of the push [N].
    names
        Of the hands; a single one is not named.
    """
    ends = [past[-1][0] for past in pasts if past]
    if not ends:
        return ""
    end = max(ends)
    top = max(LEAST_TOP_DEG, *(1.1 * np.rad2deg(row[1]) for past in pasts for row in past))
    shades = "".join(
        f'<rect x="{_x(start, end):.1f}" y="0" width="{max(_x(stop, end) - _x(start, end), 1):.1f}"'
        f' height="{_HEIGHT:g}" fill="#e6e8ec"/>'
        for start, stop in pushed_spans(pasts[0])
    )
    lines = "".join(
        f'<polyline fill="none" stroke="{TRACE_COLOURS[i % len(TRACE_COLOURS)]}" stroke-width="1.6"'
        ' points="'
        + " ".join(
            f"{_x(time, end):.1f},{_HEIGHT * (1 - np.rad2deg(off) / top):.1f}"
            for time, off, _ in list(past)[:: max(1, len(past) // 120)]
        )
        + '"/>'
        for i, past in enumerate(pasts)
    )
    named = "".join(
        f'<span style="color:{TRACE_COLOURS[i % len(TRACE_COLOURS)]}">■ {escape(name)}</span> '
        for i, name in enumerate(names)
        if len(names) > 1
    )
    label = 'font-size="10" fill="#5a6068"'
    return (
        '<div style="font-size:.8em;padding:0 .8em"><div>off its way [deg], pushes in grey</div>'
        f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT + _BELOW:g}" style="width:100%;display:block">'
        f'<rect width="{_WIDTH:g}" height="{_HEIGHT:g}" fill="#f6f7f9"/>{shades}{lines}'
        f'<text x="3" y="11" {label}>{top:.1f}</text>'
        f'<text x="0" y="{_HEIGHT + 11:g}" {label}>{KEPT_S:g} s ago</text>'
        f'<text x="{_WIDTH:g}" y="{_HEIGHT + 11:g}" text-anchor="end" {label}>now</text></svg>'
        f"{named}</div>"
    )


def pushed_spans(past: Sequence[tuple[float, float, float]]) -> list[tuple[float, float]]:
    """Return from when to when something pushed [s]."""
    spans: list[tuple[float, float]] = []
    start: float | None = None
    last = 0.0
    for time, _, force in past:
        if force > 0 and start is None:
            start = time
        elif force == 0 and start is not None:
            spans.append((start, last))
            start = None
        last = time
    return spans if start is None else [*spans, (start, last)]


def return_words(past: Sequence[tuple[float, float, float]]) -> str:
    """Say what the latest push did, and how long the hand took to come back."""
    spans = pushed_spans(past)
    if not spans:
        return ""
    start, stop = spans[-1]
    since = [(time, np.rad2deg(off)) for time, off, _ in past if time >= start]
    most, force = max(off for _, off in since), max(row[2] for row in past if row[0] >= start)
    said = f"Pushed with {force:.0f} N: {most:.1f} deg off its way"
    if stop == past[-1][0]:
        return f"{said}."
    after = [(time, off) for time, off in since if time > stop]
    late = [time for time, off in after if off >= BACK_DEG]
    if late and late[-1] == after[-1][0]:
        return f"{said}, {after[-1][1]:.1f} deg now."
    back = (late[-1] if late else stop) - stop + 0.01
    return f"{said}, back within {BACK_DEG:g} deg {back:.2f} s after it ended."


def _x(time: float, end: float) -> float:
    """Return where a time [s] is across the picture whose right edge is the end."""
    return _WIDTH * min(max(1.0 - (end - time) / KEPT_S, 0.0), 1.0)

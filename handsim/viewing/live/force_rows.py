"""What each finger presses, as rows of a web page."""

from collections.abc import Sequence
from html import escape

from handsim.tasks.grip_rules import LEAST_PRESS
from handsim.types import Array

FORCE_COLOUR, IDLE_COLOUR, NEED_COLOUR = "#D55E00", "#969AA0", "#0072B2"
_WIDTH = 62  # of a full bar, in per cent of the row


def force_rows(force: Array, parts: Sequence[str], need: float, most: float) -> str:
    """Return a bar for each part, with a line at the need.

    Parameters
    ----------
    force : (n,) [N]
        Normal forces.
    parts
        Their n names.
    need
        What each of two opposed parts has to press [N]; 0 draws no line.
    most
        Force of a full bar [N].
    """
    full = max(most, 1.5 * need, LEAST_PRESS)
    line = 100 * min(need / full, 1.0)
    mark = (
        f'<i style="position:absolute;left:{line:.1f}%;top:0;bottom:0;'
        f'border-left:2px solid {NEED_COLOUR}"></i>'
        if need > 0
        else ""
    )
    rows: list[str] = []
    for part, newton in zip(parts, force.tolist(), strict=True):
        colour = FORCE_COLOUR if newton >= LEAST_PRESS else IDLE_COLOUR
        share = 100 * min(max(newton, 0.0) / full, 1.0)
        rows.append(
            '<div style="display:flex;align-items:center;gap:.4em;font-size:.8em;line-height:1.5">'
            f'<span style="width:20%">{escape(part)}</span>'
            f'<span style="position:relative;width:{_WIDTH}%;height:.75em;background:#eef0f3">'
            f'<i style="display:block;height:100%;width:{share:.1f}%;background:{colour}"></i>'
            f"{mark}</span><span>{newton:.1f} N</span></div>"
        )
    return "".join(rows)

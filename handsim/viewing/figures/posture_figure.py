"""A movement of the controller posture by posture, beside the recorded one (Fig. 9 and 8)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handsim.navigation.paths import at_arc_length
from handsim.types import Array, Frame
from handsim.viewing.figures.style import WIDE, drawing
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.posture_clips import posture_clip, posture_model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

N_POSTURES = 7
_CUT = 0.1
"""Share of a picture's width that is left out on each side: there is nothing but background."""


def along_path(path: Array, n: int = N_POSTURES) -> Array:
    """Return n points at equal shares of the arc length of a path (m, d), (n, d)."""
    return at_arc_length(path, np.linspace(0, 1, n))


def draw_postures(postures: Array, size: int = 300) -> list[Frame]:
    """Draw the hand in each of some postures (n, 22) [rad], (size, size, 3) each."""
    clip = posture_clip(np.arange(float(len(postures))), postures, posture_model())
    return list(render_clips([clip], View(width=size, height=size, fps=1)))


def postures_figure(recorded: Sequence[Frame], followed: Sequence[Frame], name: str) -> "Figure":
    """Draw two movements one above the other, the recorded one and that of the controller.

    Parameters
    ----------
    recorded, followed
        Pictures at equal shares of the arc length in the subspace.
    name
        Of the recording.
    """
    n = len(followed)
    with drawing(WIDE, 2 * 1.25 * WIDE / n + 0.45) as figure:
        panels = figure.subplots(2, n, gridspec_kw={"wspace": 0.0, "hspace": 0.0})
        rows = (("recording", recorded), ("controller", followed))
        for row, (label, pictures) in zip(panels, rows, strict=True):
            for i, (axes, picture) in enumerate(zip(row, pictures, strict=True)):
                edge = round(_CUT * picture.shape[1])
                axes.imshow(picture[:, edge : picture.shape[1] - edge])
                axes.set(xticks=[], yticks=[])
                for side in axes.spines.values():
                    side.set_visible(False)
                if label == "controller":
                    axes.set_xlabel(f"{i / (n - 1):.2f}")
            row[0].set_ylabel(label)
        figure.supxlabel(f"share of the way, {name}", fontsize=8)
    return figure

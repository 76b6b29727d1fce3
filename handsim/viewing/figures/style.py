"""Style of the figures: colours for the colour-blind and for print, sizes, labels, file formats."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LineStyle = dict[str, Any]
"""Keyword arguments of matplotlib's ``plot``."""

# Okabe and Ito's palette. Recordings and controller differ in lightness and line style as well.
BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
RECORDED: LineStyle = {
    "color": BLUE,
    "linestyle": "-",
    "linewidth": 0.9,
    "alpha": 0.75,
    "label": "recording",
}
FOLLOWED: LineStyle = {
    "color": VERMILION,
    "linestyle": (0, (4, 1.5)),
    "linewidth": 1.1,
    "label": "controller",
}
RECORDED_ON_FIELD: LineStyle = {"color": "#56B4E9", "linewidth": 1.4, "label": "recording"}
FOLLOWED_ON_FIELD: LineStyle = {"color": VERMILION, "linewidth": 1.4, "label": "controller"}
START: LineStyle = {
    "marker": "s",
    "color": GREEN,
    "linestyle": "none",
    "markersize": 4,
    "zorder": 3,
    "label": "start",
}
GOAL: LineStyle = {**START, "marker": "o", "color": VERMILION, "label": "destination"}
FIELD_COLOURS = "viridis"
WIDE, NARROW = 7.2, 3.5
"""Two columns and one of a printed page [inch]."""

_RC: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.2,
    "savefig.dpi": 200,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "handsim",  # the same figure gives the same bytes
}


@contextmanager
def drawing(width: float, height: float) -> Generator["Figure", None, None]:
    """Yield an empty figure of a size in inch, drawn and styled within the block."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_RC):
        yield Figure(figsize=(width, height))


SUFFIXES = (".png", ".svg")


def save_figure(
    figure: "Figure", folder: Path, name: str, suffixes: Sequence[str] = SUFFIXES
) -> list[Path]:
    """Write a figure as ``name.png`` and ``name.svg``, each as a whole or not at all.

    It is laid out once, when it is written for the first time.

    Raises
    ------
    FileError
        If the folder does not exist or cannot be written.
    """
    paths = [Path(folder) / f"{name}{suffix}" for suffix in suffixes]
    for path in paths:
        save_picture(figure, path)
        figure.set_layout_engine("none")
    return paths


def save_picture(figure: "Figure", path: Path) -> None:
    """Write a figure as one file, as a whole or not at all; the suffix says the format.

    Raises
    ------
    FileError
        If the folder does not exist or cannot be written.
    """
    import matplotlib

    with matplotlib.rc_context(_RC), replacing(path) as temporary:
        undated = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(temporary, metadata=undated)


def label_panel(axes: "Axes", letter: str) -> None:
    """Write a panel's letter at its upper left, outside the axes."""
    axes.set_title(letter, loc="left", fontweight="bold")


def name_axes(axes: Any, pick: tuple[int, ...]) -> None:
    """Label axes with the components that they show: ``pick`` counts from 0, labels from 1."""
    for letter, i in zip("xyz", pick, strict=False):
        axes.set(**{f"{letter}label": f"PC {i + 1} [deg]"})


def quiet_space(axes: Any) -> None:
    """Give axes in three dimensions pale walls, few ticks and the whole room of their panel."""
    from matplotlib.ticker import MaxNLocator

    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MaxNLocator(4))
        axis.pane.set_facecolor("#F7F8FA")
        axis.pane.set_edgecolor("#D5DAE0")
        axis._axinfo["grid"].update(color="#E3E7EC", linewidth=0.5)  # there is no other way
        axis.labelpad = -3.0
    axes.zaxis.labelpad = -9.0  # else it reaches into the next panel
    axes.tick_params(pad=-1, labelsize=7)
    spans = [high - low for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
    axes.set_box_aspect(np.maximum(spans, 0.75 * max(spans)), zoom=1.02)


def add_legend(figure: "Figure", *styles: LineStyle) -> None:
    """Name what is drawn in these styles, below all panels."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], **style) for style in styles]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))

"""Level sets of the navigation function and its flow, in planes through a destination."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.navigation.function import NavigationFunction
from handsim.types import Array
from handsim.viewing.figures.slices import level_shell, slice_through
from handsim.viewing.figures.style import (
    FIELD_COLOURS,
    FOLLOWED_ON_FIELD,
    GOAL,
    NARROW,
    RECORDED_ON_FIELD,
    START,
    WIDE,
    LineStyle,
    add_legend,
    drawing,
    name_axes,
    quiet_space,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = np.linspace(0, 1, 15) ** 2
"""Level sets of phi that are drawn; near the destination phi grows with the distance squared."""


def level_sets_figure(navigation: NavigationFunction, recorded: Array, followed: Array) -> "Figure":
    """Level sets and vector field of a 2-dimensional controller (the paper's Fig. 1b).

    Parameters
    ----------
    navigation
        Of a 2-dimensional subspace.
    recorded, followed : (n, 2) [rad]
        A recording, whose end is the destination, and the controller's path from its start.
    """
    with drawing(1.4 * NARROW, 1.05 * NARROW) as figure:
        axes = figure.subplots()
        picture = _draw_slice(axes, navigation, recorded[-1], (0, 1))
        _draw_path(axes, recorded, RECORDED_ON_FIELD)
        _draw_path(axes, followed, FOLLOWED_ON_FIELD)
        _mark_ends(axes, recorded)
        _colour_bar(figure, picture, [axes])
        add_legend(figure, RECORDED_ON_FIELD, FOLLOWED_ON_FIELD)
    return figure


def field_figure(navigation: NavigationFunction, path: Array, recorded: Array) -> "Figure":
    """Vector field and level sets about a destination (the paper's Fig. 4).

    Of three components or more it is a picture of the first three beside slices through the
    destination, of two it is the plane itself.

    Parameters
    ----------
    navigation
        Of 2 dimensions or more.
    path : (n, n_components) [rad]
        A path of the controller; its end is the destination.
    recorded : (m, n_components) [rad]
        The recording with the same ends.
    """
    n = navigation.n_dimensions
    pairs = [(0, 1), (0, 2), (1, 2)] if n > 2 else [(0, 1)]
    with drawing(WIDE, 0.74 * WIDE if n == 3 else 0.33 * WIDE if n > 3 else 0.6 * WIDE) as figure:
        if n == 3:
            grid = figure.add_gridspec(3, 3, width_ratios=[2.35, 0.14, 1])  # labels in between
            panels = [figure.add_subplot(grid[i, 2]) for i in range(3)]
            space = figure.add_subplot(grid[:, 0], projection="3d")
            _draw_space(space, navigation, path, recorded)
        else:
            panels = list(figure.subplots(1, len(pairs), squeeze=False)[0])
        pictures: list[Any] = []
        for axes, pair in zip(panels, pairs, strict=True):
            pictures.append(_draw_slice(axes, navigation, path[-1], pair))
            _draw_path(axes, recorded[:, pair], RECORDED_ON_FIELD)
            _draw_path(axes, path[:, pair], FOLLOWED_ON_FIELD)
            _mark_ends(axes, path[:, pair])
        _colour_bar(figure, pictures[0], panels)
        add_legend(figure, RECORDED_ON_FIELD, FOLLOWED_ON_FIELD, START, GOAL)
    return figure


SHELLS = (0.05, 0.18, 0.4)
"""Level sets of phi that are drawn in space."""
_ARROWS = 6
"""Arrows along the longest side of the workspace."""


def _draw_space(axes: Any, navigation: NavigationFunction, path: Array, recorded: Array) -> None:
    """Draw shells of equal phi about the destination, the flow, and both paths."""
    from matplotlib import colormaps

    goal, low, high = path[-1], navigation.obstacle.lower, navigation.obstacle.upper
    colours = colormaps[FIELD_COLOURS]
    for level, opacity in zip(SHELLS, (0.5, 0.24, 0.12), strict=True):
        shell = np.rad2deg(np.clip(level_shell(navigation, goal, level, 41), low, high))
        axes.plot_surface(
            *np.moveaxis(shell, -1, 0),
            color=colours(level**0.5),
            alpha=opacity,
            linewidth=0,
            rcount=60,
            ccount=60,
            rasterized=True,
        )
    step = float((high - low).max()) / _ARROWS
    sides = [np.arange(lo + step / 2, hi, step) for lo, hi in zip(low, high, strict=True)]
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    arrows = 0.4 * step * navigation.directions(places, goal)
    axes.quiver(
        *np.rad2deg(places.T),
        *np.rad2deg(arrows.T),
        color="#5B6672",
        linewidth=0.5,
        arrow_length_ratio=0.4,
        alpha=0.55,
    )
    for curve, style in ((recorded, RECORDED_ON_FIELD), (path, FOLLOWED_ON_FIELD)):
        axes.plot(*np.rad2deg(curve.T), **{**style, "linewidth": 2.2}, zorder=10)
    axes.plot(*np.rad2deg(path[:1].T), **{**START, "markersize": 6, "zorder": 11})
    axes.plot(*np.rad2deg(goal[:, None]), **{**GOAL, "markersize": 6, "zorder": 11})
    axes.set(**{f"{a}lim": tuple(np.rad2deg([lo, hi])) for a, lo, hi in zip("xyz", low, high)})  # noqa: B905
    axes.view_init(elev=22, azim=-62)
    quiet_space(axes)
    name_axes(axes, (0, 1, 2))


def _draw_slice(
    axes: "Axes", navigation: NavigationFunction, goal: Array, pair: tuple[int, int]
) -> Any:
    """Draw level sets of phi and the flow within a plane through the destination."""
    from matplotlib.colors import PowerNorm

    plane = slice_through(navigation, goal, pair)
    phi, flow = plane.phi(navigation, goal), plane.flow(navigation, goal)
    x, y = np.rad2deg(plane.first), np.rad2deg(plane.second)
    picture = axes.contourf(x, y, phi, levels=LEVELS, cmap=FIELD_COLOURS, norm=PowerNorm(0.5, 0, 1))
    picture.set_rasterized(True)
    axes.contour(x, y, phi, levels=LEVELS[1:-1], colors="black", linewidths=0.35)
    u, v = flow[..., 0], flow[..., 1]
    pale = "#FFFFFF8C"
    axes.streamplot(x, y, u, v, density=0.9, color=pale, linewidth=0.6, arrowsize=0.7)
    axes.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), aspect="equal")
    name_axes(axes, pair)
    return picture


def _colour_bar(figure: "Figure", picture: Any, axes: Sequence["Axes"]) -> None:
    bar = figure.colorbar(picture, ax=axes, label="φ", shrink=0.85, aspect=28)
    bar.set_ticks([0, 0.05, 0.2, 0.4, 0.6, 0.8, 1])


def _draw_path(axes: "Axes", path: Array, style: LineStyle) -> None:
    """Draw a path [rad] with a dark edge, which sets it off from any colour."""
    from matplotlib.patheffects import Normal, Stroke

    edge = [Stroke(linewidth=style["linewidth"] + 1.2, foreground="black"), Normal()]
    solid: LineStyle = {**style, "linestyle": "-"}
    axes.plot(*np.rad2deg(path.T), **solid, path_effects=edge)


def _mark_ends(axes: "Axes", path: Array) -> None:
    start, goal = np.rad2deg(path[[0, -1]])
    edge: LineStyle = {"markeredgecolor": "white"}
    axes.plot(*start[:, None], **START, **edge)
    axes.plot(*goal[:, None], **GOAL, **edge)

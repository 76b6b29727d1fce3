"""The counterparts of the paper's figures, drawn from a controller and its recordings."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from handsim.learning.controller import GraspController
from handsim.learning.direction.learner import DirectionLearner, History
from handsim.learning.scores import roll_out
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.flow import follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.paths import arc_length, at_arc_length
from handsim.recordings.folder import RecordingSet
from handsim.recordings.recording import SYNTHETIC
from handsim.types import Array, Progress
from handsim.viewing.figures.style import (
    BLUE,
    FIELD_COLOURS,
    FOLLOWED,
    FOLLOWED_ON_FIELD,
    GOAL,
    NARROW,
    RECORDED,
    RECORDED_ON_FIELD,
    START,
    VERMILION,
    WIDE,
    drawing,
    label_panel,
    save_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LEVELS = np.linspace(0, 1, 15) ** 2
"""Level sets of phi that are drawn; near the destination phi grows with the distance squared."""
_N_GRID = 121  # points of a slice along each axis


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
        _legend(figure, RECORDED_ON_FIELD, FOLLOWED_ON_FIELD)
    return figure


def learning_figure(navigation: NavigationFunction, history: History) -> "Figure":
    """Obstacle and convergence of a 2-dimensional fit (the paper's Fig. 3).

    Parameters
    ----------
    navigation
        Of a 2-dimensional subspace.
    history
        Of the fit.
    """
    with drawing(WIDE, 0.75 * WIDE) as figure:
        grid = figure.add_gridspec(2, 2)
        surface = figure.add_subplot(grid[0, 0], projection="3d")
        points, shape = _grid(navigation, navigation.obstacle.lower, (0, 1))
        ln_beta = navigation.obstacle.log_jets(points, navigation.k, 0)[0].reshape(shape)
        x, y = np.rad2deg(points.reshape(*shape, 2)).transpose(2, 0, 1)
        low = float(np.quantile(ln_beta, 0.04))  # beta falls to 0 on the boundary, ln beta to -inf
        surface.plot_surface(
            *(x, y, np.maximum(ln_beta, low)),
            cmap=FIELD_COLOURS,
            linewidth=0,
            rcount=60,
            ccount=60,
            rasterized=True,
        )
        surface.set(xlabel="PC 1 [deg]", ylabel="PC 2 [deg]", zlabel="ln β")
        surface.view_init(elev=32, azim=-125)  # the axis of ln beta on the left
        surface.set_box_aspect((1.2, 1, 0.7))
        label_panel(surface, "a")
        iterations = np.arange(1, len(history.cost) + 1)
        for place, letter, values, label in (
            ((0, 1), "b", history.cost, "cost J"),
            ((1, 0), "c", history.gradient_norm, "gradient norm ‖∇J‖"),
            ((1, 1), "d", history.change, "change of the coefficients ‖Δc‖"),
        ):
            axes = figure.add_subplot(grid[place])
            axes.plot(iterations, values, color=BLUE)
            axes.set(xlabel="iteration", ylabel=label, yscale="linear" if letter == "b" else "log")
            axes.grid(visible=True, linewidth=0.3)
            label_panel(axes, letter)
    return figure


def field_figure(navigation: NavigationFunction, path: Array) -> "Figure":
    """Vector field and level sets about a destination (the paper's Fig. 4), as slices through it.

    Parameters
    ----------
    navigation
        Of 2 dimensions or more.
    path : (n, n_components) [rad]
        A path of the controller; its end is the destination.
    """
    n = navigation.n_dimensions
    pairs = [(0, 1), (0, 2), (1, 2)] if n > 2 else [(0, 1)]
    with drawing(WIDE, 0.33 * WIDE if n > 2 else 0.6 * WIDE) as figure:
        spans = [navigation.obstacle.upper[i] - navigation.obstacle.lower[i] for i, _ in pairs]
        pictures = []
        all_axes = figure.subplots(1, len(pairs), squeeze=False, width_ratios=spans)[0]
        for axes, pair in zip(all_axes, pairs, strict=True):
            pictures.append(_draw_slice(axes, navigation, path[-1], pair))
            _draw_path(axes, path[:, pair], FOLLOWED_ON_FIELD)
            _mark_ends(axes, path[:, pair])
        _colour_bar(figure, pictures[0], list(all_axes))
        _legend(figure, FOLLOWED_ON_FIELD)
    return figure


def variance_figure(q: Array, n_components: int) -> "Figure":
    """Variance explained by the first principal components (the paper's Fig. 5).

    Parameters
    ----------
    q : (n, 22) [rad]
        All recorded postures.
    n_components
        How many of them the subspace keeps.
    """
    singular = np.linalg.svd(q - q.mean(axis=0), compute_uv=False)
    share = 100 * np.cumsum(singular**2) / np.sum(singular**2)
    count = np.arange(1, len(share) + 1)
    with drawing(NARROW, 0.75 * NARROW) as figure:
        axes = figure.subplots()
        axes.bar(count, share, color=[BLUE if i <= n_components else "#B9C4D0" for i in count])
        axes.annotate(
            f"{n_components} components: {share[n_components - 1]:.1f} %",
            (n_components, share[n_components - 1]),
            (n_components + 3, max(share[n_components - 1] - 30, 5)),
            arrowprops={"arrowstyle": "->", "color": VERMILION},
            color=VERMILION,
            backgroundcolor="white",
        )
        axes.set(xlabel="principal components", ylabel="cumulative variance [%]", ylim=(0, 102))
        axes.set_xticks([1, 5, 10, 15, 22])
    return figure


def paths_figure(recorded: Sequence[Array], followed: Sequence[Array]) -> "Figure":
    """Recordings and the controller's paths in the subspace (the paper's Fig. 6).

    Parameters
    ----------
    recorded, followed : (n_i, n_components) [rad] each
        In the same order, with the same starts and destinations.
    """
    n = recorded[0].shape[1]
    starts = np.rad2deg([path[0] for path in recorded])
    goals = np.rad2deg([path[-1] for path in recorded])
    with drawing(WIDE, 0.8 * WIDE if n > 2 else 0.6 * WIDE) as figure:
        pairs = [(0, 1), (0, 2), (1, 2)] if n > 2 else [(0, 1)]
        grid = figure.add_gridspec(2, 2) if n > 2 else figure.add_gridspec(1, 1)
        panels: list[tuple[Any, tuple[int, ...]]] = []
        if n > 2:
            panels.append((figure.add_subplot(grid[0, 0], projection="3d"), (0, 1, 2)))
        for place, pair in zip([(0, 1), (1, 0), (1, 1)] if n > 2 else [(0, 0)], pairs, strict=True):
            panels.append((figure.add_subplot(grid[place]), pair))
        for axes, pick in panels:
            columns = list(pick)
            for style, paths in ((RECORDED, recorded), (FOLLOWED, followed)):
                for path in paths:
                    axes.plot(*np.rad2deg(path[:, columns].T), **style)
            axes.plot(*starts[:, columns].T, **START)
            axes.plot(*goals[:, columns].T, **GOAL)
            _name_axes(axes, pick)
            if len(pick) == 3:
                axes.set_box_aspect((4, 4, 3), zoom=0.85)  # leaves room for the labels
        _legend(figure, RECORDED, FOLLOWED, START, GOAL)
    return figure


def components_figure(
    recorded: Sequence[Array],
    followed: Sequence[Array],
    eigengrasps: Sequence[Sequence[npt.NDArray[np.uint8]]],
    reach: float,
) -> "Figure":
    """Principal components over normalised arc length, and eigengrasps (the paper's Fig. 7).

    Parameters
    ----------
    recorded, followed : (n_i, n_components) [rad] each
    eigengrasps
        For each component, pictures of the hand at -reach, 0 and +reach standard deviations.
    reach
        See above.
    """
    n, shares = recorded[0].shape[1], np.linspace(0, 1, 101)
    titles = (f"−{reach:g} σ", "mean", f"+{reach:g} σ")
    with drawing(WIDE, 0.23 * WIDE * n + 0.3) as figure:
        grid = figure.add_gridspec(n, 4, width_ratios=[1.9, 1, 1, 1])
        for i in range(n):
            axes = figure.add_subplot(grid[i, 0])
            for style, paths in ((RECORDED, recorded), (FOLLOWED, followed)):
                for path in paths:
                    axes.plot(shares, np.rad2deg(at_arc_length(path, shares)[:, i]), **style)
            axes.set(ylabel=f"PC {i + 1} [deg]", xlim=(0, 1))
            if i == n - 1:
                axes.set_xlabel("normalised arc length")
            for j, picture in enumerate(eigengrasps[i]):
                panel = figure.add_subplot(grid[i, j + 1])
                panel.imshow(picture)
                panel.set_axis_off()
                panel.set_title(titles[j] if i == 0 else "")
        _legend(figure, RECORDED, FOLLOWED)
    return figure


def make_figures(
    controller: GraspController,
    recordings: RecordingSet,
    folder: Path,
    progress: Progress | None = None,
) -> list[Path]:
    """Draw all figures into a folder, each as PNG and SVG; those that need a plane from 2 up.

    The 2-dimensional ones (1b and 3) show a fit of two components to the same recordings, as the
    paper's do, without refinements: those add samples, and costs before and after do not compare.

    Figures of synthetic recordings say so.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the recordings cannot be learned from.
    MissingToolError
        If nothing renders the hand.
    """
    paths = [controller.subspace.transform(recording.q) for recording in recordings]
    followed = [run.points for run in roll_out(controller, paths)]
    lengths = [arc_length(path)[-1] for path in paths]
    shown = int(np.argsort(lengths)[len(lengths) // 2])  # neither the longest nor the shortest
    q = np.vstack([recording.q for recording in recordings])
    plane = PostureSubspace(2).fit(q)
    flat = [plane.transform(recording.q) for recording in recordings]
    learner = DirectionLearner(k=controller.navigation.k, n_refinements=0, n_iterations=150).fit(
        flat
    )
    flat_run = follow(learner.navigation_.directions, flat[shown][:1], flat[shown][-1:])[0]
    reach = 2.0
    figures = {
        "fig1b_level_sets": lambda: level_sets_figure(
            learner.navigation_, flat[shown], flat_run.points
        ),
        "fig3_learning": lambda: learning_figure(learner.navigation_, learner.history_),
        "fig4_field": lambda: field_figure(controller.navigation, followed[shown]),
        "fig5_variance": lambda: variance_figure(q, controller.navigation.n_dimensions),
        "fig6_paths": lambda: paths_figure(paths, followed),
        "fig7_components": lambda: components_figure(
            paths, followed, draw_eigengrasps(controller.subspace, reach), reach
        ),
    }
    if controller.navigation.n_dimensions == 1:  # neither a plane to slice nor paths in one
        del figures["fig4_field"], figures["fig6_paths"]
    synthetic = all(recording.subject == SYNTHETIC for recording in recordings)
    written: list[Path] = []
    for i, (name, make) in enumerate(figures.items()):
        figure = make()
        if synthetic:
            figure.suptitle("synthetic recordings", x=0.99, ha="right", size=7, color="#6B7280")
        written += save_figure(figure, folder, name)
        if progress:
            progress((i + 1) / len(figures))
    return written


def draw_eigengrasps(
    subspace: PostureSubspace, reach: float = 2.0, size: int = 320
) -> list[list[npt.NDArray[np.uint8]]]:
    """Draw the hand at -reach, 0 and +reach standard deviations along each component.

    Returns
    -------
    list of n_components lists of 3 pictures (size, size, 3)
    """
    from handsim.viewing.film.clips import render_clips
    from handsim.viewing.film.offscreen import View
    from handsim.viewing.film.posture_clips import posture_clip, posture_model

    n = len(subspace.components_)
    deviations = np.diag(np.sqrt(subspace.explained_variance_))
    steps = np.repeat(deviations, 3, axis=0) * np.tile([-reach, 0.0, reach], n)[:, None]
    q = subspace.inverse_transform(steps)
    clip = posture_clip(np.arange(3.0 * n), q, posture_model())
    frames = list(render_clips([clip], View(width=size, height=size, fps=1)))
    return [frames[3 * i : 3 * i + 3] for i in range(n)]


def _grid(
    navigation: NavigationFunction, through: Array, pair: tuple[int, int]
) -> tuple[Array, tuple[int, int]]:
    """Points of a slice of the workspace through a point, (N, n), and its shape (rows, columns)."""
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    x, y = (np.linspace(low[i], high[i], _N_GRID) for i in pair)
    points = np.tile(through, (_N_GRID * _N_GRID, 1))
    points[:, pair[0]] = np.tile(x, _N_GRID)
    points[:, pair[1]] = np.repeat(y, _N_GRID)
    return points, (_N_GRID, _N_GRID)


def _draw_slice(
    axes: "Axes", navigation: NavigationFunction, goal: Array, pair: tuple[int, int]
) -> Any:
    """Level sets of phi and the flow within a plane through the destination."""
    from matplotlib.colors import PowerNorm

    points, shape = _grid(navigation, goal, pair)
    phi = navigation.jets(points, goal, 0)[0].reshape(shape)
    flow = navigation.directions(points, goal)
    x, y = (np.rad2deg(points[:, i]).reshape(shape) for i in pair)
    picture = axes.contourf(x, y, phi, levels=LEVELS, cmap=FIELD_COLOURS, norm=PowerNorm(0.5, 0, 1))
    picture.set_rasterized(True)
    axes.contour(x, y, phi, levels=LEVELS[1:-1], colors="black", linewidths=0.35)
    u, v = (flow[:, i].reshape(shape) for i in pair)
    pale = "#FFFFFF8C"
    axes.streamplot(x[0], y[:, 0], u, v, density=0.9, color=pale, linewidth=0.6, arrowsize=0.7)
    axes.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), aspect="equal")
    _name_axes(axes, pair)
    return picture


def _colour_bar(figure: "Figure", picture: Any, axes: Sequence["Axes"]) -> None:
    bar = figure.colorbar(picture, ax=axes, label="φ", shrink=0.85)
    bar.set_ticks([0, 0.05, 0.2, 0.4, 0.6, 0.8, 1])


def _draw_path(axes: "Axes", path: Array, style: dict[str, Any]) -> None:
    """Draw a path [rad] with a dark edge, which sets it off from any colour."""
    from matplotlib.patheffects import Normal, Stroke

    edge = [Stroke(linewidth=style["linewidth"] + 1.2, foreground="black"), Normal()]
    solid = {**style, "linestyle": "-"}
    axes.plot(*np.rad2deg(path.T), **solid, path_effects=edge)


def _mark_ends(axes: "Axes", path: Array) -> None:
    start, goal = np.rad2deg(path[[0, -1]])
    axes.plot(*start[:, None], **{**START, "markeredgecolor": "white"})
    axes.plot(*goal[:, None], **{**GOAL, "markeredgecolor": "white"})


def _name_axes(axes: Any, pick: tuple[int, ...]) -> None:
    for letter, i in zip("xyz", pick, strict=False):
        axes.set(**{f"{letter}label": f"PC {i + 1} [deg]"})


def _legend(figure: "Figure", *styles: dict[str, Any]) -> None:
    """Name what is drawn in these styles, below all panels."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], **style) for style in styles]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))

"""Recordings and the controller's paths: in the subspace, and one component at a time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.learning.subspace import PostureSubspace
from handsim.navigation.paths import at_arc_length
from handsim.types import Array, Frame
from handsim.viewing.figures.style import (
    FOLLOWED,
    GOAL,
    RECORDED,
    START,
    WIDE,
    add_legend,
    drawing,
    name_axes,
    quiet_space,
)
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.posture_clips import posture_clip, posture_model

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
    with drawing(WIDE, 0.74 * WIDE if n > 2 else 0.6 * WIDE) as figure:
        panels: list[tuple[Any, tuple[int, ...]]] = []
        if n > 2:
            grid = figure.add_gridspec(3, 3, width_ratios=[2.35, 0.14, 1])  # labels in between
            panels.append((figure.add_subplot(grid[:, 0], projection="3d"), (0, 1, 2)))
            for i, pair in enumerate(((0, 1), (0, 2), (1, 2))):
                panels.append((figure.add_subplot(grid[i, 2]), pair))
        else:
            panels.append((figure.subplots(), (0, 1)))
        for axes, pick in panels:
            columns, thin = list(pick), {"linewidth": 0.8} if n > 2 else {}
            for style, paths in ((RECORDED, recorded), (FOLLOWED, followed)):
                for path in paths:
                    axes.plot(*np.rad2deg(path[:, columns].T), **{**style, **thin})
            small = {"markersize": 3} if n > 2 and len(pick) == 2 else {}
            axes.plot(*starts[:, columns].T, **{**START, **small})
            axes.plot(*goals[:, columns].T, **{**GOAL, **small})
            name_axes(axes, pick)
            if len(pick) == 3:
                axes.view_init(elev=24, azim=-58)
                quiet_space(axes)
        add_legend(figure, RECORDED, FOLLOWED, START, GOAL)
    return figure


def components_figure(
    recorded: Sequence[Array],
    followed: Sequence[Array],
    eigengrasps: Sequence[Sequence[Frame]],
    reach: float,
) -> "Figure":
    """Principal components over normalised arc length, and eigengrasps (the paper's Fig. 7).

    Parameters
    ----------
    recorded, followed : (n_i, n_components) [rad] each
    eigengrasps
        For each component, pictures of the hand at -reach, 0 and +reach standard deviations. The
        mean is the same for all, and drawn once.
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
            for j in (0, 2):
                _show(figure.add_subplot(grid[i, j + 1]), eigengrasps[i][j], titles[j], i == 0)
        _show(figure.add_subplot(grid[:, 2]), eigengrasps[0][1], titles[1], True)
        add_legend(figure, RECORDED, FOLLOWED)
    return figure


def _show(axes: "Axes", picture: Frame, title: str, titled: bool) -> None:
    axes.imshow(picture)
    axes.set_axis_off()
    axes.set_title(title if titled else "")


def eigengrasps(subspace: PostureSubspace, reach: float = 2.0) -> Array:
    """Return postures (n_components, 3, 22) [rad] along each component.

    Parameters
    ----------
    subspace
    reach
        The three are at -reach, 0 and +reach standard deviations of the recordings from the mean.
    """
    n = len(subspace.components_)
    deviations = np.diag(np.sqrt(subspace.explained_variance_))
    steps = np.repeat(deviations, 3, axis=0) * np.tile([-reach, 0.0, reach], n)[:, None]
    return subspace.inverse_transform(steps).reshape(n, 3, -1)


def draw_eigengrasps(
    subspace: PostureSubspace, reach: float = 2.0, size: int = 320
) -> list[list[Frame]]:
    """Draw the hand in the postures of `eigengrasps`.

    Returns
    -------
    list of n_components lists of 3 pictures (size, size, 3)
    """
    postures = np.vstack(list(eigengrasps(subspace, reach)))
    clip = posture_clip(np.arange(float(len(postures))), postures, posture_model())
    frames = list(render_clips([clip], View(width=size, height=size, fps=1)))
    return [frames[i : i + 3] for i in range(0, len(frames), 3)]

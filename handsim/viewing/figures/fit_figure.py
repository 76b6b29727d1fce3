"""The obstacle that a fit has learned, and how the fit converged."""

from typing import TYPE_CHECKING

import numpy as np

from handsim.learning.direction.learner import History
from handsim.navigation.function import NavigationFunction
from handsim.viewing.figures.slices import slice_through
from handsim.viewing.figures.style import BLUE, FIELD_COLOURS, WIDE, drawing, label_panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        plane = slice_through(navigation, navigation.obstacle.lower)
        ln_beta = plane.ln_beta(navigation)
        x, y = np.meshgrid(np.rad2deg(plane.first), np.rad2deg(plane.second))
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
        figure.suptitle(
            "refit of two components to the same recordings, drawn whole", x=0.01, ha="left", size=8
        )
    return figure

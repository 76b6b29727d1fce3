"""A navigation function among spheres: what phi looks like where obstacles are known (Fig. 1a)."""

from typing import TYPE_CHECKING, Any

import numpy as np

from handsim.types import Array
from handsim.viewing.figures.style import FIELD_COLOURS, GOAL, NARROW, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RADIUS = 1.0
"""Of the disc in which the point moves; all lengths here have no unit."""
CENTRES = np.array([[-0.45, 0.15], [0.1, 0.5], [0.15, -0.4], [0.55, 0.05]])
RADII = np.array([0.16, 0.13, 0.2, 0.1])
DESTINATION = np.array([-0.3, -0.55])
EXPONENT = 7.0
"""k of Eq. (2), above the least with which these spheres leave no minimum but the destination."""


def sphere_phi(points: Array) -> Array:
    """Return phi of Eq. (2) for the spheres above, (n,): 1 in an obstacle and beyond the disc.

    beta is the product over the obstacles of the squared distances to their centres, each less its
    radius squared, and of the squared radius of the disc less the squared distance to its middle.

    Parameters
    ----------
    points : (n, 2)
    """
    outer = RADIUS**2 - (points**2).sum(axis=1)
    apart = ((points[:, None] - CENTRES) ** 2).sum(axis=2) - RADII**2
    free = (outer > 0) & (apart > 0).all(axis=1)
    beta = outer * apart.prod(axis=1)
    gamma = ((points - DESTINATION) ** 2).sum(axis=1)
    phi = np.ones(len(points))
    phi[free] = gamma[free] / (gamma[free] ** EXPONENT + beta[free]) ** (1 / EXPONENT)
    return phi


def sphere_world_figure(resolution: int = 181) -> "Figure":
    """Draw phi over a disc with four round obstacles, as a landscape above its level sets.

    Parameters
    ----------
    resolution
        Points along each side.
    """
    from matplotlib.patches import Circle

    side = np.linspace(-RADIUS, RADIUS, resolution)
    x, y = np.meshgrid(side, side)
    points = np.column_stack([x.ravel(), y.ravel()])
    phi = sphere_phi(points).reshape(x.shape)
    inside = np.hypot(x, y) <= RADIUS
    with drawing(2 * NARROW, NARROW) as figure:
        landscape: Any = figure.add_subplot(1, 2, 1, projection="3d")
        landscape.plot_surface(
            *(x, y, np.where(inside, phi, np.nan)),
            cmap=FIELD_COLOURS,
            linewidth=0,
            rcount=90,
            ccount=90,
            vmin=0,
            vmax=1,
            rasterized=True,
        )
        landscape.view_init(elev=48, azim=-75)
        landscape.set_box_aspect((1, 1, 0.55), zoom=1.1)
        landscape.set(zlabel="φ", xticks=[-1, 0, 1], yticks=[-1, 0, 1], zticks=[0, 0.5, 1])
        plan = figure.add_subplot(1, 2, 2)
        levels = np.linspace(0, 1, 13)
        shown = np.where(inside, phi, np.nan)
        picture = plan.contourf(x, y, shown, levels=levels, cmap=FIELD_COLOURS, vmin=0, vmax=1)
        picture.set_rasterized(True)
        plan.contour(x, y, shown, levels=levels[1:-1], colors="black", linewidths=0.35)
        for centre, radius in zip(CENTRES, RADII, strict=True):
            plan.add_patch(Circle(tuple(centre), float(radius), color="#4A5560"))
        plan.add_patch(Circle((0, 0), RADIUS, fill=False, color="#4A5560", linewidth=1.0))
        plan.plot(*DESTINATION[:, None], **GOAL, markeredgecolor="white")
        plan.set(aspect="equal", xlim=(-1.03, 1.03), ylim=(-1.03, 1.03))
        plan.set_axis_off()
        figure.colorbar(picture, ax=plan, label="φ", shrink=0.8, ticks=[0, 0.25, 0.5, 0.75, 1])
    return figure

"""Variance of the recordings that the first principal components explain."""

from typing import TYPE_CHECKING

import numpy as np

from handsim.joints import N_JOINTS
from handsim.types import Array
from handsim.viewing.figures.style import BLUE, NARROW, VERMILION, drawing
from handsim.wording import number_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def cumulative_variance(q: Array) -> Array:
    """Return the fraction of variance in the first 1, 2, ... 22 components (Fig. 5), (22,).

    Parameters
    ----------
    q : (n, 22) [rad]
    """
    deviation = q - q.mean(axis=0)
    singular = np.zeros(N_JOINTS)
    found = np.linalg.svd(deviation, compute_uv=False)
    singular[: len(found)] = found
    total = np.cumsum(singular**2)
    return total / max(float(total[-1]), np.finfo(float).tiny)


def variance_figure(q: Array, n_components: int) -> "Figure":
    """Variance explained by the first principal components (the paper's Fig. 5).

    Parameters
    ----------
    q : (n, 22) [rad]
        All recorded postures.
    n_components
        How many of them the subspace keeps.
    """
    share = 100 * cumulative_variance(q)
    count = np.arange(1, len(share) + 1)
    with drawing(NARROW, 0.75 * NARROW) as figure:
        axes = figure.subplots()
        axes.bar(count, share, color=[BLUE if i <= n_components else "#B9C4D0" for i in count])
        axes.annotate(
            f"{number_of(n_components, 'component')}: {share[n_components - 1]:.1f} %",
            (n_components, share[n_components - 1]),
            (n_components + 3, max(share[n_components - 1] - 30, 5)),
            arrowprops={"arrowstyle": "->", "color": VERMILION},
            color=VERMILION,
            backgroundcolor="white",
        )
        axes.set(xlabel="principal components", ylabel="cumulative variance [%]", ylim=(0, 102))
        axes.set_xticks([1, 5, 10, 15, 22])
    return figure

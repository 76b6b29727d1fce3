"""The free constant of chi: directions do not determine it, phi does depend on it."""

import numpy as np

from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.reproducible import dots, log, powers
from handsim.types import Array

_PHI_START = 0.9  # greatest phi at a recorded start


def levelled(
    chi: TensorBSpline, navigation: NavigationFunction, starts: Array, goals: Array
) -> TensorBSpline:
    """Add the constant to chi with which phi <= 0.9 at all starts.

    phi = 0.9 where chi - ln gamma_d = ln(0.9**-k - 1) / k. The splines sum to one, so a constant
    added to all coefficients is added to chi.

    Parameters
    ----------
    chi
    navigation
        Its metric and exponent are used.
    starts, goals : (N, n) [rad]
        A start at its goal does not count.
    """
    away = starts - goals
    gamma = dots(dots(navigation.metrics(goals), away[:, None]), away)
    use = gamma > 0.0
    if not use.any():
        return chi
    level = log(powers(np.array([1.0 / _PHI_START]), navigation.k) - 1.0)[0] / navigation.k
    shift = level - np.min(chi.jets(starts[use], 0)[0] - log(gamma[use]))
    return TensorBSpline(chi.basis, chi.coefficients + shift)

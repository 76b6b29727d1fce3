"""How a minimisation went, iteration by iteration."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handsim.types import Array


class Iteration(NamedTuple):
    """Results of one iteration: cost, norm of its gradient, length of the step."""

    cost: float
    gradient_norm: float
    change: float


@dataclass(frozen=True)
class History:
    """Convergence of a fit, one entry for each iteration (the panels of the paper's Fig. 3).

    Attributes
    ----------
    cost, gradient_norm, change : (n_iterations,)
        Cost, norm of its gradient, norm of the change of the coefficients.
    """

    cost: Array
    gradient_norm: Array
    change: Array

    @classmethod
    def of(cls, iterations: Sequence[Iteration]) -> "History":
        """Return the history of iterations in their order."""
        return cls(*np.array(iterations, dtype=float).reshape(-1, 3).T)

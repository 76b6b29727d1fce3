"""The rivals by name, a line each: add one here."""

from collections.abc import Callable, Mapping
from functools import partial

from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.pde.learner import PDELearner

from .methods.kernel_mean import KernelMean
from .methods.lpv_ds import LinearParameterVarying
from .methods.navigation import NavigationField
from .methods.path_process import KNOWN, UNKNOWN, PathProcess
from .methods.primitive import MovementPrimitive
from .methods.regression import MixtureRegression, ProcessRegression
from .methods.straight import StraightLine
from .protocol import Rival

Rivals = Mapping[str, Callable[[], Rival]]
"""What makes a rival that is not fitted yet, by name."""


def _ours(**options: object) -> Callable[[], Rival]:
    return partial(NavigationField, partial(DirectionLearner, **options))


RIVALS: Rivals = {
    "straight line": StraightLine,
    "movement primitive of the nearest destination": partial(MovementPrimitive, by_object=False),
    "movement primitive of another trial of the object": partial(MovementPrimitive, by_object=True),
    "mixture regression of velocity": MixtureRegression,
    "process regression of velocity": ProcessRegression,
    "LPV-DS": partial(LinearParameterVarying, by_object=False),
    "LPV-DS of each object": partial(LinearParameterVarying, by_object=True),
    "kernel mean of paths": KernelMean,
    "kernel mean of paths, object known": partial(KernelMean, across=0.2),
    "process of paths": partial(PathProcess, UNKNOWN),
    "process of paths, object known": partial(PathProcess, KNOWN),
    "the paper's learner": partial(NavigationField, PDELearner),
    "ours, free": _ours(),
    "ours, certified": _ours(certified=True),
}
"""What the table compares. A rival that does not say *object known* is not told the object."""

VARIANTS: Rivals = {
    "as it is": _ours(),
    "gamma_d of the paper": _ours(metric_ridge=None),
    "recordings as they are": _ours(averaging=0.0),
    "both as in the paper": _ours(metric_ridge=None, averaging=0.0),
    "averaged over twice the reach": _ours(averaging=0.5),
    "metric ridge x 10": _ours(metric_ridge=1e-2),
    "metric ridge / 10": _ours(metric_ridge=1e-4),
    "no refinement by roll-out": _ours(n_refinements=0),
    "2 refinements": _ours(n_refinements=2),
    "8 refinements": _ours(n_refinements=8),
    "no descent condition": _ours(descent=0.0),
    "smoothness x 5": _ours(smoothness=2.5e-4),
    "smoothness / 5": _ours(smoothness=1e-5),
    "knots by variance (the paper)": _ours(knot_rule="variance"),
    "knots by deviation": _ours(knot_rule="deviation"),
    "equal knots": _ours(knot_rule="equal"),
    "3072 coefficients": _ours(shape=(16, 16, 12)),
    "certified": _ours(certified=True),
}
"""Ours, one setting changed at a time."""

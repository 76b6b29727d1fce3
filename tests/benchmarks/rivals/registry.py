"""The rivals by name, a line each: add one here."""

from collections.abc import Callable, Mapping
from functools import partial

from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.guide.predictor import GuideSettings

from .methods.any_data import AnyData
from .methods.kernel_mean import KernelMean
from .methods.lpv_ds import LinearParameterVarying
from .methods.navigation import OurController, PaperField
from .methods.path_process import KNOWN, UNKNOWN, PathProcess
from .methods.primitive import MovementPrimitive
from .methods.regression import MixtureRegression
from .methods.straight import StraightLine
from .protocol import Rival

Rivals = Mapping[str, Callable[[], Rival]]
"""What makes a rival that is not fitted yet, by name."""


def _flow(**options: object) -> Callable[[], Rival]:
    """Return ours without a guide: one flow for all queries, free if not asked otherwise."""
    return partial(OurController, partial(DirectionLearner, **({"certified": False} | options)))


def _guided(object_known: bool, by_progress: bool = True) -> Callable[[], Rival]:
    """Return ours with a guide, as it is learned by default where progress pays."""
    learner = partial(DirectionLearner, certified=True)
    return partial(OurController, learner, GuideSettings(progress=by_progress), object_known)


RIVALS: Rivals = {
    "straight line": StraightLine,
    "movement primitive of the nearest destination": partial(MovementPrimitive, by_object=False),
    "movement primitive of another trial, object known": partial(MovementPrimitive, by_object=True),
    "mixture regression of velocity": MixtureRegression,
    "LPV-DS": partial(LinearParameterVarying, by_object=False),
    "LPV-DS, object known": partial(LinearParameterVarying, by_object=True),
    "kernel mean of paths": KernelMean,
    "kernel mean of paths, object known": partial(KernelMean, across=0.2),
    "process of paths": partial(PathProcess, UNKNOWN),
    "process of paths, object known": partial(PathProcess, KNOWN),
    "the paper's learner": PaperField,
    "ours, any data": AnyData,
    "ours, one flow, free": _flow(),
    "ours, one flow, certified": _flow(certified=True),
    "ours, guided": _guided(object_known=False),
    "ours, guided, object known": _guided(object_known=True),
    "ours, guided without progress, object known": _guided(object_known=True, by_progress=False),
}
"""What the table compares. A rival that does not say *object known* is not told the object."""

VARIANTS: Rivals = {
    "as it is": _flow(),
    "gamma_d of the paper": _flow(metric_ridge=None),
    "recordings as they are": _flow(averaging=0.0),
    "both as in the paper": _flow(metric_ridge=None, averaging=0.0),
    "averaged over twice the reach": _flow(averaging=0.5),
    "metric ridge x 10": _flow(metric_ridge=1e-2),
    "metric ridge / 10": _flow(metric_ridge=1e-4),
    "no refinement by roll-out": _flow(n_refinements=0),
    "2 refinements": _flow(n_refinements=2),
    "8 refinements": _flow(n_refinements=8),
    "no descent condition": _flow(descent=0.0),
    "smoothness x 5": _flow(smoothness=2.5e-4),
    "smoothness / 5": _flow(smoothness=1e-5),
    "knots by variance (the paper)": _flow(knot_rule="variance"),
    "knots by deviation": _flow(knot_rule="deviation"),
    "equal knots": _flow(knot_rule="equal"),
    "3072 coefficients": _flow(shape=(16, 16, 12)),
    "certified": _flow(certified=True),
}
"""Ours without a guide, one setting changed at a time."""

"""From recordings to a controller, in one call."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from handsim.errors import InputError
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.options import Method, learner_with, options_of
from handsim.learning.pde.learner import PDELearner
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.function import check_exponent
from handsim.recordings.folder import RecordingSet
from handsim.types import Progress


class Learned(NamedTuple):
    """A controller and how learning it went.

    Attributes
    ----------
    controller
    summary
        ``method, n_recordings, n_components, variance_explained, n_coefficients, iterations,
        seconds, cost_start, cost_end, certified, options``; for ``pde`` also ``positive`` and
        ``closed``, whether Eqs. (4) and (5) of the paper hold.
    """

    controller: GraspController
    summary: dict[str, Any]


def learn_controller(
    recordings: RecordingSet,
    n_components: int = 3,
    method: Method = "direction",
    k: float | None = None,
    certified: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
    *,
    options: Mapping[str, Any] | None = None,
) -> Learned:
    """Learn subspace and navigation function from recordings.

    Parameters
    ----------
    recordings
    n_components
        Dimensions of the subspace, 1 to 5.
    method
        ``direction`` (default) or ``pde``, the paper's.
    k
        Exponent, at least 2; by default 4 for ``direction`` and 2 for ``pde``.
    certified
        Learn with the descent condition as a constraint.
    seed
        Of the random samples; same seed, same bits.
    progress
        Called with the fraction done.
    options
        Further options of the learner (`DirectionLearner`, `PDELearner`), by name. They stand
        above ``k``, ``certified`` and ``seed``.

    Raises
    ------
    InputError
        If the recordings vary too little, or a parameter is out of its range.
    UnknownNameError
        If there is no such method.
    """
    asked: dict[str, Any] = {"seed": seed}
    if certified:
        if method != "direction":
            raise InputError(f"method {method} cannot be certified; choose direction")
        asked["certified"] = True
    if k is not None:
        asked["k"] = k
    learner = learner_with(method, asked | dict(options or {}))
    check_exponent(learner.k)
    subspace = PostureSubspace(n_components).fit(np.vstack([r.q for r in recordings]))
    paths = [subspace.transform(r.q) for r in recordings]
    learner.fit(paths, progress=progress)
    controller = GraspController(
        subspace=subspace,
        navigation=learner.navigation_,
        demonstrations=demonstrations_of(recordings, subspace),
        method=method,
        certified=bool(getattr(learner, "certified", False)),
        options=options_of(learner),
    )
    summary = {
        "method": method,
        "n_recordings": len(recordings),
        "n_components": n_components,
        "variance_explained": float(subspace.explained_variance_ratio_.sum()),
        "n_coefficients": learner.n_coefficients_,
        "iterations": learner.n_iterations_,
        "seconds": learner.seconds_,
        "cost_start": learner.cost_start_,
        "cost_end": learner.cost_end_,
        "certified": controller.certified,
        "options": dict(controller.options),
    }
    if isinstance(learner, PDELearner):
        summary |= {"positive": learner.positive_, "closed": learner.closed_}
    return Learned(controller, summary)


def learn_like(learned: GraspController, recordings: RecordingSet) -> GraspController:
    """Learn from other recordings in the way in which ``learned`` was learned."""
    n, method = learned.navigation.n_dimensions, learned.method
    return learn_controller(recordings, n, method, options=learned.options).controller

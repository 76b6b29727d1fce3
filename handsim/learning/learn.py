"""From recordings to a controller, in one call."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.learning.controller import GraspController, demonstrations_of
from handsim.learning.direction_fit import DirectionLearner
from handsim.learning.navigation import check_exponent
from handsim.learning.pde_fit import PDELearner
from handsim.learning.subspace import PostureSubspace
from handsim.motion.recording import RecordingSet

Method = Literal["direction", "pde"]

METHODS: tuple[Method, ...] = ("direction", "pde")
DEFAULT_K = {"direction": 4.0, "pde": 2.0}


class Learned(NamedTuple):
    """A controller and how learning it went.

    Attributes
    ----------
    controller
    summary
        ``method, n_recordings, n_components, variance_explained, n_coefficients, iterations,
        seconds, cost_start, cost_end``; for ``pde`` also ``positive`` and ``closed``, whether
        Eqs. (4) and (5) of the paper hold.
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
    progress: Callable[[float], None] | None = None,
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

    Raises
    ------
    InputError
        If the recordings vary too little, or a parameter is out of its range.
    """
    if method not in METHODS:
        raise UnknownNameError("method", method, METHODS)
    if certified and method != "direction":
        raise InputError(f"method {method} cannot be certified; choose direction")
    if k is not None:
        check_exponent(k)
    subspace = PostureSubspace(n_components).fit(np.vstack([r.q for r in recordings]))
    exponent = DEFAULT_K[method] if k is None else k
    paths = [subspace.transform(r.q) for r in recordings]
    if method == "pde":
        learner = PDELearner(k=exponent, seed=seed).fit(paths, progress=progress)
    else:
        learner = DirectionLearner(k=exponent, certified=certified, seed=seed).fit(paths, progress)
    controller = GraspController(
        subspace=subspace,
        navigation=learner.navigation_,
        demonstrations=demonstrations_of(recordings, subspace),
        method=method,
        certified=certified,
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
    }
    if isinstance(learner, PDELearner):
        summary |= {"positive": learner.positive_, "closed": learner.closed_}
    return Learned(controller, summary)


def learn_like(learned: GraspController, recordings: RecordingSet) -> GraspController:
    """Learn from other recordings in the way in which ``learned`` was learned."""
    return learn_controller(
        recordings,
        n_components=learned.navigation.n_dimensions,
        method=learned.method,  # pyright: ignore[reportArgumentType]
        k=learned.navigation.k,
        certified=learned.certified,
    ).controller

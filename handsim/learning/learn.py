"""From recordings to a controller, in one call."""

import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any, cast

import numpy as np

from handsim.errors import InputError
from handsim.learning.base import Learner
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.options import (
    Method,
    Options,
    is_foreign,
    learner_with,
    method_of,
    options_of,
)
from handsim.learning.pde.learner import PDELearner
from handsim.learning.subspace import PostureSubspace
from handsim.recordings.plausibility import PlausibilityWarning, check_plausible, lines_of
from handsim.recordings.recording import RecordingSet
from handsim.result import Result, in_lines, plain
from handsim.types import Progress


@dataclass(frozen=True)
class Learned(Result):
    """A controller and how learning it went.

    Attributes
    ----------
    controller
    summary
        ``method, n_recordings, n_components, variance_explained, n_coefficients, iterations,
        seconds, cost_start, cost_end, certified, options``; for ``pde`` also ``positive`` and
        ``closed``, whether Eqs. (4) and (5) of the paper hold. None stands for what a learner of
        another package does not say.
    """

    controller: GraspController
    summary: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Return the summary, as `handsim learn --json` says it."""
        return plain(self.summary)

    def __str__(self) -> str:
        """Return the summary, an entry a line."""
        return in_lines(self.summary)


def learn_controller(
    recordings: RecordingSet,
    n_components: int = 3,
    method: Method | Learner = "direction",
    k: float | None = None,
    certified: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
    *,
    options: Mapping[str, Any] | None = None,
    accept: Collection[str] = (),
) -> Learned:
    """Learn subspace and navigation function from recordings.

    Parameters
    ----------
    recordings
    n_components
        Dimensions of the subspace, 1 to 5.
    method
        ``direction`` (default) or ``pde``, the paper's; or a learner, which is then fitted.
    k
        Exponent, at least 2; by default 4 for ``direction`` and 2 for ``pde``.
    certified
        Learn with the descent condition as a constraint.
    seed
        Of the random samples; same seed, same bits.
    progress
        Called with the fraction done.
    options
        Further options of the learner (`DirectionLearner`, `PDELearner`), by name. They take
        precedence over ``k``, ``certified`` and ``seed``.
    accept
        Kinds of anomalies of the recordings that are right all the same
        (`handsim.recordings.plausibility.KINDS`); the controller keeps them.

    Raises
    ------
    ImplausibleError
        If the recordings cannot be what they say, such as degrees or seconds.
    InputError
        If the recordings vary too little, a parameter is out of its range, or both a learner and
        options are given.
    UnknownNameError
        If there is no such method or kind of anomaly.

    Warns
    -----
    PlausibilityWarning
        If something about the recordings is unlikely to be right.
    """
    for line in lines_of(check_plausible(recordings, accept)):
        warnings.warn(line, PlausibilityWarning, stacklevel=2)
    if isinstance(method, str):
        learner = _asked_for(method, k, certified, seed, options or {})
    else:
        learner = method
        if k is not None or certified or seed or options:
            raise InputError(f"options beside {learner!r}; give them to the learner itself")
    kept = options_of(learner)
    subspace = PostureSubspace(n_components).fit(np.vstack([r.q for r in recordings]))
    paths = [subspace.transform(r.q) for r in recordings]
    began = perf_counter()
    learner.fit(paths, [r.time for r in recordings], progress=progress)
    seconds = perf_counter() - began
    return _learned(recordings, subspace, learner, kept, tuple(sorted(accept)), seconds)


def _learned(
    recordings: RecordingSet,
    subspace: PostureSubspace,
    learner: Learner,
    kept: Options,
    accepted: tuple[str, ...],
    seconds: float,
) -> Learned:
    """Put together what a fitted learner found, with the options that it was asked with."""
    controller = GraspController(
        subspace=subspace,
        navigation=learner.navigation_,
        demonstrations=demonstrations_of(recordings, subspace),
        method=method_of(learner),
        certified=bool(getattr(learner, "certified", False)),
        options=kept,
        accepted=accepted,
    )
    summary = {
        "method": controller.method,
        "n_recordings": len(recordings),
        "n_components": controller.navigation.n_dimensions,
        "variance_explained": float(subspace.explained_variance_ratio_.sum()),
        "n_coefficients": getattr(learner, "n_coefficients_", None),
        "iterations": getattr(learner, "n_iterations_", None),
        "seconds": getattr(learner, "seconds_", seconds),
        "cost_start": getattr(learner, "cost_start_", None),
        "cost_end": getattr(learner, "cost_end_", None),
        "certified": controller.certified,
        "options": dict(controller.options),
    }
    if isinstance(learner, PDELearner):
        summary |= {"positive": learner.positive_, "closed": learner.closed_}
    return Learned(controller, summary)


def learn_like(
    learned: GraspController, recordings: RecordingSet, learner: Learner | None = None
) -> GraspController:
    """Learn from other recordings in the way in which ``learned`` was learned.

    Parameters
    ----------
    learned
    recordings
    learner
        What ``learned`` was learned with. It has to be given where its class is of another package,
        of which the controller holds the name alone. A copy of it is fitted.

    Raises
    ------
    InputError
        If ``learned`` was learned by another method than that of ``learner``, or by one of another
        package and no learner is given.
    """
    n, method = learned.navigation.n_dimensions, learned.method
    if learner is not None:
        if method_of(learner) != method:
            raise InputError(f"{learner!r} is not of method {method}; give a learner of that class")
        from sklearn.base import clone

        copy = cast(Learner, clone(learner))
    elif is_foreign(method):
        raise InputError(
            f"the controller was learned by {method}, which is not part of handsim; give "
            "learn_like such a learner"
        )
    else:
        copy = learner_with(cast(Method, method), learned.options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)  # they were said the first time
        return learn_controller(recordings, n, copy, accept=learned.accepted).controller


def _asked_for(
    method: Method, k: float | None, certified: bool, seed: int, options: Options
) -> Learner:
    """Return the learner of a method; options take precedence over the other parameters."""
    asked: dict[str, Any] = {"seed": seed}
    if certified:
        if method != "direction":
            raise InputError(f"method {method} cannot be certified; choose direction")
        asked["certified"] = True
    if k is not None:
        asked["k"] = k
    return learner_with(method, asked | dict(options))

"""From recordings to a controller, in one call."""

import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, cast

import numpy as np

from handsim.errors import InputError
from handsim.joints import LOWER, UPPER
from handsim.learning.base import Learner
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.guide.choice import LeftOut, asked_of_progress
from handsim.learning.guide.predictor import GuideSettings
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
from handsim.types import Array, Progress


@dataclass(frozen=True)
class Learned(Result):
    """A controller and how learning it went.

    Attributes
    ----------
    controller
    summary
        ``method, n_recordings, n_components, variance_explained, n_coefficients, iterations,
        seconds, cost_start, cost_end, certified, guided, by_progress, left_out, options``; for
        ``pde`` also ``positive`` and ``closed``, whether Eqs. (4) and (5) of the paper hold. None
        stands for what a learner of another package does not say. ``by_progress`` is whether
        progress is a coordinate of the field, ``left_out`` what spoke for it (`LeftOut`); both are
        None without a guide.
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
    certified: bool | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    *,
    options: Mapping[str, Any] | None = None,
    accept: Collection[str] = (),
    guided: bool | None = None,
    by_progress: bool | None = None,
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
        Learn with the descent condition as a constraint, so that every destination inside the
        closing layer is proven to be reached from everywhere; by default wherever the learner can.
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
    guided
        Predict a path for each query and lead along it (`handsim.learning.guide`); by default with
        ``direction``. Otherwise the flow learned is followed, which knows of the destination alone.
    by_progress
        Take progress as a coordinate of the field that leads along the guide; by default if guides
        to recordings left out are at least as near with it (`handsim.learning.guide.choice`).

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
        if k is not None or certified is not None or seed or options:
            raise InputError(f"options beside {learner!r}; give them to the learner itself")
    guide = _guide_for(learner, guided, by_progress)
    kept = options_of(learner)
    subspace = PostureSubspace(n_components).fit(np.vstack([r.q for r in recordings]))
    paths = [subspace.transform(r.q) for r in recordings]
    began = perf_counter()
    learner.fit(paths, [r.time for r in recordings], progress=progress)
    seconds = perf_counter() - began
    learned = _learned(recordings, subspace, learner, kept, tuple(sorted(accept)), guide, seconds)
    return learned if guide is None else _with_choice(learned, guide, by_progress)


def _guide_for(
    learner: Learner, guided: bool | None, by_progress: bool | None
) -> GuideSettings | None:
    """Return how queries are guided; a guide needs the closing layer of a direction fit."""
    possible = isinstance(learner, DirectionLearner)
    if guided and not possible:
        raise InputError(f"no guide is known for {learner!r}; choose method direction")
    guide = GuideSettings() if possible and guided is not False else None
    if guide is None and by_progress is not None:
        raise InputError(f"by_progress = {by_progress} without a guide; leave one out")
    return guide


def _with_choice(learned: Learned, guide: GuideSettings, by_progress: bool | None) -> Learned:
    """Choose whether progress is a coordinate where nobody did, and keep what spoke for it."""
    left_out = LeftOut.of(learned.controller.demonstrations, guide)
    chosen = left_out.progress_pays if by_progress is None else by_progress
    guide = replace(guide, progress=chosen)
    controller = replace(learned.controller, guide=guide, left_out=left_out)
    said = {"by_progress": chosen, "left_out": vars(left_out)}
    return Learned(controller, learned.summary | said)


def fitted_ranges(recordings: RecordingSet) -> Array:
    """Return the ranges of motion (2, 22) [rad] of a person.

    They are those of the joints, made wider where the recordings leave them: what a person was
    recorded to do is no error.
    """
    q = np.vstack([r.q for r in recordings])
    return np.array([np.minimum(LOWER, q.min(axis=0)), np.maximum(UPPER, q.max(axis=0))])


def _learned(
    recordings: RecordingSet,
    subspace: PostureSubspace,
    learner: Learner,
    kept: Options,
    accepted: tuple[str, ...],
    guide: GuideSettings | None,
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
        guide=guide,
        ranges=fitted_ranges(recordings),
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
        "guided": controller.guide is not None,
        "by_progress": None,
        "left_out": None,
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
        guide = learned.guide
        asked = None if guide is None else asked_of_progress(guide, learned.left_out)
        found = learn_controller(
            recordings, n, copy, accept=learned.accepted, guided=guide is not None,
            by_progress=asked,
        )  # fmt: skip
    return found.controller


def _asked_for(
    method: Method, k: float | None, certified: bool | None, seed: int, options: Options
) -> Learner:
    """Return the learner of a method; options take precedence over the other parameters."""
    asked: dict[str, Any] = {"seed": seed}
    if method == "direction":
        asked["certified"] = certified is not False
    elif certified:
        raise InputError(f"method {method} cannot be certified; choose direction")
    if k is not None:
        asked["k"] = k
    return learner_with(method, asked | dict(options))

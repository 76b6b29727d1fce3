"""Settings of learners as a controller keeps them, so that it can be learned again.

Options are what a learner's constructor takes, by name: numbers, words, switches, None, or tuples
of numbers.
"""

import inspect
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.pde.learner import PDELearner

Method = Literal["direction", "pde"]
Learner = DirectionLearner | PDELearner
Options = Mapping[str, Any]

LEARNERS: dict[Method, type[DirectionLearner] | type[PDELearner]] = {
    "direction": DirectionLearner,
    "pde": PDELearner,
}
METHODS: tuple[Method, ...] = tuple(LEARNERS)


@cache
def usual_options(method: Method) -> Options:
    """Return the options of a learner that is asked for nothing."""
    parameters = inspect.signature(LEARNERS[method]).parameters
    return {name: parameter.default for name, parameter in parameters.items()}


def options_of(learner: Learner) -> dict[str, Any]:
    """Return all options of a learner."""
    method = next(method for method, kind in LEARNERS.items() if type(learner) is kind)
    return {name: getattr(learner, name) for name in usual_options(method)}


def learner_with(method: str, options: Options) -> Learner:
    """Return a learner; options that are not given are the usual ones.

    Raises
    ------
    UnknownNameError, InputError
        As `check_options`.
    """
    return LEARNERS[_known(method)](**check_options(method, options))


def check_options(method: str, options: Options) -> dict[str, Any]:
    """Return options as the learner takes them, lists as tuples.

    Raises
    ------
    UnknownNameError
        If there is no such method.
    InputError
        If the method has no such option, or it cannot have such a value.
    """
    usual = usual_options(_known(method))
    checked = {}
    for name, value in options.items():
        if name not in usual:
            raise InputError(
                f"option {name} = {value!r} of method {method} is not known to this version; "
                "update handsim or leave it out"
            )
        taken = tuple(value) if isinstance(value, list) else value
        if not _fits(taken, usual[name]):
            raise InputError(
                f"option {name} = {value!r} of method {method}; give something like {usual[name]!r}"
            )
        checked[name] = taken
    return checked


def _known(method: str) -> Method:
    for known in METHODS:
        if method == known:
            return known
    raise UnknownNameError("method", method, METHODS)


def _fits(value: Any, usual: Any) -> bool:
    """Whether a value is of the kind of the usual one; None stands for an optional one."""
    if isinstance(usual, bool) or isinstance(value, bool):
        return isinstance(usual, bool) and isinstance(value, bool)
    if usual is None or isinstance(usual, tuple):
        numbers = isinstance(value, tuple) and all(_is_number(entry) for entry in value)
        return numbers or (usual is None and value is None)
    if isinstance(usual, str):
        return isinstance(value, str)
    return _is_number(value) or (value is None and isinstance(usual, float))


def _is_number(value: Any) -> bool:
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))
    )

"""Settings of learners as a controller keeps them, so that it can be learned again.

Options are the parameters of a learner by name: numbers, words, switches, None, or tuples of
numbers. A learner of another package is known by the name of its class, and its options are kept
as far as they are such values; to learn again with it, it has to be given.
"""

from collections.abc import Mapping
from functools import cache
from math import isfinite
from typing import Any, Literal, cast

from handsim.errors import InputError, UnknownNameError
from handsim.learning.base import Learner, fits, plain
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.pde.learner import PDELearner

Method = Literal["direction", "pde"]
Options = Mapping[str, Any]

LEARNERS: dict[Method, type[DirectionLearner] | type[PDELearner]] = {
    "direction": DirectionLearner,
    "pde": PDELearner,
}
METHODS: tuple[Method, ...] = tuple(LEARNERS)


@cache
def usual_options(method: Method) -> Options:
    """Return the options of a learner that is asked for nothing."""
    return LEARNERS[method]().get_params()


def method_of(learner: Learner) -> str:
    """Return the name of a learner's method; of one of another package, that of its class."""
    kind = type(learner)
    own = [method for method, known in LEARNERS.items() if kind is known]
    return own[0] if own else f"{kind.__module__}.{kind.__qualname__}"


def is_foreign(method: str) -> bool:
    """Return whether a method is that of a learner of another package: a class in a module."""
    return method not in METHODS and all(part for part in method.split(".")) and "." in method


def options_of(learner: Learner) -> dict[str, Any]:
    """Return the options of a learner.

    All of them, if it is a learner of this package; else those that can be written to a file.

    Raises
    ------
    InputError
        If a learner of this package has an option of a kind that it cannot have.
    """
    options, method = learner.get_params(deep=False), method_of(learner)
    if method in METHODS:
        return check_options(method, options)
    return {name: value for name, value in plain(options).items() if _can_be_kept(value)}


def learner_with(method: str, options: Options) -> DirectionLearner | PDELearner:
    """Return a learner; options that are not given are the usual ones.

    Raises
    ------
    UnknownNameError, InputError
        As `check_options`.
    """
    return LEARNERS[_known(method)](**check_options(method, options))


def check_options(method: str, options: Options) -> dict[str, Any]:
    """Return options as the learner takes them: lists as tuples, numbers of numpy as Python's.

    Raises
    ------
    UnknownNameError
        If there is no such method.
    InputError
        If the method has no such option, or it cannot have such a value.
    """
    known = LEARNERS[_known(method)].parameters()
    for name, value in options.items():
        if name not in known:
            raise InputError(
                f"option {name} = {value!r} of method {method} is not known to this version; "
                "update handsim or leave it out"
            )
        if not fits(value, known[name]):
            raise InputError(
                f"option {name} = {value!r} of method {method}; "
                f"give something like {known[name].default!r}"
            )
    return plain(options)


def _known(method: str) -> Method:
    for known in METHODS:
        if method == known:
            return known
    raise UnknownNameError("method", method, METHODS)


def _can_be_kept(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(_can_be_kept(entry) for entry in cast(tuple[Any, ...], value))
    return (
        value is None
        or isinstance(value, str | int)
        or (isinstance(value, float) and isfinite(value))
    )

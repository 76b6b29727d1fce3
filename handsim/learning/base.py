"""What a learner is, and how it keeps scikit-learn's contract.

`Learner` says what `learn_controller` needs of a learner. `Estimator` gives a class the part of
scikit-learn's contract that concerns parameters: they are stored by the constructor, read and
changed by name, shown by ``repr``, and checked by ``fit``; what ``fit`` learns has names that end
in ``_``. `sklearn.base.clone`, pipelines and searches over parameters work with such a class.

`Estimator` does not derive from `sklearn.base.BaseEstimator`, because importing scikit-learn takes
a second, and every program that loads a controller imports the learners.
"""

import inspect
from collections.abc import Mapping, Sequence
from numbers import Integral
from types import NoneType
from typing import TYPE_CHECKING, Any, Protocol, Self, cast, get_args

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.navigation.function import NavigationFunction
from handsim.types import Array, Progress

if TYPE_CHECKING:
    from sklearn.utils import Tags


class Learner(Protocol):
    """A learner of navigation functions: what `learn_controller` needs of an object.

    It has scikit-learn's contract (derive from `Estimator` or `sklearn.base.BaseEstimator`).

    The summary of learning further takes ``n_coefficients_``, ``n_iterations_``, ``cost_start_``
    and ``cost_end_`` where ``fit`` sets them.

    Attributes
    ----------
    navigation_
        The navigation function learned; set by `fit` alone.
    """

    navigation_: NavigationFunction

    def fit(
        self,
        paths: Sequence[Array],
        times: Sequence[Array] | None = None,
        *,
        progress: Progress | None = None,
    ) -> Self:
        """Learn from recorded paths in the subspace, each ending at its destination.

        Parameters
        ----------
        paths
            (n_i, n) [rad].
        times
            (n_i,) [s], one for each path.
        progress
            Called with the fraction done.
        """
        ...

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name."""
        ...

    def set_params(self, **params: Any) -> Self:
        """Change parameters by name."""
        ...


class Estimator:
    """Base of classes with ``fit``: parameters as in scikit-learn.

    A subclass has a constructor whose parameters all have defaults, and which stores them
    unchanged under their names. Its ``fit`` begins with `check_parameters`.

    Examples
    --------
    >>> from sklearn.base import clone
    >>> class Scaled(Estimator):
    ...     def __init__(self, factor: float = 1.0, word: str = "one") -> None:
    ...         self.factor, self.word = factor, word
    >>> Scaled(factor=2.0)
    Scaled(factor=2.0)
    >>> clone(Scaled(factor=2.0)).set_params(word="two").get_params()
    {'factor': 2.0, 'word': 'two'}
    """

    @classmethod
    def parameters(cls) -> Mapping[str, inspect.Parameter]:
        """Return the parameters of the constructor."""
        return inspect.signature(cls).parameters

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name.

        Parameters
        ----------
        deep
            Without effect, since no parameter is itself an estimator; scikit-learn passes it.
        """
        return {name: getattr(self, name) for name in self.parameters()}

    def set_params(self, **params: Any) -> Self:
        """Change parameters by name; they are checked by ``fit``.

        Raises
        ------
        InputError
            If there is no such parameter.
        """
        known = self.parameters()
        for name in params:
            if name not in known:
                kind = type(self).__name__
                raise InputError(f"{kind} has no parameter {name}; give one of {', '.join(known)}")
        for name, value in params.items():
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        """Return the call that makes such an object, with the parameters that are no defaults."""
        usual = self.parameters()
        shown = [
            f"{name}={value!r}"
            for name, value in self.get_params().items()
            if not _same(value, usual[name].default)
        ]
        return f"{type(self).__name__}({', '.join(shown)})"

    def check_parameters(
        self,
        least: Mapping[str, float] | None = None,
        among: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        """Check that each parameter is of the kind of its default, and in its range.

        Parameters
        ----------
        least
            The least value of some parameters, by name. A parameter that is None has no value.
        among
            The words that others can be.

        Raises
        ------
        InputError
            If one is of another kind or less than its least.
        UnknownNameError
            If one is no such word.
        """
        kind = type(self).__name__
        for name, parameter in self.parameters().items():
            value = getattr(self, name)
            if not fits(value, parameter):
                raise InputError(
                    f"{name} = {value!r} of {kind}; give something like {parameter.default!r}"
                )
        for name, bound in (least or {}).items():
            value = getattr(self, name)
            if value is not None and value < bound:
                raise InputError(f"{name} = {value!r} of {kind}; give {bound!r} or more")
        for name, words in (among or {}).items():
            if getattr(self, name) not in words:
                raise UnknownNameError(name, getattr(self, name), words)

    def __sklearn_tags__(self) -> "Tags":
        """Return what scikit-learn wants to know of an estimator."""
        from sklearn.utils import InputTags, Tags, TargetTags

        return Tags(
            estimator_type=None, target_tags=TargetTags(required=False), input_tags=InputTags()
        )

    if not TYPE_CHECKING:  # a type checker would take every name for an attribute

        def __getattr__(self, name: str) -> Any:
            """Raise NotFittedError for what ``fit`` has yet to set.

            It is an AttributeError, so that `hasattr` says False.
            """
            if name.endswith("_") and not name.startswith("_"):
                from handsim.learning._not_fitted import NotFittedError

                raise NotFittedError(f"{type(self).__name__} has no {name} yet; call fit first")
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


def fits(value: Any, parameter: inspect.Parameter) -> bool:
    """Return whether a value is of the kind of the default of a parameter.

    Kinds are bools, words, whole numbers, real numbers and sequences of numbers, all finite. None
    is of the kind of a parameter whose annotation allows it; one whose default is None is
    a sequence of numbers otherwise.
    """
    usual = parameter.default
    if value is None:
        return usual is None or NoneType in get_args(parameter.annotation)
    if isinstance(usual, bool) or isinstance(value, bool):
        return isinstance(usual, bool) and isinstance(value, bool)
    if usual is None or isinstance(usual, tuple):
        entries = cast(Sequence[Any], value if isinstance(value, tuple | list) else [None])
        return all(_is_number(entry) for entry in entries)
    if isinstance(usual, str):
        return isinstance(value, str)
    return _is_number(value) and (isinstance(value, Integral) or isinstance(usual, float))


def check_paths(paths: Sequence[Array]) -> list[Array]:
    """Return recorded paths (n_i, n) as arrays of floats.

    Raises
    ------
    InputError
        If there are none, or they are not at least 2 finite points each of the same dimension.
    """
    if not len(paths):
        raise InputError("0 paths to learn from; give at least 1")
    checked = [np.asarray(path, dtype=float) for path in paths]
    n = checked[0].shape[-1] if checked[0].ndim else 0
    for i, path in enumerate(checked):
        if path.ndim != 2 or len(path) < 2 or path.shape[1] != n or not np.isfinite(path).all():
            raise InputError(
                f"path {i} of shape {path.shape}; give at least 2 points of {n} finite coordinates"
            )
    return checked


def plain(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options with numbers of numpy as Python's and lists as tuples."""

    def converted(value: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(converted(entry) for entry in cast(Sequence[Any], value))
        return cast(Any, value).item() if isinstance(value, np.generic) else value

    return {name: converted(value) for name, value in options.items()}


def _is_number(value: Any) -> bool:
    number = isinstance(value, int | float | np.integer | np.floating)
    return number and not isinstance(value, bool) and bool(np.isfinite(cast(float, value)))


def _same(value: Any, usual: Any) -> bool:
    return value is usual or (type(value) is type(usual) and bool(value == usual))

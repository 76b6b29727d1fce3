"""The error of estimators that are used before ``fit``; in a module that imports scikit-learn."""

from sklearn import exceptions

from handsim.errors import HandsimError


class NotFittedError(HandsimError, exceptions.NotFittedError):
    """What ``fit`` sets was asked for before ``fit`` was called.

    As scikit-learn's own it is a ValueError and an AttributeError.
    """

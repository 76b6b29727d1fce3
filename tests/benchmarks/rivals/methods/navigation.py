"""Navigation functions: the paper's learner, and ours in all its modes."""

from collections.abc import Callable, Sequence
from typing import Self

from handsim.learning.base import Learner
from handsim.navigation.certificate import certify
from handsim.types import Array

from ..fields import Field, FieldRival
from ..protocol import Movement


class NavigationField(FieldRival):
    """The flow of a learner's navigation function, passed with the default time law.

    Parameters
    ----------
    learner
        Makes a learner that is not fitted yet.
    """

    argument = "the distance falls"

    def __init__(self, learner: Callable[[], Learner]) -> None:
        self.learner = learner

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn the obstacle, and the metric where there is one."""
        paths, times = [each.path for each in movements], [each.time for each in movements]
        self.navigation = self.learner().fit(paths, times).navigation_
        return self

    def field(self, name: str) -> Field:
        """Return the flow, whatever the object."""
        return self.navigation.directions

    def proves(self, goal: Array) -> bool:
        """Whether the certificate holds for a destination."""
        return certify(self.navigation, goal[None]).certified

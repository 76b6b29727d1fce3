"""Our learner of paths of any kind, which knows nothing of hands, objects or time."""

from collections.abc import Sequence
from typing import Self

import numpy as np

from handsim.errors import InputError
from handsim.learning.general.convergence import convergence
from handsim.learning.general.learner import NavigationLearner

from ..protocol import Motion, Movement, Query, Rival, timed


class AnyData(Rival):
    """`NavigationLearner`, passed with minimum jerk.

    Parameters
    ----------
    n_refinements
        Of the learner.
    """

    argument = "the distance falls, or cell by cell"

    def __init__(self, n_refinements: int = 4) -> None:
        self.n_refinements = n_refinements

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn one field for all movements."""
        learner = NavigationLearner(n_refinements=self.n_refinements)
        self.learner = learner.fit([each.path for each in movements])
        return self

    def predict(self, query: Query) -> Motion:
        """Follow the field."""
        try:
            path = self.learner.path(query.start, query.goal).points
        except InputError:  # the destination is refused: the hand stays where it is
            return Motion(np.array([query.start, query.start]), np.array([0.0, query.duration]))
        return timed(path, query.duration)

    def proves(self, query: Query) -> bool:
        """Whether the destination is proven, with those learned or by itself."""
        learner = self.learner
        if (learner.goals_ == query.goal).all(axis=1).any() and learner.certificate_.certified:
            return True
        scaled = (query.goal - learner.centre_) * learner.scale_
        return convergence(learner.navigation_, [scaled]).certified

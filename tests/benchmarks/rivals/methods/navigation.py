"""Navigation functions: the paper's learner, and our controllers in all their modes."""

from collections.abc import Callable, Sequence
from hashlib import sha256
from time import process_time
from typing import Self

import numpy as np

from handsim.errors import InputError
from handsim.learning.base import Learner
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import Demonstration
from handsim.learning.guide.predictor import GuideSettings
from handsim.learning.pde.learner import PDELearner
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.certificate import certify
from handsim.navigation.function import NavigationFunction
from handsim.navigation.paths import N_COMPARED, at_arc_length
from handsim.types import Array

from ..fields import Field, FieldRival
from ..protocol import PROGRESS_TIMES, Motion, Movement, Query, Rival, timed

_EVEN = np.linspace(0.0, 1.0, N_COMPARED)


class PaperField(FieldRival):
    """The paper's learner and flow, u = -grad phi, with its speeds."""

    argument = "the distance falls"

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn one obstacle for all movements."""
        paths, times = [each.path for each in movements], [each.time for each in movements]
        self.navigation = PDELearner().fit(paths, times).navigation_
        return self

    def field(self, name: str) -> Field:
        """Return the directions, which stay exact where phi is flat, whatever the object."""
        return self.navigation.directions

    def speeds(self, path: Array, query: Query) -> Array:
        """Return |grad phi|."""
        return np.linalg.norm(self.navigation.jets(path, query.goal, 1)[1], axis=1)

    def proves(self, query: Query) -> bool:
        """Whether the certificate holds for the destination."""
        return certify(self.navigation, query.goal[None]).certified


class OurController(Rival):
    """A controller as `learn_controller` makes it, of movements that are projected already.

    Parameters
    ----------
    learner
        Makes a learner that is not fitted yet.
    guide
        As of `GraspController`: predict a path for each query, or follow one flow for all.
    object_known
        Whether it is told the object.
    """

    argument = "the distance falls"

    def __init__(
        self,
        learner: Callable[[], Learner],
        guide: GuideSettings | None = None,
        object_known: bool = False,
    ) -> None:
        self.learner, self.guide, self.object_known = learner, guide, object_known

    def fit(self, movements: Sequence[Movement]) -> Self:
        """Learn the workspace and its obstacle, keep paths and progress."""
        navigation, self.saved = _learned(self.learner(), movements)
        kept = tuple(_demonstration(each) for each in movements)
        self.controller = GraspController(PostureSubspace(), navigation, kept, guide=self.guide)
        return self

    def predict(self, query: Query) -> Motion:
        """Follow the flow, with the progress over time that was learned."""
        asked = (query.start, query.goal)
        try:
            path = self.controller.path(*asked, self._grasped(query)).points
        except InputError:  # the destination is refused: the hand stays where it is
            return Motion(np.array([query.start, query.start]), np.array([0.0, query.duration]))
        law = self.controller.progress(*asked, query.duration, self._grasped(query))
        return timed(path, query.duration, law.covered(PROGRESS_TIMES * query.duration))

    def proves(self, query: Query) -> bool:
        """Whether the proof holds for the field of the query, or of the destination."""
        try:
            field = self.controller.field(query.start, query.goal, self._grasped(query))
        except InputError:
            return False
        if field is not None:
            return field.proven
        return certify(self.controller.navigation, query.goal[None]).certified

    def _grasped(self, query: Query) -> str | None:
        return query.object if self.object_known else None


_KNOWN: dict[tuple[str, str], tuple[NavigationFunction, float]] = {}


def _learned(learner: Learner, movements: Sequence[Movement]) -> tuple[NavigationFunction, float]:
    """Learn, or remember what a learner of the same kind made of the same movements.

    Modes that differ in how a controller is asked share what is learned. Also returned is the CPU
    time that remembering has saved [s].
    """
    paths, times = [each.path for each in movements], [each.time for each in movements]
    key = (repr(learner), sha256(np.vstack(paths).tobytes()).hexdigest())
    if key in _KNOWN:
        return _KNOWN[key]
    began = process_time()
    navigation = learner.fit(paths, times).navigation_
    _KNOWN[key] = navigation, process_time() - began
    return navigation, 0.0


def _demonstration(movement: Movement) -> Demonstration:
    """Keep what a controller keeps; postures and hands do not matter in the subspace."""
    unknown = np.zeros(0)
    return Demonstration(
        name="",
        task="",
        object=movement.object,
        q_start=unknown,
        q_goal=unknown,
        z_start=movement.path[0],
        z_goal=movement.path[-1],
        hand_length=0.0,
        hand_breadth=0.0,
        duration=movement.duration,
        path=at_arc_length(movement.path, _EVEN),
        progress=movement.progress,
    )

"""What both learners learn from: points, vectors wanted there, and destinations.

Both add a corridor: points displaced from the recordings, with vectors that lead back to them.
Without such points nothing makes the recorded paths attract the flow beside them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.reproducible import dots, units
from handsim.types import Array


@dataclass(frozen=True)
class FieldSamples:
    """Points, the vectors that a flow should have there, and where it should lead.

    These are the paper's experiments E = {X, U, q_d}.

    Attributes
    ----------
    points : (N, n) [rad]
    vectors : (N, n)
        Velocities, or unit vectors where the direction alone matters.
    goals : (N, n) [rad]
        Destinations.
    """

    points: Array
    vectors: Array
    goals: Array

    @classmethod
    def together(cls, parts: Sequence["FieldSamples"]) -> "FieldSamples":
        """Return all samples of one or more sets, in their order."""
        return cls(
            np.vstack([part.points for part in parts]),
            np.vstack([part.vectors for part in parts]),
            np.vstack([part.goals for part in parts]),
        )

    def __add__(self, other: "FieldSamples") -> "FieldSamples":
        """Return these samples and then the others."""
        return FieldSamples.together([self, other])

    def displaced(self, tangents: Array, aside: Array, pull: float) -> "FieldSamples":
        """Return unit vectors at points of the corridor.

        Parameters
        ----------
        tangents : (N, n)
            Unit vectors along the recordings.
        aside : (N, n) [rad]
            Displacements normal to them.
        pull : [1/rad]
            How strongly the vectors turn back: they point along tangent - pull * aside.
        """
        return FieldSamples(self.points + aside, units(tangents - pull * aside), self.goals)


def random_normals(tangents: Array, rng: np.random.Generator) -> Array:
    """Return unit vectors (N, n), each normal to a unit vector (N, n) and random otherwise."""
    # Rounded: in the tails of the normal distribution the last bit depends on the processor.
    normal = np.round(rng.normal(size=tangents.shape), 12)
    return units(normal - dots(normal, tangents)[:, None] * tangents)

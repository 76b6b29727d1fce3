"""What is known of points seen on a hand, and what comes out of a fit."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handsim.hand.kinematics import Kinematics, PointsOnHand
from handsim.joints import FINGERS
from handsim.types import Array, HandSize, Index, Mask


@dataclass(frozen=True)
class HandPoint:
    """A point fixed to one body of the hand.

    Attributes
    ----------
    name
        As in messages.
    body
        A body of `handsim.hand.skeleton`, such as ``palm`` or ``index_distal``.
    place
        Where it should be in the body's frame of a right hand: x / hand length, y and z / hand
        breadth.
    spread
        Standard deviations of where it is about that place along the body's axes [m]; 0 where it
        is known exactly.
    noise
        Standard deviation of the measurement, in which what the model cannot follow counts [m].
    """

    name: str
    body: str
    place: tuple[float, float, float]
    spread: tuple[float, float, float] = (0.0, 0.0, 0.0)
    noise: float = 0.004

    @property
    def finger(self) -> str | None:
        """The finger that carries it; None on the palm."""
        name = self.body.split("_", maxsplit=1)[0]
        return name if name in FINGERS else None


@dataclass(frozen=True)
class HandPoints:
    """m points on a hand of a given size, with the places that were learned for them.

    Attributes
    ----------
    points
    hand
        Its side is right: points of a left hand are mirrored before they are fitted.
    offset : (m, 3) [m]
        From the place that each should have, in the frame of its body.
    """

    points: tuple[HandPoint, ...]
    hand: HandSize
    offset: Array

    @classmethod
    def expected(cls, points: Sequence[HandPoint], hand: HandSize) -> "HandPoints":
        """Return the points at the places that they should have."""
        right = HandSize(hand.length, hand.breadth)
        return cls(tuple(points), right, np.zeros((len(points), 3)))

    @cached_property
    def kinematics(self) -> Kinematics:
        """The bodies of the hand."""
        return Kinematics(self.hand)

    @cached_property
    def on_hand(self) -> PointsOnHand:
        """The points with their places in metres."""
        scale = [self.hand.length, self.hand.breadth, self.hand.breadth]
        places = np.array([point.place for point in self.points]) * scale
        return self.kinematics.at([point.body for point in self.points], places + self.offset)

    @property
    def noise(self) -> Array:
        """Standard deviation of each measurement, (m,) [m]."""
        return np.array([point.noise for point in self.points])

    @property
    def spread(self) -> Array:
        """Standard deviations of each place, (m, 3) [m]."""
        return np.array([point.spread for point in self.points])

    @property
    def fingers(self) -> list[str | None]:
        """The finger of each point, None for the palm."""
        return [point.finger for point in self.points]


@dataclass(frozen=True)
class PalmPostures:
    """Angles and pose of the palm in n frames.

    Attributes
    ----------
    q : (n, 22) [rad], glove order, wrist 0
    rotation : (n, 3, 3)
        From the palm's frame to that in which the points were seen.
    position : (n, 3) [m]
        Of the wrist centre.
    """

    q: Array
    rotation: Array
    position: Array

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.q)

    @property
    def arrays(self) -> tuple[Array, Array, Array]:
        """Angles, rotations and positions."""
        return self.q, self.rotation, self.position

    def at(self, frames: slice | Index | Mask) -> "PalmPostures":
        """Return some of the frames, by slice, places or bools."""
        return PalmPostures(self.q[frames], self.rotation[frames], self.position[frames])


def are_seen(points: Array) -> Mask:
    """Return which points (n, m, 3) are seen, (n, m)."""
    return np.asarray(np.isfinite(points).all(axis=2), dtype=bool)

"""From a hand's length to the person's arm: lengths, masses, inertias, and the seat at the table.

Sources, and how sure they are
------------------------------
[1] Drillis & Contini (1966), as in Winter (2009), Biomechanics and Motor Control of Human
    Movement, 4th ed., Fig. 4.1: hand 0.108, forearm 0.146, upper arm 0.186 of stature. High
    confidence for the mean; single people differ by some 5 %.
[2] Winter, Table 4.1 (after Dempster): upper arm 0.028 and forearm 0.016 of body mass, centre of
    mass at 0.436 and 0.430 of the length from the proximal end, radius of gyration about it 0.322
    and 0.303 of the length, densities 1070 and 1130 kg/m3. High confidence.
[3] Body mass from stature at a body mass index of 25 kg/m2, between the 27.7 of soldiers (ANSUR II,
    85.5 kg at 1.756 m) and the 22 of young volunteers. Medium confidence for a person.
[4] Pheasant & Haslegrave (2006), Bodyspace, 3rd ed., British adults: biacromial breadth 400 mm of
    1740 mm for men, 355 of 1610 for women; the joint lies some 15 mm inside the acromion. Work is
    done at the height of the elbow or a little above. Medium confidence.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handsim.hand.anthropometry import HandGeometry
from handsim.types import MEDIAN_HAND, Array, HandSize

HAND_OF_STATURE, FOREARM_OF_STATURE, UPPER_ARM_OF_STATURE = 0.108, 0.146, 0.186  # [1]
BODY_MASS_INDEX = 25.0  # [3] [kg/m2]
SHOULDER_OF_STATURE = 0.105
"""From the middle of the body to the shoulder joint, / stature [4]."""


@dataclass(frozen=True)
class SegmentInertia:
    """Mass and inertia of a segment that reaches from the origin along -z.

    Attributes
    ----------
    mass
        [kg]
    centre
        From the proximal joint to the centre of mass along the segment [m].
    across, along
        Moments of inertia about the centre of mass [kg m2].
    """

    mass: float
    centre: float
    across: float
    along: float

    def without(self, part: "SegmentInertia") -> "SegmentInertia":
        """Return what is left when a part, whose mass is counted elsewhere, is taken out."""
        mass = self.mass - part.mass
        centre = (self.mass * self.centre - part.mass * part.centre) / mass
        across = (
            self.across
            - mass * (centre - self.centre) ** 2
            - part.across
            - part.mass * (part.centre - self.centre) ** 2
        )
        return SegmentInertia(mass, centre, across, self.along - part.along)


@dataclass(frozen=True)
class Seat:
    """Where a person sits at the table, in parts of stature.

    World frame: table top at z = 0, the person at -x looks to +x, right is -y.

    Attributes
    ----------
    distance
        From the origin, near which things are grasped, back to the line of the shoulders. A quarter
        of stature leaves the elbow at a right angle when the hand is there, as in the zone in which
        people put what they work on.
    height
        Of the shoulders above the table. As long as the upper arm: the joint of the elbow of a
        hanging arm is then as high as the table top, its underside some 35 mm below, as advised for
        work at a desk [4].
    aside
        Of the middle of the body from y = 0 to the left.
    edge
        From the line of the shoulders ahead to the edge of the table: a chest and a hand's breadth.
    """

    distance: float = 0.25
    height: float = UPPER_ARM_OF_STATURE
    aside: float = 0.0
    edge: float = 0.085


@dataclass(frozen=True)
class ArmGeometry:
    """The arm of the person with a hand of a given size.

    Parameters
    ----------
    size
        Its length tells the stature.

    Raises
    ------
    InputError
        If such a hand cannot be built.

    Examples
    --------
    >>> arm = ArmGeometry()
    >>> round(arm.stature, 2), round(arm.upper_arm, 3), round(arm.forearm, 3)
    (1.79, 0.333, 0.261)
    """

    size: HandSize = MEDIAN_HAND

    def __post_init__(self) -> None:
        """Check that such a hand can be built."""
        HandGeometry(self.size)

    @property
    def stature(self) -> float:
        """Body height [m] [1]."""
        return self.size.length / HAND_OF_STATURE

    @property
    def body_mass(self) -> float:
        """Mass of the person [kg] [3]."""
        return BODY_MASS_INDEX * self.stature**2

    @property
    def upper_arm(self) -> float:
        """Shoulder joint to elbow joint [m] [1]."""
        return UPPER_ARM_OF_STATURE * self.stature

    @property
    def forearm(self) -> float:
        """Elbow joint to wrist centre [m] [1]."""
        return FOREARM_OF_STATURE * self.stature

    @property
    def reach(self) -> float:
        """Shoulder joint to wrist centre of the straight arm [m]."""
        return self.upper_arm + self.forearm

    @cached_property
    def upper_arm_inertia(self) -> SegmentInertia:
        """Of the upper arm [2]."""
        return _segment(0.028 * self.body_mass, self.upper_arm, 0.436, 0.322, 1070.0)

    @cached_property
    def forearm_inertia(self) -> SegmentInertia:
        """Of the whole forearm, to the wrist [2]."""
        return _segment(0.016 * self.body_mass, self.forearm, 0.430, 0.303, 1130.0)

    def shoulder(self, seat: Seat | None = None) -> Array:
        """Return where the shoulder joint is in the world, (3,) [m], of the hand's side."""
        seat = seat or Seat()
        outwards = -1.0 if self.size.side == "right" else 1.0
        place = [-seat.distance, seat.aside + outwards * SHOULDER_OF_STATURE, seat.height]
        return self.stature * np.array(place)


def _segment(
    mass: float, length: float, centre: float, gyration: float, density: float
) -> SegmentInertia:
    """Return the inertia of a segment; about its own axis that of a cylinder of its mass."""
    radius_squared = mass / (density * np.pi * length)
    return SegmentInertia(
        mass, centre * length, mass * (gyration * length) ** 2, float(mass * radius_squared / 2)
    )

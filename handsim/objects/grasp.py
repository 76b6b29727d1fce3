"""Where and how an object is held."""

from dataclasses import dataclass
from typing import Literal

from handsim.joints import Finger
from handsim.objects.object import Vec3

GraspKind = Literal["side", "top", "handle", "edge", "tripod", "rest", "loops"]


@dataclass(frozen=True)
class Grasp:
    """Where and how an object is held, in its own frame.

    Attributes
    ----------
    kind
        ``side`` or ``top`` (palm facing across or down), ``handle``, ``edge`` (thumb on one flat
        side, fingers on the other), ``tripod``, ``rest`` (palm on top, as on a mouse), ``loops``.
    point
        Midpoint between the thumb's pad and the fingers' pads [m].
    opposition
        Unit vector from the thumb's pad to the fingers' pads.
    approach
        Unit vector in which the hand comes and its palm faces.
    width
        Distance between the opposed surfaces at ``point`` [m].
    fingers
        Fingers that oppose the thumb.
    pointing
        Where the hand's distal axis points if not along ``opposition``.
    """

    kind: GraspKind
    point: Vec3
    opposition: Vec3
    approach: Vec3
    width: float
    fingers: tuple[Finger, ...]
    pointing: Vec3 | None = None

"""The moving bodies of the right hand and the axes of its 22 hinges.

Frame: as in `handsim.hand.anthropometry`. In the frame of every body x runs along the segment,
+y is the axis of flexion and +z is dorsal; all angles are zero in the flat hand.

Order of hinges in one body: flexion turns about an axis fixed in the bone before, spreading about
one that moves with the segment (the ISB's order: Wu et al. 2005, J. Biomech. 38:981-992), so that
the glove's abduction stays the angle between fingers when they are flexed. The thumb first turns
about the hand's x, from beside the palm to opposite it, then opens the web in the plane reached.
"""

from dataclasses import dataclass

import numpy as np

from handsim.hand.anthropometry import (
    LENGTHS,
    HandGeometry,
    first_segment,
    palm_body,
    segment_names,
    thumb_axes,
)
from handsim.joints import FINGERS, JOINTS, Joint
from handsim.types import Array


@dataclass(frozen=True)
class JointAxis:
    """A joint and its axis in the zero posture, a unit vector in the body's frame, (3,)."""

    joint: Joint
    axis: Array


@dataclass(frozen=True)
class Segment:
    """A moving body of the right hand in its zero posture.

    Attributes
    ----------
    name, parent
        Names of the body and of the one that carries it.
    origin
        Joint centre in the parent's frame, (3,) [m].
    axes
        Columns are the body's x, y and z in the parent's frame, (3, 3).
    hinges
        All through ``origin``, the one nearest the parent first.
    """

    name: str
    parent: str
    origin: Array
    axes: Array
    hinges: tuple[JointAxis, ...]


def segments(geometry: HandGeometry) -> tuple[Segment, ...]:
    """Return the bodies that move, parents first: the palm's two, then finger by finger."""
    bodies = [
        Segment("palm", "forearm", np.zeros(3), np.eye(3), _hinges(geometry, "palm")),
        Segment(
            "palm_ulnar", "palm", geometry.arch_origin, np.eye(3), _hinges(geometry, "palm_ulnar")
        ),
    ]
    for finger in FINGERS:
        parent = palm_body(finger)
        origin = geometry.thumb_cmc if finger == "thumb" else geometry.mcp(finger)
        origin = origin - geometry.origin_of(parent)
        axes = thumb_axes() if finger == "thumb" else np.eye(3)
        for name, fraction in zip(segment_names(finger), LENGTHS[finger], strict=True):
            bodies.append(Segment(name, parent, origin, axes, _hinges(geometry, name)))
            parent, axes = name, np.eye(3)
            origin = np.array([fraction * geometry.size.length, 0.0, 0.0])
    return tuple(bodies)


def _hinges(geometry: HandGeometry, body: str) -> tuple[JointAxis, ...]:
    order = {"rotation": 0, "flexion": 1, "arch": 1, "deviation": 2, "abduction": 2}
    joints = sorted((j for j in JOINTS if _body_of(j) == body), key=lambda j: order[j.motion])
    return tuple(JointAxis(joint, _axis(joint, geometry)) for joint in joints)


def _body_of(joint: Joint) -> str:
    if joint.finger is not None:
        return segment_names(joint.finger)[first_segment(joint)]
    return "palm_ulnar" if joint.name == "palm_arch" else "palm"


def _axis(joint: Joint, geometry: HandGeometry) -> Array:
    """Axis that a positive angle turns about, right-handed, in the frame of its body."""
    if joint.motion == "arch":
        return geometry.arch_axis
    if joint.motion == "rotation":  # from radial to palmar
        return thumb_axes().T @ [-1.0, 0.0, 0.0]
    if joint.name == "thumb_abduction":  # away from the index finger, before the rotation
        return thumb_axes().T @ [0.0, 0.0, 1.0]
    if joint.motion == "flexion":
        return np.array([0.0, 1.0, 0.0])
    ulnar = joint.finger in ("ring", "little")
    return np.array([0.0, 0.0, -1.0 if ulnar else 1.0])

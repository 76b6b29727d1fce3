"""The 5 joints of the arm above the wrist.

Their order is that of the International Society of Biomechanics (ISB), Y-X-Y at the shoulder (Wu et
al. 2005, J. Biomech. 38:981-992). The shoulder turns the upper arm about the vertical
(``shoulder_plane``), lifts it in the plane so reached (``shoulder_elevation``) and turns it about
its own axis (``shoulder_rotation``). All angles are 0 where the arm hangs with the forearm in line
and the thumb to the front. The two joints of the wrist are the hand's own (`handsim.joints`).

Angles, for a right arm; a left one is its mirror image, with the same angles:

- ``shoulder_plane``: 0 to the side, +90 deg straight ahead, -90 deg to the back;
- ``shoulder_elevation``: from hanging, 0 to 180 deg;
- ``shoulder_rotation``: positive inwards. With the plane at +90 deg it is -90 deg where the arm is
  simply lifted ahead, as the two axes of turning are one in the hanging arm;
- ``elbow_flexion``: from straight;
- ``forearm_rotation``: positive is pronation, 0 is the thumb up with the elbow at a right angle.
  The ISB counts it from full supination.

Ranges: Boone & Azen (1979), J. Bone Joint Surg. Am. 61(5):756-759, means of 109 males: shoulder
flexion 167, extension 62, abduction 184, inward rotation 69, outward 104; elbow 143; pronation 76,
supination 82 deg. Planes of elevation beyond those are horizontal adduction and abduction, 135 and
45 deg (American Academy of Orthopaedic Surgeons, 1965).
"""

from dataclasses import dataclass

import numpy as np

from handsim.joints import JOINTS
from handsim.types import Array


@dataclass(frozen=True)
class ArmJoint:
    """One hinge of the arm.

    Attributes
    ----------
    name
        Name in files, in the MJCF model and of its actuator.
    lower_deg, upper_deg
        Range of the hinge [deg]. That of the shoulder depends on where the arm is
        (`shoulder_limits`); these are the ends of all.
    """

    name: str
    lower_deg: float
    upper_deg: float


ARM_JOINTS: tuple[ArmJoint, ...] = (
    ArmJoint("shoulder_plane", -135, 150),
    ArmJoint("shoulder_elevation", 0, 180),
    ArmJoint("shoulder_rotation", -160, 105),
    ArmJoint("elbow_flexion", 0, 143),
    ArmJoint("forearm_rotation", -82, 76),
)
"""The 5 joints from the shoulder to the wrist."""

ARM_JOINT_NAMES: tuple[str, ...] = tuple(joint.name for joint in ARM_JOINTS)
N_ARM = len(ARM_JOINTS)
WRIST_JOINT_NAMES: tuple[str, ...] = ("wrist_flexion", "wrist_deviation")
"""The hand's own joints that end the chain, the proximal one first."""
CHAIN_NAMES: tuple[str, ...] = (*ARM_JOINT_NAMES, *WRIST_JOINT_NAMES)
"""The 7 joints that place the palm, shoulder first."""


def _ranges() -> tuple[Array, Array]:
    wrist = [joint for joint in JOINTS if joint.name in WRIST_JOINT_NAMES]
    lower = np.deg2rad([joint.lower_deg for joint in (*ARM_JOINTS, *wrist)])
    upper = np.deg2rad([joint.upper_deg for joint in (*ARM_JOINTS, *wrist)])
    lower.flags.writeable = upper.flags.writeable = False
    return lower, upper


CHAIN_LOWER, CHAIN_UPPER = _ranges()
"""Ends of the ranges of the 7 joints, (7,) [rad]."""

# How far the arm can be lifted in a plane [deg]: 62 to the back, 184 to the side, 167 ahead [Boone
# & Azen]; across the chest as far as horizontal adduction goes, behind the back hardly.
_PLANES = np.deg2rad([-180.0, -135.0, -90.0, -45.0, 0.0, 90.0, 135.0, 150.0, 180.0])
_HIGHEST = np.deg2rad([30.0, 45.0, 62.0, 110.0, 180.0, 167.0, 110.0, 60.0, 30.0])

# Turning about the upper arm's own axis, measured in the arm lifted to the side [Boone & Azen] and
# counted from the arm that is lifted without turning, which in the plane P is the rotation -P.
# Ahead less is left outwards and more inwards: the forearm of an arm lifted ahead can be laid
# across the chest (90 deg) and, as in the Hawkins test, some way below. Medium to low confidence.
_ROTATION_PLANES = np.deg2rad([-90.0, 0.0, 90.0, 135.0])
_OUTWARDS = np.deg2rad([-104.0, -104.0, -60.0, -45.0])
_INWARDS = np.deg2rad([69.0, 69.0, 120.0, 140.0])


def highest_elevation(plane: Array) -> Array:
    """Return how far the arm can be lifted in planes of elevation, of any shape [rad]."""
    return np.interp(plane, _PLANES, _HIGHEST)


def rotation_range(plane: Array) -> tuple[Array, Array]:
    """Return the ends of ``shoulder_rotation`` in planes of elevation, of any shape [rad].

    The plane's own turn counts against it: what the joint of a person limits is the sum of both,
    by which the upper arm is turned about its axis beyond being lifted.
    """
    outwards = np.interp(plane, _ROTATION_PLANES, _OUTWARDS)
    inwards = np.interp(plane, _ROTATION_PLANES, _INWARDS)
    return outwards - plane, inwards - plane
